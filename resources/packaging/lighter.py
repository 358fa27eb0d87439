"""Reduce the size of an environment on Linux before PyInstaller collects files.

Stubs with the same names replace libraries that Kogao doesn't use:

- OpenCV calls NumPy's BLAS. OpenCV has no FFmpeg (videos) and no AVIF (Pillow reads AVIF).
- Pillow has no X11 (screenshots).
- ICU keeps the data for sorting.
- Debug symbols are removed.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from .libraries import can_be_mapped, exported_symbols, libraries, run, undefined_symbols

_BLAS: Final = Path(__file__).resolve().parent / "blas.c"
# Libraries of OpenCV. Without an AVIF decoder, OpenCV takes no file for AVIF.
_UNUSED: Final = ("libavcodec-*", "libavformat-*", "libavif-*", "libavutil-*", "libswscale-*")
# Data for sorting: collations, locales and normal forms. Qt has its own names of languages, time
# zones, units and encodings, or Kogao doesn't show these.
_ICU_USED: Final = re.compile(
    r"coll/.*|.*\.nrm|cnvalias\.icu"
    r"|(icustd|icuver|keyTypeData|langInfo|likelySubtags|metadata|numberingSystems|pool|res_index"
    r"|root|supplementalData|timezoneTypes)\.res"
)


def lighten(site: Path) -> None:
    """Replace the largest unused libraries by stubs."""
    opencv, pillow = _only(site, "cv2/cv2*.so"), _only(site, "PIL/_imaging.*.so")
    with tempfile.TemporaryDirectory(prefix="kogao-lighter-") as work:
        _link(
            _only(site, "opencv_*.libs/libopenblas*"),
            _BLAS,
            others=[_only(site, "numpy.libs/libscipy_openblas64_*")],
        )
        for pattern in _UNUSED:
            _stub(_only(site, f"opencv_*.libs/{pattern}"), opencv, Path(work))
        _stub(_only(site, "pillow.libs/libxcb-*"), pillow, Path(work))
        _lighten_icu(_only(site, "PySide6/Qt/lib/libicudata.so.*"), Path(work))
        _strip(site, Path(work) / "stripped")


def _only(site: Path, pattern: str) -> Path:
    found = list(site.glob(pattern))
    if len(found) != 1:
        raise ValueError(
            f"{site} has {len(found)} of {pattern}, not one: is a wheel's version new?"
        )
    return found[0]


def _stub(library: Path, by: Path, work: Path) -> None:
    """Replace a library by a stub with the functions that `by` uses; all return NULL."""
    wanted = undefined_symbols(by)
    names = sorted(exported_symbols(library) & wanted.keys())
    source, versions = work / "stub.c", work / "stub.map"
    null = "static void *null(void) { return 0; }\n"
    also = (f'void *{name}(void) __attribute__((alias("null")));\n' for name in names)
    source.write_text(null + "".join(also))
    (version,) = {wanted[name] for name in names}
    versions.write_text(f"{version} {{ global: *; }};\n")
    _link(library, source, f"-Wl,--version-script={versions}")


def _lighten_icu(library: Path, work: Path) -> None:
    (name,) = exported_symbols(library)  # icudt73_dat in version 73
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
        if can_be_mapped(stripped):  # strip damages some libraries that patchelf has changed
            shutil.copyfile(stripped, library)


def _link(library: Path, *what: Path | str, others: Sequence[Path] = ()) -> None:
    """Link a new library from sources and libraries in neighbouring folders."""
    places = [f"-Wl,-rpath,$ORIGIN/../{other.parent.name}" for other in others]
    library.unlink()
    run("gcc", "-shared", "-fPIC", "-O2", "-Wall", "-Werror", f"-Wl,-soname,{library.name}",
        "-Wl,-z,defs", "-Wl,--no-as-needed", "-o", library, *what, *others, *places)  # fmt: skip
