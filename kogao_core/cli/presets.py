"""``kogao-cli presets``: named recipes, shared with the editor."""

from __future__ import annotations

import json
from pathlib import Path

import click

from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, words
from kogao_core.recipe import presets


@words.command("presets", examples=('kogao-cli presets "The paper\'s" > paper.json',))
@click.argument("name", required=False)
@common.writes_json
@common.forces
def command(name: str | None, json_file: Path | None, force: bool) -> None:
    """List the presets, or print the recipe of preset NAME as JSON.

    Your presets are JSON files in a folder, shared with the editor: copy files there or elsewhere.
    The options --recipe of other commands read such a file.
    """
    folder = presets.user_folder()
    # A user file with the name of a built-in preset must not replace that preset.
    found = presets.BUILT_IN | presets.listed(folder) | presets.BUILT_IN
    if name is not None:
        if name not in found:
            raise ending.Stop(Text("no preset {name}; see kogao-cli presets", name=name))
        click.echo(json.dumps(found[name].to_dict(), indent=1))
        return
    common.check_report(json_file, force)
    common.deliver(
        lambda: {name: recipe.to_dict() for name, recipe in found.items()},
        lambda: "\n".join([*map(translated, found), tr("Your presets: {folder}", folder=folder)]),
        json_file,
    )
