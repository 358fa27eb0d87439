"""The options that choose what happens to faces, shared by `warp` and `batch`."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, words
from kogao_core.photo.disclosure.credentials import Signer, check_signer
from kogao_core.photo.disclosure.disclosing import Disclosure
from kogao_core.photo.disclosure.label import LabelPicture, check_label, check_picture
from kogao_core.photo.errors import CannotDisclose, MissingExtra
from kogao_core.photo.export import LONGEST_PX, Export
from kogao_core.recipe import presets
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe
from kogao_core.recipe.settings import (
    CORNERS,
    LABEL_CORNER,
    LABEL_PERCENT,
    LABEL_SHARE,
    Corner,
    Setting,
)

_FACES = re.compile(r"all|largest|[0-9]+(,[0-9]+)*")
_DEFAULTS = Recipe()
_Command = TypeVar("_Command", bound=Callable[..., Any])


def _face_choice(_: click.Context, __: click.Parameter, value: str) -> str:
    if not _FACES.fullmatch(value):
        raise words.bad_value(
            Text("{value} is none of all, largest, or numbers such as 1,3.", value=shown(value))
        )
    return value


chooses_faces = words.option(
    "--face",
    "which",
    default="all",
    show_default=True,
    callback=_face_choice,
    metavar="WHICH",
    help="all, largest, or numbers as detect prints them, such as 1,3.",
)


def _option(setting: Setting) -> Callable[[_Command], _Command]:
    """Return the option of a field of the recipe, which is None where it isn't given."""
    default = getattr(_DEFAULTS, setting.name)
    name = (setting.option or setting.name).replace("_", "-")
    given: dict[str, Any]
    if setting.within is None and not setting.choices:
        default_text = name if default else f"no-{name}"
        declared, given = f"--{name}/--no-{name}", {"default": None}
    else:
        default_text = default if setting.choices else f"{default:g}"
        unit = setting.unit.upper() if setting.unit.isalpha() else None
        kind = int if setting.is_whole else float
        given = {"type": click.Choice(setting.choices) if setting.choices else kind}
        if setting.choices and setting.within is not None:
            unit = "|".join([*setting.choices, unit or ""])
            given["type"] = _name_or_number
        declared, given["metavar"] = f"--{name}", unit
    help_text = _with_default(setting, setting.default_text or default_text)
    return words.option(declared, setting.name, help=help_text, **given)


def _name_or_number(value: str) -> str | float:
    """Return a number where there is one; the recipe refuses what is neither that nor a name."""
    try:
        return float(value)
    except ValueError:
        return value


def _help(setting: Setting) -> Text:
    """Return what a field does, and what may be given."""
    offered = [
        Text("{name} ({help})", name=one.name, help=one.help) for one in setting.alternatives
    ]
    if setting.within is not None:
        low, high = setting.within
        numbers = Text("{low:g}..{high:g}", low=low, high=high)
        if not offered:
            return Text("{help}, {numbers}", help=setting.full_help, numbers=numbers)
        offered.append(numbers)
    if not offered:
        return setting.full_help
    return Text("{help}: {offered}", help=setting.full_help, offered=Text.joined(", ", offered))


def _with_default(setting: Setting, default: str) -> Text:
    return Text("{help} [{default}].", help=_help(setting), default=default)


def _recipe_file(help_text: Text) -> Callable[[_Command], _Command]:
    return words.option(
        "--recipe",
        "recipe_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help=help_text,
    )


# Adds the options of a recipe, ``--face``, ``--doubtful`` and ``--recipe``.
chooses = words.together(
    *map(_option, SETTINGS.values()),
    chooses_faces,
    words.option(
        "--doubtful",
        is_flag=True,
        help="Make doubtful faces smaller, too; detect says which those are, and why.",
    ),
    _recipe_file(Text("A saved recipe (JSON); the options above override it.")),
)


_DROP: Final = "drop"
_DISCLOSING: Final = (
    words.option(
        "--disclose",
        "record",
        is_flag=True,
        help="Add an edit record to the XMP: the photo was retouched, when, how and by what.",
    ),
    words.option(
        "--label",
        metavar="TEXT",
        help="Draw TEXT into the bottom right corner; only its rectangle changes.",
    ),
    words.option(
        "--label-font",
        "font",
        needs="--label",
        metavar="FILE",
        help="A font file for the label [built in; the system's for letters that it lacks].",
    ),
    words.option(
        "--label-picture",
        "picture",
        metavar="FILE",
        help="Lay this picture over a corner, such as the mark that Norway prescribes.",
    ),
    words.option(
        "--label-corner",
        "corner",
        needs="--label-picture",
        type=click.Choice(tuple(CORNERS)),
        default=LABEL_CORNER,
        help=Text("Which corner the picture is laid over [{corner}].", corner=LABEL_CORNER),
    ),
    words.option(
        "--label-share",
        "share",
        needs="--label-picture",
        type=common.Number(*LABEL_SHARE),
        default=LABEL_PERCENT,
        metavar="PERCENT",
        help=Text(
            "How much of the photo's area the picture takes, {low:g}..{high:g} % [{percent:g}].",
            low=LABEL_SHARE[0],
            high=LABEL_SHARE[1],
            percent=LABEL_PERCENT,
        ),
    ),
    words.option(
        "--sign-certificate",
        "certificate",
        needs="--sign-key",
        metavar="FILE",
        help="Sign content credentials (C2PA) that name the photo as the source; your certificate "
        "and those that vouch for it, as PEM (the extra [credentials]).",
    ),
    words.option(
        "--sign-key",
        "key",
        needs="--sign-certificate",
        metavar="FILE",
        help="The certificate's private key, as PEM; its password from KOGAO_SIGN_PASSWORD.",
    ),
    words.option(
        "--motion",
        type=click.Choice(("keep", _DROP)),
        default=_DROP,
        help=Text(
            "The video of a motion photo, which shows the face as it was; in JPEGs alone [{drop}].",
            drop=_DROP,
        ),
    ),
)


def discloses(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that disclose the retouching; the command gets a checked ``disclosure``."""

    @wraps(command)
    def disclosing(**given: Any) -> Any:
        told = {name: given.pop(name) for name in signature(_disclosure).parameters}
        return command(**given, disclosure=_disclosure(**told))

    return words.together(*_DISCLOSING)(disclosing)


def _disclosure(
    record: bool,
    label: str | None,
    font: str | None,
    picture: str | None,
    corner: Corner,
    share: float,
    certificate: str | None,
    key: str | None,
    motion: str,
) -> Disclosure:
    """Return what results disclose, after checking that they can."""
    laid = None if picture is None else LabelPicture(picture, corner, share)
    signer = None if certificate is None or key is None else Signer(certificate, key)
    with (
        ending.stopping(CannotDisclose, ending.USAGE),
        ending.stopping(MissingExtra, ending.BROKEN),
    ):
        if label is not None:
            check_label(label, font)
        if laid is not None:
            check_picture(laid)
        if signer is not None:
            check_signer(signer)
    return Disclosure(record, label or "", font, laid, signer, film=motion == "keep")


_EXPORTING: Final = (
    words.option(
        "--longest-side", "longest_px", type=click.IntRange(1, LONGEST_PX), metavar="PX",
        help="Reduce results to this longer side, in the same resampling as the warp.",
    ),
    words.option(
        "--quality", type=click.IntRange(1, 100),
        help="Of JPEG and WebP, 1..100 [the source's]; all is encoded anew.",
    ),
    words.option(
        "--srgb", is_flag=True, help="Convert results to sRGB, 8 bits; else they keep the profile."
    ),
    words.option(
        "--sharpen", type=common.Number(0.0, 200.0), metavar="PERCENT", needs="--longest-side",
        help="Sharpen what is reduced, for its size, 0..200 % [0].",
    ),
    words.option(
        "--no-metadata", "bare", is_flag=True,
        help="Leave EXIF, XMP, IPTC and the like out; the colour profile stays.",
    ),
)  # fmt: skip
_EXPORTED: Final = ("longest_px", "quality", "srgb", "sharpen")


def exports(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of size, quality and colours; the command gets an ``export``."""

    @wraps(command)
    def exporting(**given: Any) -> Any:
        chosen: dict[str, Any] = {name: given.pop(name) or 0 for name in _EXPORTED}
        export = Export(**chosen, metadata=not given.pop("bare"))
        return command(**given, export=export)

    return words.together(*_EXPORTING)(exporting)


chooses_percent = words.option(
    "--percent", type=float, help=_with_default(SETTINGS["percent"], "4")
)
# For a command that repeats the paper's work.
takes_papers_recipe = _recipe_file(Text("A saved recipe (JSON) [the paper's]."))
chooses_as_the_paper = words.together(takes_papers_recipe, chooses_faces)


def paper_recipe_of(file: Path | None, percent: float | None) -> Recipe:
    """Return the recipe in `file`, or the paper's, at the percentage that was given."""
    return recipe_of(file, {"percent": percent}, PAPER)


def recipe_of(file: Path | None, choices: dict[str, Any], otherwise: Recipe = _DEFAULTS) -> Recipe:
    """Return the recipe in `file`, or another one, with the choices that were given."""
    given = {name: value for name, value in choices.items() if value is not None}
    with ending.stopping(ValueError, ending.USAGE):
        return dataclasses.replace(presets.read(file) if file else otherwise, **given)
