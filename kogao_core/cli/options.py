"""The options that choose what happens to faces, shared by `warp` and `batch`."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, get_args

import click

from kogao_core import recipe as recipes
from kogao_core import strict
from kogao_core.cli import common
from kogao_core.recipe import Recipe
from kogao_core.wording import shown

if TYPE_CHECKING:
    from kogao_core.photo.disclosure import Disclosure

_FACES = re.compile(r"all|largest|[0-9]+(,[0-9]+)*")
_DEFAULTS = Recipe()
_MOST_BYTES: Final = 2**20  # of a recipe file
_Command = TypeVar("_Command", bound=Callable[..., Any])


def _face_choice(_: click.Context, __: click.Parameter, value: str) -> str:
    if not _FACES.fullmatch(value):
        raise click.BadParameter(f"{shown(value)} is none of all, largest, or numbers such as 1,3.")
    return value


chooses_faces = click.option(
    "--face",
    "which",
    default="all",
    show_default=True,
    callback=_face_choice,
    metavar="WHICH",
    help="all, largest, or numbers as detect prints them, such as 1,3.",
)

_OPTIONS: Final = (
    click.option("--percent", type=float, help=f"Warp distance in % of D [{_DEFAULTS.percent:g}]."),
    click.option("--center", type=int, help=f"Centre candidate 1..4 [{_DEFAULTS.center}]."),
    click.option("--lattice", type=float, help=f"Lattice spacing R [{_DEFAULTS.lattice:g}]."),
    click.option(
        "--lattice-unit",
        type=click.Choice(get_args(recipes.LatticeUnit)),
        help=f"What R counts: landmark spacings or warp distances [{_DEFAULTS.lattice_unit}].",
    ),
    click.option(
        "--fit",
        type=click.Choice(get_args(recipes.Fit)),
        help=f"How the lattice follows the landmarks [{_DEFAULTS.fit}].",
    ),
    click.option(
        "--domain",
        type=click.Choice(get_args(recipes.DomainName)),
        help=f"Which pixels are worked on [{_DEFAULTS.domain}].",
    ),
    click.option(
        "--threshold",
        "threshold_px",
        type=float,
        metavar="PX",
        help="Position change below which a pixel stays [1/64: no byte is lost].",
    ),
    click.option(
        "--interpolation",
        type=click.Choice(get_args(recipes.Interpolation)),
        help=f"Resampling kernel [{_DEFAULTS.interpolation}].",
    ),
    click.option(
        "--guard/--no-guard",
        default=None,
        help="Hold faces that would fold back to the largest move that doesn't [guard].",
    ),
    chooses_faces,
    click.option(
        "--recipe",
        "recipe_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="A saved recipe (JSON); the options above override it.",
    ),
)


def chooses(command: _Command) -> _Command:
    """Add the options of a recipe, ``--face`` and ``--recipe`` to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


_TELLING: Final = (
    click.option(
        "--disclose",
        "record",
        is_flag=True,
        help="Add an edit record to the XMP: the photo was retouched, when, how and by what.",
    ),
    click.option(
        "--label",
        metavar="TEXT",
        help="Draw TEXT into the bottom right corner; only its rectangle changes.",
    ),
    click.option(
        "--label-font",
        "font",
        metavar="FILE",
        help="A font file for the label, for letters other than Latin ones.",
    ),
)


def tells(command: _Command) -> _Command:
    """Add the options that tell of the retouching in the result."""
    for option in reversed(_TELLING):
        command = option(command)
    return command


def disclosure_of(record: bool, label: str | None, font: str | None) -> Disclosure:
    """Return what is to be told, after checking that the label can be drawn at all."""
    from kogao_core.photo import CannotDisclose
    from kogao_core.photo.disclosure import Disclosure
    from kogao_core.photo.label import check_label

    if label is not None:
        with common.stopping(CannotDisclose, common.USAGE):
            check_label(label, font)
    return Disclosure(record, label or "", font)


def recipe_of(file: Path | None, choices: dict[str, Any]) -> Recipe:
    """Return the recipe in `file`, or the default one, with the choices that were given."""
    given = {name: value for name, value in choices.items() if value is not None}
    with common.stopping(ValueError, common.USAGE):
        return dataclasses.replace(_saved_recipe(file) if file else _DEFAULTS, **given)


def _saved_recipe(file: Path) -> Recipe:
    try:
        with file.open("rb") as opened:
            data = opened.read(_MOST_BYTES + 1)
        return Recipe.from_dict(strict.parse(data, _MOST_BYTES).value)
    except OSError as error:
        raise ValueError(f"the recipe {file} can't be read ({error.strerror})") from error
    except ValueError as error:
        raise ValueError(f"the recipe {file} can't be used: {error}") from error
