"""``kogao-cli warp``: check the options, then load the modules of the warp."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Final

import click

from kogao_core.cli import common, ending, options, words
from kogao_core.recipe.recipe import SETTINGS

# Parameters that a project contains.
_FROM_PROJECT: Final = (
    *SETTINGS,
    *("which", "people", "doubtful", "recipe_file", "landmarks"),
    *("lines", "width_px", "points"),
)
_JPEG: Final = b"\xff\xd8"  # start of image


def run(args: SimpleNamespace) -> None:
    """Check the options, then warp the photo."""
    context = click.get_current_context()
    if context.args:
        raise ending.Stop("warp takes one photo; use kogao-cli batch for several photos")
    if args.project_file is not None:
        _refuse_choices(context)
    recipe = options.recipe_of(args.recipe_file, vars(args))
    if args.output == args.json_file == common.STDOUT:
        raise ending.Stop("-o - and --json - both need standard output; name a file for one")
    if args.source == common.STDIN and (args.in_place or args.save_project):
        raise ending.Stop("--in-place and --save-project need a file, not standard input")
    with ExitStack() as files:
        if args.source == common.STDIN:
            args.source = files.enter_context(common.received())
        path = common.input_path(args.source, args.sample)
        from kogao_core.photo import FORMATS, read
        from kogao_core.photo.jpeg.coefficients import read_ahead

        early = None
        with ThreadPoolExecutor(1) as other:
            # A JPEG is read while this thread loads the other modules and finds the faces. Readers
            # of other formats load modules themselves; in a second thread, that can hang on a
            # signal.
            if _is_jpeg(path):
                early = other.submit(read, path, max_megapixels=args.max_megapixels)
                if args.in_place or FORMATS.get(Path(args.output or "").suffix.lower()) == "JPEG":
                    read_ahead(path, other, early)
            from kogao_core.cli.warping import warp

            warp(args, path, recipe, files, early)


def _is_jpeg(path: Path) -> bool:
    if not path.is_file():  # a pipe can be read only once
        return False
    try:
        with path.open("rb") as file:
            return file.read(len(_JPEG)) == _JPEG
    except OSError:
        return False


def _refuse_choices(context: click.Context) -> None:
    """Raise Stop if options are given that the project contains."""
    for parameter in context.command.params:
        if parameter.name in _FROM_PROJECT and words.is_given(parameter, context):
            raise ending.Stop("{option} can't be combined with --project", option=parameter.opts[0])
