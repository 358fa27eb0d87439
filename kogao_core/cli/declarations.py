"""All commands of ``kogao-cli`` with their options, without numpy, OpenCV and Pillow.

`words.loads` names the function that does the work. Its module is imported when the command runs.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.base.installed import has_laboratory
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, options, words

PROGRAM: Final = "kogao-cli"
EPILOG: Final = Text("""\
Exit codes:
  0    done
  1    incomplete installation (see kogao-cli doctor)
  2    wrong usage: unknown option, value out of range, unusable recipe or
       project, existing output (overwrite with --force), or a format that
       can't hold the photo
  3    unreadable input or unwritable output
  4    no face, only doubtful faces (include these with --doubtful), or no
       face that --person names without doubt
  5    some photos of a batch failed; see the report
  6    kogao --edit was closed without saving
  7    input is a result of Kogao (accept with --results)
  70   internal error or too little memory (traceback with KOGAO_DEBUG=1)
  130  interrupted; run the same batch again to resume

An error prints one line on stderr and leaves no partial file.
""")


@words.group(
    context_settings={"help_option_names": ["-h", "--help"]},
    codes=EPILOG,
    examples=(
        "kogao-cli warp portrait.jpg -o slim.jpg",
        "kogao-cli batch photos/ -o slim/",
        "kogao-cli warp --help",
    ),
)
@words.chooses_language
@words.shows_version
def program() -> None:
    """Make faces in photos slightly smaller (method of Seo, Chen and Aoki, 2011)."""


def _lines(_: click.Context, __: click.Parameter, values: Sequence[str]) -> list[Any]:
    lines = [_corners(value) or _picture(value) for value in values]
    for value, line in zip(values, lines, strict=True):
        if isinstance(line, Path):
            continue
        if not line or any(len(corner) != 2 or not all(map(isfinite, corner)) for corner in line):
            raise words.bad_value(
                "{value} is neither a list such as '10,20 10,400' nor a picture.",
                value=shown(value),
            )
    return lines


def _corners(value: str) -> list[list[float]]:
    try:
        return [[float(part) for part in corner.split(",")] for corner in value.split()]
    except ValueError:
        return []


def _picture(value: str) -> Path | None:
    """Return the path of a mask; None without a file of that name."""
    path = Path(value)
    return path if path.suffix[1:].isalpha() or path.is_file() else None


@program.command(
    "warp",
    examples=(
        "kogao-cli warp portrait.jpg -o slim.jpg",
        "kogao-cli warp group.jpg -o slim.jpg --face 1,3 --amount 6",
        "kogao-cli warp portrait.jpg -o slim.jpg --amount 0 --jaw-width -5",
    ),
    context_settings={"allow_extra_args": True},  # for a better message
)
@options.takes_photo
@words.option(
    "-o", "--output", type=click.Path(path_type=Path, allow_dash=True), metavar="FILE",
    help=Text("Output file: {suffixes}", suffixes=", ".join(f".{one}" for one in options.FORMATS)),
)  # fmt: skip
@words.option("--in-place", is_flag=True, help="Overwrite IN; undo with kogao-cli restore")
@options.chooses
@words.option("-q", "--quiet", is_flag=True, help="Print only warnings and errors")
@words.option(
    "-v", "--verbose", is_flag=True, excludes=("-q",), help="Print measurements and timings"
)
@options.takes_points
@words.section(
    options.SURROUNDINGS,
    words.option(
        "--protect",
        "lines",
        multiple=True,
        metavar="'X,Y X,Y'|MASK.png",
        callback=_lines,
        help="Keep a line or polyline in place, px of the upright photo, or the white pixels of a "
        "grey picture of the photo's size; repeatable",
    ),
    words.option(
        "--protect-width",
        "width_px",
        type=common.Number(0.0),
        default=0.0,
        metavar="PX",
        needs="--protect",
        help="Width of the protected lines, 0 or more [0]",
    ),
)
@words.section(
    options.INPUT,
    words.option(
        "--project",
        "project_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Apply a project (PHOTO.kogao.json); works for other sizes of the photo, too",
    ),
    options.takes_results,
)
@words.section(
    options.OUTPUT,
    words.option(
        "--temporary",
        is_flag=True,
        needs="--in-place",
        help="With --in-place: IN is a temporary copy of another program; store no original",
    ),
    words.option(
        "--anyway",
        is_flag=True,
        needs="--in-place",
        help="With --in-place: if the store of originals is full, delete the oldest originals",
    ),
    words.option(
        "--save-project", is_flag=True, help="Save the edits as IN.kogao.json next to the photo"
    ),
    words.option(
        "--evidence",
        "evidence_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        callback=common.no_photo,
        help="Save displacement, lattices, domains and versions as FILE (.npz)",
    ),
    options.exports,
    common.writes_json,
)
@options.discloses
@words.option("--force", is_flag=True, help="Overwrite an existing output")
@words.loads("kogao_core.cli.warp:run")
def warp() -> None:
    """Make the faces in a photo smaller and save the result.

    IN - reads the photo from standard input; -o - writes the result to standard output.
    """


@program.command(
    "batch",
    examples=(
        "kogao-cli batch photos/ -o slim/",
        "kogao-cli batch photos/ 'more/*.jpg' -o slim/ --amount 6 --jobs 4",
        "kogao-cli batch photos/ -o web/ --longest-side 2048 --srgb --to jpg",
    ),
)
@click.argument("inputs", metavar="IN...", nargs=-1, required=True, type=common.PHOTO)
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="Folder for the results; created if missing",
)  # fmt: skip
@options.chooses
@words.option(
    "-j", "--jobs", type=common.Whole(1, 256), default=lambda: os.cpu_count() or 1,
    help="Photos processed in parallel; each needs about 8 times its pixels in memory "
    "[processors]",
)  # fmt: skip
@words.option(
    "--cluster", metavar="ADDRESS", excludes=("--jobs", "--projects"),
    help="Run on the workers of a Dask scheduler, such as tls://host:8786 [this machine]",
)  # fmt: skip
@words.option(
    "--report", type=common.FILE, metavar="FILE", section=options.OUTPUT,
    help="Report, one JSON line per photo; photos listed as done are skipped "
    "[DIR/kogao-batch.jsonl]",
)  # fmt: skip
@words.option(
    "--measures", type=common.FILE, metavar="FILE", section=options.OUTPUT,
    callback=common.no_photo,
    help="Write requested and achieved amounts and face measures (CSV), with a codebook",
)  # fmt: skip
@words.option(
    "--card", type=common.FILE, metavar="FILE.zip", section=options.OUTPUT,
    callback=common.no_photo,
    help="Write one file to cite: results, recipe, landmarks, measures, versions, licences",
)  # fmt: skip
@words.option(
    "--projects", is_flag=True, section=options.INPUT,
    help="Apply the saved edits of photos (PHOTO.kogao.json); options apply to the others",
)  # fmt: skip
@options.discloses
@options.exports
@words.option(
    "--to", "form", type=click.Choice(options.FORMATS), section=options.OUTPUT,
    help="Format of all results [format of each photo]",
)  # fmt: skip
@words.option(
    "--names", "name", metavar="PATTERN", default="{name}", section=options.OUTPUT,
    help="File names of results, with {name}, {n} (001, 002, …) and {amount} [{name}]",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Overwrite files in the output folder")
@words.option(
    "--as", "suffix", default="jpg", section=options.OUTPUT,
    type=click.Choice(options.FORMATS),
    help="Format of results of HEIC and raw photos [jpg]",
)  # fmt: skip
@options.takes_results
@words.option("--again", is_flag=True, help="Ignore the report and process all photos again")
@words.section(options.INPUT, common.limits_megapixels)
@options.chooses_landmarks
@options.takes_points
@words.loads("kogao_core.cli.batch:run")
def batch() -> None:
    """Make the faces in many photos smaller.

    IN is a photo, a folder or a pattern such as 'in/*.jpg'.
    """


def _png(_: click.Context, __: click.Parameter, file: Path | None) -> Path | None:
    if file is not None and file.suffix.lower() != ".png":
        raise words.bad_value("{file} doesn't end in .png.", file=file)
    return file


@program.command(
    "detect",
    examples=(
        "kogao-cli detect portrait.jpg",
        "kogao-cli detect portrait.jpg --json",
        "kogao-cli detect portrait.jpg --person-mask people.png",
    ),
)
@options.takes_photo
@words.option(
    "--person-mask", "mask_file", type=common.FILE,
    metavar="FILE.png", callback=_png,
    help="Write a mask of the people: a grey PNG, people white",
)  # fmt: skip
@common.writes_json
@common.forces
@words.loads("kogao_core.cli.detect:run")
def detect() -> None:
    """Find the faces in a photo.

    Positions are pixels of the upright photo; 0,0 is the centre of the first pixel.
    """


@program.command(
    "proof",
    examples=(
        "kogao-cli proof portrait.jpg",
        "kogao-cli proof portrait.jpg --amount 6 -o for-ann.html",
    ),
)
@options.takes_photo
@words.option(
    "-o", "--output", type=common.FILE, metavar="FILE.html", callback=common.no_photo,
    help="Page to write [IN-proof.html in this folder]",
)  # fmt: skip
@options.takes_amount
@options.chooses_faces
@options.takes_doubtful
@options.takes_recipe
@common.forces
@words.loads("kogao_core.cli.proof:run")
def proof() -> None:
    """Let the person in a photo choose how much is changed.

    The page is one file, for a phone or a computer: the photo as it is, and a third, two thirds and
    all of the Amount. The answer is one line for --recipe, or to paste into the window.
    """


@program.command("read")
@click.argument("inputs", nargs=-1, required=True, type=common.PHOTO, metavar="BEFORE AFTER...")
@words.option(
    "--project", "project_file", type=click.Path(path_type=Path), metavar="FILE",
    callback=common.no_photo,
    help="Write a project with the read outlines as targets, for warp --project.",
)  # fmt: skip
@words.option("--style", metavar="NAME", help="Save the median settings as a preset.")
@common.limits_megapixels
@options.chooses_landmarks
@common.writes_json
@common.forces
@words.loads("kogao_core.cli.read:run")
def read() -> None:
    """Measure how a retouch moved the faces of a photo.

    BEFORE is the original, AFTER its retouched copy; it may be cropped, resized or toned. Name more
    pairs to read a style.
    """


@program.group("landmarks")
def landmarks() -> None:
    """Export landmarks for other programs.

    Import: warp --points. Formats: docs/interchange.md.
    """


@landmarks.command("export")
@options.takes_photos
@words.option(
    "--format", "form", type=click.Choice(("json", "csv")), required=True,
    help="The format of detect --json, or a table",
)  # fmt: skip
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="Output folder, created if missing; files are named after the photos",
)  # fmt: skip
@options.chooses_faces
@common.forces
@words.loads("kogao_core.cli.landmarks:run")
def export() -> None:
    """Find the faces in photos and write the landmarks."""


@program.command("originals")
@click.argument("photo", metavar="[PHOTO]", required=False, type=common.PHOTO)
@words.loads("kogao_core.cli.originals:originals")
def originals() -> None:
    """List the stored originals, newest first.

    Columns: number, date, size, file, photo. With PHOTO, list the originals that may belong to
    PHOTO; restore --original takes the number.
    """


@program.command("restore")
@click.argument("file", metavar="PHOTO", type=common.PHOTO)
@words.option(
    "--original", "number", type=common.Whole(1), metavar="N",
    help="Bring back number N of the list that kogao-cli originals PHOTO prints.",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Replace the file even if it has changed since")
@words.loads("kogao_core.cli.originals:restore")
def restore() -> None:
    """Restore the original of a photo that was changed in place.

    The original is the file as it was before Kogao wrote there for the first time.
    """


@program.command("forget")
@click.argument("photos", metavar="[PHOTO...]", nargs=-1, type=common.PHOTO)
@words.option("--all", "everything", is_flag=True, help="List and delete everything")
@words.loads("kogao_core.cli.originals:forget")
def forget() -> None:
    """List what Kogao stores about photos, or delete everything about PHOTO.

    Deleted: original, stored edits, undo steps, names and hashes, lines of logs and reports. PHOTO
    may be missing, or a listed file. Files next to the photo stay.
    """


@program.command("presets", examples=('kogao-cli presets "The paper\'s" > paper.json',))
@click.argument("name", required=False)
@common.writes_json
@common.forces
@words.loads("kogao_core.cli.presets:run")
def presets() -> None:
    """List the presets, or print the recipe of preset NAME as JSON.

    Your presets are JSON files in a folder, shared with the editor: copy files there or elsewhere.
    The options --recipe of other commands read such a file.
    """


@program.command("integrate")
@click.argument(
    "host", type=click.Choice(("desktop", "darktable", "gimp", "krita")), required=False
)
@words.option("--remove", is_flag=True, help="Remove Kogao; from all programs if none is named")
@words.option(
    "--settings", type=common.FOLDER, metavar="FOLDER",
    help="Folder of the program's settings, or of the desktop's menus [the system's]",
)  # fmt: skip
@words.loads("kogao_core.cli.integrate:run")
def integrate() -> None:
    """Add Kogao to the desktop, darktable, GIMP or Krita.

    Restart the other program afterwards.
    """


@program.command("doctor")
@common.writes_json
@common.forces
@words.loads("kogao_core.cli.doctor:run")
def doctor() -> None:
    """Check the installation: versions, networks, libraries."""


@program.command("licenses")
@words.loads("kogao_core.cli.licences:run")
def licenses() -> None:
    """Print the licences of the program and its components."""


if has_laboratory():

    @program.group("experiment", later="kogao_core.lab.commands.experiment")
    def experiment() -> None:
        """Repeat the paper's tables and figures on your own photos."""
