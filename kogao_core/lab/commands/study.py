"""``kogao-cli experiment study``: make a rating study, and count the answers."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, get_args

import click

from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import tr
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.cli.common import ProgressLine
from kogao_core.faces.face import select
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.lab.commands import outputs
from kogao_core.lab.study import data as answer_tables
from kogao_core.lab.study import making, plan, tally
from kogao_core.lab.study.design import Conduct, Rules, variants
from kogao_core.lab.study.report import notes
from kogao_core.lab.study.report import report as made_report
from kogao_core.lab.subjects import Subject
from kogao_core.recipe.recipe import PAPER
from kogao_core.recipe.settings import PAPER_CENTERS, Fit

_LARGEST_LATTICE: Final = 8.0
_TEXT: Final = click.Path(path_type=Path)


@words.group("study")
def command() -> None:
    """Ask people which faces look natural (table 1, figures 10 and 11).

    make writes pictures and a rating page without labels; report counts the answers. See
    docs/study.md.
    """


def _numbers(low: float, high: float) -> Callable[..., tuple[float, ...]]:
    """Return a parser of a list of different numbers within a range."""

    def read(_: click.Context, __: click.Parameter, value: str) -> tuple[float, ...]:
        try:
            found = tuple(float(part) for part in value.split(",") if part)
        except ValueError:
            raise words.bad_value(
                "{value} is not a list such as 0.5,1,2.", value=shown(value)
            ) from None
        if len(set(found)) != len(found) or not all(low <= one <= high for one in found):
            raise words.bad_value(
                "{value} must be different numbers within {low:g}..{high:g}.",
                value=shown(value),
                low=low,
                high=high,
            )
        return found

    return read


def _fits(_: click.Context, __: click.Parameter, value: str | None) -> tuple[Fit, ...] | None:
    if value is None:
        return None
    given = value.split(",")
    found = tuple(fit for fit in get_args(Fit) if fit in given)
    if len(found) != len(given):
        raise words.bad_value(
            "{value} is not a list such as exact,approximation.", value=shown(value)
        )
    return found


def _text(path: Path | None) -> str:
    """Return the text of a file; empty without a file."""
    if path is None:
        return ""
    try:
        return path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        raise ending.Stop(
            "{path} can't be read; name a text file in UTF-8", ending.UNREADABLE, path=path
        ) from None


@command.command("make")
@options.takes_photos
@words.option(
    "-o", "--output", "folder", required=True, type=click.Path(path_type=Path),
    help="New folder for the raters; the key is written next to this folder.",
)  # fmt: skip
@words.option(
    "--lattices", callback=_numbers(0.1, _LARGEST_LATTICE), default="0.25,0.5,1,2",
    show_default=True, metavar="R,R,...",
    help="Lattice sizes of figure 11, in landmark spacings.",
)  # fmt: skip
@words.option(
    "--percents", callback=_numbers(-15.0, 15.0), default="2,4,6,8,10", show_default=True,
    metavar="P,P,...", help="Distances of table 1, % of D; below 0 larger.",
)  # fmt: skip
@words.option(
    "--centers", callback=_numbers(1.0, len(PAPER_CENTERS)), default="1,2,3,4", show_default=True,
    metavar="C,C,...", help="Centre candidates of table 1.",
)  # fmt: skip
@words.option(
    "--fits", callback=_fits, metavar="FIT,FIT,...",
    help="Fits of table 1's pictures: approximation, exact, multilevel [the recipe's].",
)  # fmt: skip
@words.option(
    "--match", is_flag=True,
    help="Make the achieved distances equal to --percents.",
)  # fmt: skip
@options.takes_papers_recipe
@words.option("--control", is_flag=True, help="Show each original photo, too.")
@words.option(
    "--catch/--no-catch", default=True,
    help="Show each face cut in two, too, to find inattentive raters [shown].",
)  # fmt: skip
@words.option(
    "--count-unfinished", is_flag=True,
    help="Count unfinished sessions; the rule is stored in the key.",
)  # fmt: skip
@words.option(
    "--satisfaction", is_flag=True,
    help="At the end, raters grade the picture of their own face from 0 to 100.",
)  # fmt: skip
@words.option(
    "--practice", type=common.Whole(0, 8), default=0, show_default=True,
    help="Number of practice pictures of the sample portrait.",
)  # fmt: skip
@words.option(
    "--faces-each", type=common.Whole(0), default=0, show_default=True,
    help="Faces per rater, in balanced blocks; 0 for all.",
)  # fmt: skip
@words.option("--swap-keys", is_flag=True, help="Swap F and J for half of the raters.")
@words.option(
    "--break-every", type=common.Whole(0), default=0, show_default=True,
    help="Answers between breaks; 0 for no breaks.",
)  # fmt: skip
@words.option(
    "--picture-size", "size", default="fit", show_default=True, metavar="SIZE",
    help="Long side of each photo, such as 640px; fit fills the window.",
)  # fmt: skip
@words.option("--full-screen", is_flag=True, help="Require the full screen.")
@words.option("--consent", type=_TEXT, metavar="FILE", help="Consent text; raters must agree.")
@words.option(
    "--instructions", type=_TEXT, metavar="FILE", help="Instructions, instead of the page's text."
)
@words.option("--debriefing", type=_TEXT, metavar="FILE", help="Text at the end.")
@words.option("--completion-code", default="", help="Code shown at the end, for payment.")
@words.option("--seed", help="Seed of an earlier study, for the same pictures [random].")
def make(**given: Any) -> None:
    """Make a study of the largest face in each photo."""
    args = SimpleNamespace(**given)
    photos = reading.input_paths(args.inputs, args.sample)
    with ending.stopping(making.RefusedFolder, ending.USAGE):
        making.check_folder(args.folder)
    recipe = options.recipe_of(args.recipe_file, {}, PAPER)
    kinds = variants(
        recipe,
        args.lattices,
        percents=args.percents,
        centers=tuple(map(int, args.centers)),
        fits=args.fits,
        control=args.control,
        catch=args.catch,
        satisfaction=args.satisfaction,
    )
    source = landmark_source(args.landmarks)
    fields = dataclasses.fields(Conduct)
    sessions: dict[str, Any] = {one.name: given.get(one.name) for one in fields}
    sessions |= {name: _text(given[name]) for name in ("consent", "instructions", "debriefing")}
    with ending.stopping(ValueError, ending.USAGE):
        choices = making.Choices(
            recipe,
            kinds,
            args.seed,
            source.name if args.points is None else f"--points {args.points.name}",
            args.match,
            args.practice,
            Conduct(**sessions),
            Rules(unfinished=args.count_unfinished),
        )
    other = None
    if args.practice:
        # `--points` are of the photos, not of this one.
        photo = reading.read_photo(common.input_path(None, True), args.max_megapixels)
        (face,) = select(source.find(photo.pixels), "largest")
        other = making.subject(photo, face)
    with ending.stopping(making.RefusedFolder, ending.USAGE), ending.writing(args.folder):
        subjects = [_subject(path, args) for path in photos]
        progress = ProgressLine()
        progress.begin(tr("pictures for {folder}", folder=args.folder))
        key = making.make(subjects, args.folder, choices, progress.step, other)
        progress.end()
    _tell_made(args.folder, len(key.pictures), len(photos))


def _tell_made(folder: Path, pictures: int, faces: int) -> None:
    """Print what a study consists of, and what to do next."""
    ending.print_text(
        tr(
            "{folder}: {count} pictures of {faces}",
            folder=folder,
            count=pictures,
            faces=common.count_of_faces(faces),
        )
    )
    ending.print_text(
        tr(
            "to rate: open {page} in a browser; put the saved files into {folder}",
            page=folder / making.PAGE_FILE,
            folder=folder,
        )
    )
    ending.print_text(
        tr(
            "{file}: the key of the pictures; keep this file from the raters",
            file=plan.key_path(folder),
        )
    )


def _subject(path: Path, args: SimpleNamespace) -> Subject:
    photo = reading.read_photo(path, args.max_megapixels)
    (face,) = select(reading.find_faces(photo, args.landmarks, args.points), "largest")
    return dataclasses.replace(making.subject(photo, face), sha256=photo.sha256)


@command.command("report")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@words.option(
    "--key", "keys", multiple=True, type=click.Path(path_type=Path), metavar="FILE",
    help="Keys, one per folder, in the same order [FOLDER.key.json].",
)  # fmt: skip
@words.option(
    "--ratings", "files", multiple=True, type=click.Path(path_type=Path), metavar="FILE",
    help="Rating file saved by a browser, outside of the folder; repeatable.",
)  # fmt: skip
@words.option("--exclude", multiple=True, metavar="RATER", help="Exclude this rater; repeatable.")
@words.option(
    "--data", type=common.FOLDER, metavar="DIR",
    help="Write tables of all answers and raters, a codebook, and a mixed model for R.",
)  # fmt: skip
@outputs.writes_files
def report(**given: Any) -> int:
    """Count the ratings of the studies in FOLDERS."""
    args = SimpleNamespace(**given)
    if args.keys and len(args.keys) != len(args.folders):
        raise ending.Stop("give one --key per folder, or none")
    to = outputs.Outputs(outputs.asked_for(given), args.data, args.force)
    keys = args.keys or [plan.key_path(folder) for folder in args.folders]
    with ending.stopping(BadFile, ending.UNREADABLE):
        counted = tally.tally(list(zip(args.folders, keys, strict=True)), args.files, args.exclude)
    for rater in set(args.exclude) - set(counted.raters):
        raise ending.Stop("no rater {rater}", rater=rater)
    for note in notes(counted):
        ending.print_message(note)
    to.write(made_report(counted))
    to.keep(answer_tables.files(counted).items())
    return ending.SOME_FAILED if counted.refused else 0
