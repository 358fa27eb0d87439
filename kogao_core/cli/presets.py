"""``kogao-cli presets``: the recipes with names that the editor offers, as files."""

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
    """List the recipes with names, and exchange them as files.

    Those of the editor and of this command are the same; --recipe of other commands takes what
    export writes.
    """


@command.command("list")
@common.writes_json
@common.forces
def list_presets(json_file: Path | None, force: bool) -> None:
    """List presets: those of the program, then your own."""
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
    "-o", "--output", required=True, type=common.FILE, metavar="OUT.json", help="Where to write."
)
@common.forces
def export(name: str, output: Path, force: bool) -> None:
    """Write a preset as a file."""
    recipe = _named(name)
    common.check_free(output, force)
    with ending.writing(output):
        presets.write(recipe, output)


@command.command("import")
@click.argument("files", nargs=-1, required=True, type=common.FILE, metavar="FILE...")
@words.option("--name", help="What to call it [the file's name].")
@common.forces
def import_presets(files: tuple[Path, ...], name: str | None, force: bool) -> None:
    """Take recipes in files as presets of your own; none is taken unless all can be."""
    if name is not None and len(files) > 1:
        raise ending.Stop(Text("--name names one preset; import one file"))
    folder = presets.user_folder()
    with ending.stopping(ValueError, ending.USAGE):
        named = [
            (presets.name_of(file) if name is None else name, presets.read(file)) for file in files
        ]
        targets = [presets.file_of(folder, one) for one, _ in named]
    for (one, _), target in zip(named, targets, strict=True):
        if one in presets.BUILT_IN:
            raise ending.Stop(Text("{one} comes with the program; give yours a --name", one=one))
        if targets.count(target) > 1:
            raise ending.Stop(Text("several files are called {one}; rename one", one=one))
        common.check_free(target, force)
    for one, recipe in named:
        with ending.writing(presets.file_of(folder, one)):
            presets.add(folder, one, recipe)
        ending.print_text(one)


def _all() -> dict[str, Recipe]:
    # A file that was laid there by hand may have any name; the program's own keep theirs.
    return presets.BUILT_IN | presets.listed(presets.user_folder()) | presets.BUILT_IN


def _named(name: str) -> Recipe:
    found = _all()
    if name not in found:
        raise ending.Stop(
            Text(
                "there is no preset {name}; kogao-cli presets list tells which there are", name=name
            )
        )
    return found[name]
