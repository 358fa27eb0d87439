"""Options of several commands: photos, landmarks, settings of the recipe, disclosure, export."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, words
from kogao_core.cli.common import PHOTO, limits_megapixels
from kogao_core.faces.choices import CHOICES
from kogao_core.recipe import presets
from kogao_core.recipe.export import EXPORT_SETTINGS, ExportSetting, ExportSettings
from kogao_core.recipe.recipe import SETTINGS, Recipe
from kogao_core.recipe.settings import Setting

# The first suffix of each output format. A test compares these names with the module that declares
# them and loads numpy.
FORMATS: Final = ("jpg", "png", "tif", "webp", "avif")
# Headings of the help.
INPUT: Final = Text("Input")
FACES: Final = Text("Faces and landmarks")
SHAPE: Final = Text("Shape of the face, % of the distance to the centre")
SURROUNDINGS: Final = Text("Surroundings and lens")
METHOD: Final = Text("Method, with sections of the paper")
OUTPUT: Final = Text("Output")
DISCLOSURE: Final = Text("Disclosure")
_COMMON: Final = ("percent", "scope")
_SURROUNDINGS: Final = ("hold_background", "lens", "lens_amount")
_FACES = re.compile(r"all|largest|[0-9]+(,[0-9]+)*")
_DEFAULTS, _NO_EXPORT = Recipe(), ExportSettings()
_Command = TypeVar("_Command", bound=Callable[..., Any])


chooses_landmarks = words.option(
    "--landmarks",
    type=click.Choice([choice.name for choice in CHOICES]),
    section=FACES,
    help="Landmark source [mesh; aam if the networks are missing]",
)


_SEARCHING: Final = (
    words.section(
        INPUT,
        words.option("--sample", is_flag=True, help="Use the built-in portrait"),
        limits_megapixels,
    ),
    chooses_landmarks,
)
# Options to read one photo; below, any number of photos and folders.
takes_photo = words.together(
    click.argument("source", metavar="[IN]", required=False, type=PHOTO), *_SEARCHING
)
takes_points = words.option(
    "--points", type=click.Path(path_type=Path), metavar="PATH", excludes=("--landmarks",),
    section=FACES,
    help="Read landmarks from a file (docs/interchange.md), or from a folder (file with "
    "the photo's name)",
)  # fmt: skip
takes_photos = words.together(
    click.argument("inputs", metavar="[PHOTO]...", nargs=-1, type=PHOTO),
    *_SEARCHING,
    takes_points,
)


takes_results = words.option(
    "--results", is_flag=True, section=INPUT, help="Accept earlier results of Kogao as input"
)


def _face_choice(_: click.Context, __: click.Parameter, value: str) -> str:
    if not _FACES.fullmatch(value):
        raise words.bad_value(
            "{value}: expected all, largest, or numbers such as 1,3.", value=shown(value)
        )
    return value


chooses_faces = words.option(
    "--face",
    "which",
    default="all",
    callback=_face_choice,
    metavar="WHICH",
    help="all, largest, or numbers from detect, such as 1,3 [all]",
)


def _option(setting: Setting, needs: str | None = None) -> Callable[[_Command], _Command]:
    """Return the option for a field of the recipe. Without the option, the value is None."""
    default = getattr(_DEFAULTS, setting.name)
    name = (setting.option or setting.name).replace("_", "-")
    given: dict[str, Any]
    if setting.within is None and not setting.choices:
        default_text = name if default else f"no-{name}"
        declared, given = f"--{name}/--no-{name}", {"default": None}
    else:
        default_text = default if setting.choices else f"{default:g}"
        unit = setting.unit.upper() if setting.unit.isalpha() else None
        given = {"type": click.Choice(setting.choices) if setting.choices else _number(setting)}
        if setting.choices and setting.within is not None:
            unit = "|".join([*setting.choices, unit or ""])
            given["type"] = _name_or_number
        declared, given["metavar"] = f"--{name}", unit
    shown_default = setting.default_text or default_text
    help_text = Text("{help} [{default}]", help=_help(setting), default=shown_default)
    given |= {"help": help_text, "section": _section(setting), "needs": needs}
    return words.option(declared, setting.name, **given)


def _number(setting: Setting) -> Any:
    assert setting.within is not None
    low, high = setting.within
    return common.Whole(int(low), int(high)) if setting.is_whole else common.Number(low, high)


def _section(setting: Setting) -> str:
    """Return the heading of a setting in the help. Common options have none."""
    if setting.name in _COMMON:
        return ""
    if setting.name in _SURROUNDINGS:
        return SURROUNDINGS
    return METHOD if setting.is_method or setting.name == "center" else SHAPE


def _name_or_number(value: str) -> str | float:
    """Return a number, or the text for the recipe to check."""
    try:
        return float(value)
    except ValueError:
        return value


def _help(setting: Setting) -> Text:
    """Return the description of a setting with the accepted values."""
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


def _recipe_file(help_text: Text, needs: str | None = None) -> Callable[[_Command], _Command]:
    return words.option(
        "--recipe",
        "recipe_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        needs=needs,
        help=help_text,
    )


_ORDER: Final = ("", SHAPE, SURROUNDINGS, METHOD)
_SETTINGS: Final = Text("Load settings (JSON, a file or the text); options override these")


def sets_recipe(needs: str | None = None) -> Callable[[_Command], _Command]:
    """Return the settings and ``--recipe``, for a command where they need another option."""
    every = sorted(SETTINGS.values(), key=lambda one: _ORDER.index(_section(one)))
    settings = (_option(setting, needs) for setting in every)
    return words.together(*settings, _recipe_file(_SETTINGS, needs))


takes_amount = _option(SETTINGS["percent"])
takes_doubtful = words.option(
    "--doubtful",
    is_flag=True,
    section=FACES,
    help="Include doubtful faces; detect lists the reasons",
)
takes_recipe = _recipe_file(_SETTINGS)
# Adds the settings, ``--recipe``, ``--face`` and ``--doubtful``.
chooses = words.together(
    sets_recipe(),
    chooses_faces,
    words.option(
        "--person",
        "people",
        metavar="'NAME=N,...'",
        excludes=("--face",),
        help="Change only the faces with these names in the photo's metadata, each by the Amount N",
    ),
    takes_doubtful,
)


_DROP: Final = "drop"
discloses = words.section(
    DISCLOSURE,
    words.option(
        "--disclose",
        "record",
        is_flag=True,
        help="Add an edit record to the XMP: time, method, program",
    ),
    words.option(
        "--label",
        metavar="TEXT",
        help="Draw TEXT in the bottom right corner; other pixels stay unchanged",
    ),
    words.option(
        "--label-font",
        "font",
        needs="--label",
        metavar="FILE",
        help="Font of the label [built-in; a system font for missing letters]",
    ),
    words.option(
        "--motion",
        type=click.Choice(("keep", _DROP)),
        default=_DROP,
        section=OUTPUT,
        help=Text(
            "Video of a JPEG motion photo; the video shows the original face [{drop}]", drop=_DROP
        ),
    ),
)


def _export_option(setting: ExportSetting) -> Callable[[_Command], _Command]:
    """Return the option for a field of `Export`. Without the option, the value is the default."""
    default = getattr(_NO_EXPORT, setting.name)
    given: dict[str, Any] = {"type": common.Whole(1, setting.most)}
    if isinstance(default, float):
        given = {"type": common.Number(0.0, float(setting.most))}
    elif isinstance(default, bool):
        given = {"is_flag": True, "callback": lambda _, __, value: value is not default}
    return words.option(
        setting.option,
        setting.name,
        metavar=setting.metavar,
        needs=setting.needs,
        help=setting.help,
        **given,
    )


exports = words.section(
    OUTPUT, *(_export_option(it) for it in EXPORT_SETTINGS.values() if it.option)
)

chooses_percent = _option(SETTINGS["percent"])
# For commands that repeat the paper's experiments.
takes_papers_recipe = _recipe_file(Text("Load settings (JSON) [settings of the paper]"))
chooses_as_the_paper = words.together(takes_papers_recipe, chooses_faces)


def recipe_of(
    file: Path | None, choices: Mapping[str, Any], otherwise: Recipe = _DEFAULTS
) -> Recipe:
    """Return the recipe in `file`, or `otherwise`, with the given settings. Raises Stop.

    `file` may also be a JSON text, such as the answer of `proof`.
    """
    given = {name: choices[name] for name in SETTINGS if choices.get(name) is not None}
    with ending.stopping(ValueError, ending.USAGE):
        if file is not None:
            is_text = str(file).startswith("{")
            otherwise = Recipe.from_dict(json.loads(str(file))) if is_text else presets.read(file)
        recipe = dataclasses.replace(otherwise, **given)
        for setting in (SETTINGS[name] for name in given if not SETTINGS[name].counts(recipe)):
            needed = SETTINGS[setting.needs]
            raise BadValue(
                "--{option} has no effect with --{needed} {value}",
                option=(setting.option or setting.name).replace("_", "-"),
                needed=(needed.option or needed.name).replace("_", "-"),
                value=setting.unless,
            )
    return recipe
