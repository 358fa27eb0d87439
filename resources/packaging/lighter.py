"""Makes an environment on Linux lighter before PyInstaller looks at it.

Wheels bring more than is called here. In the place of libraries that others are linked to come
small ones of the same names: OpenCV gets NumPy's BLAS instead of one more; its FFmpeg and AVIF go,
for nothing here plays videos, and Pillow has an AVIF of its own; Pillow's X goes, for nothing here
grabs screens. Of ICU's data stays what Qt sorts by. Debug symbols go.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from .libraries import asked_for, can_be_mapped, libraries, offered, run

_BLAS: Final = Path(__file__).resolve().parent / "blas.c"
# Of OpenCV: it asks AVIF of every file whether it is one; where it gets no decoder, it isn't.
_UNUSED: Final = ("libavcodec-*", "libavformat-*", "libavif-*", "libavutil-*", "libswscale-*")
# What sorting needs: the collations, how a locale leads to one, and normal forms. Names of
# languages and zones, units, line breaks, encodings go: Qt has its own, or nothing here shows them.
_ICU_USED: Final = re.compile(
    r"coll/.*|.*\.nrm|cnvalias\.icu"
    r"|(icustd|icuver|keyTypeData|langInfo|likelySubtags|metadata|numberingSystems|pool|res_index"
    r"|root|supplementalData|timezoneTypes)\.res"
)


def lighten(site: Path) -> None:
    """Replace what is too heavy."""
    opencv, pillow = _only(site, "cv2/cv2*.so"), _only(site, "PIL/_imaging.*.so")
    with tempfile.TemporaryDirectory(prefix="kogao-lighter-") as work:
        _link(
            _only(site, "opencv_*.libs/libopenblas*"),
            _BLAS,
            others=[_only(site, "numpy.libs/libscipy_openblas64_*")],
        )
        for pattern in _UNUSED:
            _leave_out(_only(site, f"opencv_*.libs/{pattern}"), opencv, Path(work))
        _leave_out(_only(site, "pillow.libs/libxcb-*"), pillow, Path(work))
        _lighten_icu(_only(site, "PySide6/Qt/lib/libicudata.so.*"), Path(work))
        _strip(site, Path(work) / "stripped")


def _only(site: Path, pattern: str) -> Path:
    found = list(site.glob(pattern))
    if len(found) != 1:
        raise ValueError(
            f"{site} has {len(found)} of {pattern}, not one: is a wheel's version new?"
        )
    return found[0]


def _leave_out(library: Path, by: Path, work: Path) -> None:
    """Put functions that return NULL in the place of those that `by` takes from a library."""
    wanted = asked_for(by)
    names = sorted(offered(library) & wanted.keys())
    source, versions = work / "without.c", work / "without.map"
    nothing = "static void *nothing(void) { return 0; }\n"
    also = (f'void *{name}(void) __attribute__((alias("nothing")));\n' for name in names)
    source.write_text(nothing + "".join(also))
    (version,) = {wanted[name] for name in names}
    versions.write_text(f"{version} {{ global: *; }};\n")
    _link(library, source, f"-Wl,--version-script={versions}")


def _lighten_icu(library: Path, work: Path) -> None:
    (name,) = offered(library)  # icudt73_dat in version 73
    data, unused, source = work / f"{name[:-4]}l.dat", work / "unused.lst", work / "icudata.S"
    run("objcopy", "--output-target=binary", "--only-section=.rodata", library, data)
    items = run("icupkg", "--list", data).split()
    unused.write_text("\n".join(item for item in items if not _ICU_USED.fullmatch(item)))
    run("icupkg", "--remove", unused, data)
    source.write_text(
        f".section .rodata\n.balign 16\n.global {name}\n.type {name}, %object\n{name}:\n"
        f'.incbin "{data}"\n.size {name}, . - {name}\n.section .note.GNU-stack, "", %progbits\n'
    )
    _link(library, source)


def _strip(site: Path, stripped: Path) -> None:
    for library in libraries(site):
        run("strip", "--strip-unneeded", "-o", stripped, library)
        if can_be_mapped(stripped):  # strip tears apart some that patchelf has worked on
            shutil.copyfile(stripped, library)


def _link(library: Path, *what: Path | str, others: Sequence[Path] = ()) -> None:
    """Make a library anew, of sources and of others from folders beside its own."""
    places = [f"-Wl,-rpath,$ORIGIN/../{other.parent.name}" for other in others]
    library.unlink()
    run("gcc", "-shared", "-fPIC", "-O2", "-Wall", "-Werror", f"-Wl,-soname,{library.name}",
        "-Wl,-z,defs", "-Wl,--no-as-needed", "-o", library, *what, *others, *places)  # fmt: skip
