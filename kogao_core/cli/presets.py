"""``kogao-cli presets``: named recipes, shared with the editor."""

from __future__ import annotations

import json
from pathlib import Path

import click

from kogao_core.base.language import Text, translated
from kogao_core.cli import common, ending, words
from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe


@words.group("presets")
def command() -> None:
    """List, show, export and import presets.

    A preset is a recipe with a name. The editor uses the same presets. Other commands read an
    exported preset with --recipe.
    """


@command.command("list")
@common.writes_json
@common.forces
def list_presets(json_file: Path | None, force: bool) -> None:
    """List the built-in presets, then your own."""
    common.check_report(json_file, force)
    found = _all()
    common.deliver(
        lambda: {name: recipe.to_dict() for name, recipe in found.items()},
        lambda: "\n".join(map(translated, found)),
        json_file,
    )


@command.command("show")
@click.argument("name")
def show(name: str) -> None:
    """Print a preset."""
    click.echo(json.dumps(_named(name).to_dict(), indent=1))


@command.command("export")
@click.argument("name")
@words.option(
    "-o", "--output", required=True, type=common.FILE, metavar="OUT.json", help="Output file"
)
@common.forces
def export(name: str, output: Path, force: bool) -> None:
    """Write a preset to a file."""
    recipe = _named(name)
    common.check_free(output, force)
    with ending.writing(output):
        presets.write(recipe, output)


@command.command("import")
@click.argument("files", nargs=-1, required=True, type=common.FILE, metavar="FILE...")
@words.option("--name", help="Name of the preset [name of the file]")
@common.forces
def import_presets(files: tuple[Path, ...], name: str | None, force: bool) -> None:
    """Import presets from files: all files, or none if one can't be used."""
    if name is not None and len(files) > 1:
        raise ending.Stop(Text("--name names one preset; import one file"))
    folder = presets.user_folder()
    with ending.stopping(ValueError, ending.USAGE):
        named = [
            (presets.name_of(file) if name is None else name, presets.read(file)) for file in files
        ]
        targets = [presets.file_of(folder, one) for one, _ in named]
    for (one, _), target in zip(named, targets, strict=True):
        if targets.count(target) > 1:
            raise ending.Stop(Text("several files are called {one}; rename one", one=one))
        check_name(one, force)
    for one, recipe in named:
        with ending.writing(presets.file_of(folder, one)):
            presets.add(folder, one, recipe)
        ending.print_text(one)


def check_name(name: str, force: bool) -> None:
    """Check that a preset can be saved under a name. Raises Stop."""
    if name in presets.BUILT_IN:
        raise ending.Stop(Text("{name} is a built-in preset; choose another name", name=name))
    with ending.stopping(ValueError, ending.USAGE):
        target = presets.file_of(presets.user_folder(), name)
    common.check_free(target, force)


def _all() -> dict[str, Recipe]:
    # A user file with the name of a built-in preset must not replace that preset.
    return presets.BUILT_IN | presets.listed(presets.user_folder()) | presets.BUILT_IN


def _named(name: str) -> Recipe:
    found = _all()
    if name not in found:
        raise ending.Stop(Text("no preset {name}; see kogao-cli presets list", name=name))
    return found[name]
