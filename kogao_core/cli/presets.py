"""``kogao-cli presets``: named recipes, shared with the editor."""

from __future__ import annotations

import json
from types import SimpleNamespace

import click

from kogao_core.base.language import tr, translated
from kogao_core.cli import common, ending
from kogao_core.recipe import presets


def run(args: SimpleNamespace) -> None:
    """List the presets, or print one as JSON."""
    folder = presets.user_folder()
    # A user file with the name of a built-in preset must not replace that preset.
    found = presets.BUILT_IN | presets.listed(folder) | presets.BUILT_IN
    if args.name is not None:
        if args.name not in found:
            raise ending.Stop("no preset {name}; see kogao-cli presets", name=args.name)
        click.echo(json.dumps(found[args.name].to_dict(), indent=1))
        return
    common.check_report(args.json_file, args.force)
    common.deliver(
        lambda: {name: recipe.to_dict() for name, recipe in found.items()},
        lambda: "\n".join([*map(translated, found), tr("Your presets: {folder}", folder=folder)]),
        args.json_file,
    )
