"""``kogao-cli warp``: read, find, render, write; everything is checked before work begins."""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from functools import partial
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, options, points, projects, summary, words
from kogao_core.cli import json_file as to_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kogao_core.background.find import BackgroundFinder, Bends
    from kogao_core.base.geometry import Image
    from kogao_core.faces.face import Face, LandmarkSource
    from kogao_core.photo import Photo
    from kogao_core.photo.disclosure.disclosing import Disclosure
    from kogao_core.pipeline import Rendering
    from kogao_core.projects.sidecar import Applied
    from kogao_core.warp.protection import Protection

_LATER: Final = (
    "projects.sidecar",
    "pipeline",
    "photo.jpeg.blocks",
    "background.find",
    "background.people",
)


def _lines(_: click.Context, __: click.Parameter, values: Sequence[str]) -> list[Any]:
    lines = [_corners(value) for value in values]
    for value, line in zip(values, lines, strict=True):
        if not line or any(len(corner) != 2 or not all(map(isfinite, corner)) for corner in line):
            raise words.bad_value(
                Text("{value} is not a list such as '10,20 10,400'.", value=shown(value))
            )
    return lines


def _corners(value: str) -> list[list[float]]:
    try:
        return [[float(part) for part in corner.split(",")] for corner in value.split()]
    except ValueError:
        return []


@words.command("warp")
@common.takes_photo
@words.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE",
    help=common.output_help,
)  # fmt: skip
@words.option(
    "--in-place", is_flag=True,
    help="Write over IN itself, as a file of the same kind; kogao-cli restore brings it back.",
)  # fmt: skip
@words.option(
    "--temporary", is_flag=True, needs="--in-place",
    help="With --in-place: IN is a copy that another program made for this; keep no original.",
)  # fmt: skip
@options.chooses
@points.takes_points
@words.option(
    "--protect", "lines", multiple=True, metavar="'X,Y X,Y'", callback=_lines,
    help="A line, or more corners, that must not move, px of the upright photo; repeatable.",
)  # fmt: skip
@words.option(
    "--protect-width", "width_px", type=common.Number(0.0), default=0.0, metavar="PX",
    needs="--protect", help="Width of the protected lines [0: the line alone].",
)  # fmt: skip
@words.option(
    "--protect-feather", "feather_px", type=common.Number(0.0), default=0.0, metavar="PX",
    needs="--protect",
    help="Keep the lines' very bytes and let the move fade in over PX beside them [0: don't].",
)  # fmt: skip
@words.option(
    "--project", "project_file", type=click.Path(path_type=Path), metavar="FILE",
    help="Do what a project says (PHOTO.kogao.json, also of another size of the photo).",
)  # fmt: skip
@words.option(
    "--save-project", is_flag=True,
    help="Keep what was done as IN.kogao.json beside the photo, for the editor and for batches.",
)  # fmt: skip
@options.discloses
@to_json.writes_json
@words.option("--force", is_flag=True, help="Replace an existing output, even IN itself.")
def command(
    source: Path | None,
    sample: bool,
    max_megapixels: float,
    landmarks: str | None,
    output: Path | None,
    in_place: bool,
    temporary: bool,
    which: str,
    doubtful: bool,
    recipe_file: Path | None,
    points_file: Path | None,
    points_map: str | None,
    lines: list[Any],
    width_px: float,
    feather_px: float,
    project_file: Path | None,
    save_project: bool,
    disclosed: Callable[[], Disclosure],
    json_file: Path | None,
    force: bool,
    **choices: Any,
) -> None:
    """Make the faces in the photo IN smaller and write the result to OUTPUT, or over IN itself."""
    from kogao_core.base.threads import beside, take_short_turns

    if project_file is not None:
        projects.refuse_choices(click.get_current_context())
    recipe = options.recipe_of(recipe_file, choices)
    path = common.input_path(source, sample)
    is_searched = project_file is None and points_file is None
    load = common.loader(landmarks) if is_searched else None
    take_short_turns()
    with beside(lambda: _loaded(load)) as loaded:
        disclosure = disclosed()
        to = _checked_output(path, sample, output, in_place, save_project, force)
        to_json.check(json_file, force)
        if save_project:
            projects.check_free(path, sample, force)
        photo = common.read_photo(path, max_megapixels, to)
    _check_photo(photo, to, in_place)
    from kogao_core.background.find import BackgroundFinder, held_of
    from kogao_core.faces.landmarks.pixels import Pyramid
    from kogao_core.photo import read_ahead
    from kogao_core.pipeline import render
    from kogao_core.projects.sidecar import Applied
    from kogao_core.warp.whole_head import unfollowed

    with beside(lambda: read_ahead(photo, to)) as ahead:
        sha256 = projects.hash_of(path) if project_file is not None or save_project else ""
        halved = Pyramid.of(photo.pixels)  # for the search and the look at the background together
        found: list[Face] = []
        if project_file is not None:
            done = projects.applied(project_file, photo, sha256)
        else:
            protection = _protection(photo, lines, width_px, feather_px)
            found = points.faces(photo, points_file, points_map, landmarks, loaded)
            chosen = common.chosen(photo, found, which, doubtful)
            done = Applied(chosen.faces, recipe, protection, chosen.note, others=chosen.others)
        finder = BackgroundFinder()
        held = held_of(photo.pixels, done, finder)
        del halved
        rendering = render(
            photo.pixels, done.faces, done.recipe, protection=done.protection, held=held
        )
        with beside(lambda: _measured(photo, rendering, done, finder)) as measured:
            write = (
                partial(_write_in_place, temporary) if in_place else partial(_write_to, to, force)
            )
            note = _write(photo, rendering, done.what, disclosure, partial(write, ahead=ahead))
    bends = measured()
    heads = unfollowed(done.faces, done.recipe)
    notes = list(filter(None, [done.note, heads, note, bends.note]))
    if save_project:
        place = projects.save(photo, sha256, found, done, project_file)
        notes.append(Text("the project is {place}", place=place))
    results = photo, to, done.faces, rendering, bends, notes
    to_json.deliver(lambda: summary.as_json(*results), lambda: summary.as_text(*results), json_file)


def _loaded(load: Callable[[], LandmarkSource] | None) -> LandmarkSource | None:
    """Load what is needed once the photo is decoded, beside that: networks, then modules."""
    source = load() if load is not None else None
    for name in _LATER:
        import_module(f"kogao_core.{name}")
    return source


def _checked_output(
    path: Path,
    sample: bool,
    output: Path | None,
    in_place: bool,
    save_project: bool,
    force: bool,
) -> Path:
    """Return where the result goes, or stop where it may not go there."""
    if in_place:
        _check_in_place(sample, output, save_project)
        return path
    if output is None:
        raise common.Stop(Text("name an output with -o, or use --in-place"), common.USAGE)
    _check_output(path, output, force)
    return output


def _check_output(path: Path, output: Path, force: bool) -> None:
    from kogao_core.photo import check_output

    if output.exists() and path.exists() and output.samefile(path) and not force:
        raise common.Stop(
            Text(
                "{output} is the photo itself; choose another output, or --force to replace it",
                output=output,
            ),
            common.USAGE,
        )
    with _writing():
        check_output(output, force=True)
    common.check_free(output, force)


def _check_in_place(sample: bool, output: Path | None, save_project: bool) -> None:
    if sample:
        raise common.Stop(
            Text("the sample isn't written over; copy it to a folder first"), common.USAGE
        )
    if output is not None:
        raise common.Stop(Text("--in-place writes over IN; leave out -o"), common.USAGE)
    if save_project:
        raise common.Stop(
            Text(
                "a project is about the photo as it was, which --in-place replaces; "
                "leave out --save-project"
            ),
            common.USAGE,
        )


def _check_photo(photo: Photo, output: Path, in_place: bool) -> None:
    from kogao_core.photo import check_holds, check_in_place

    with _writing():
        if in_place:
            check_in_place(photo)
        else:
            check_holds(output, photo.pixels)


def _measured(photo: Photo, rendering: Rendering, done: Applied, finder: BackgroundFinder) -> Bends:
    """Measure what the summary tells."""
    from kogao_core.background.find import measure

    _ = rendering.pixel_counts, rendering.residual, rendering.one_to_one  # kept there
    return measure(photo.pixels, rendering, done, finder)


def _protection(photo: Photo, lines: list[Any], width_px: float, feather_px: float) -> Protection:
    from kogao_core.base.geometry import Box
    from kogao_core.warp.limits import OutOfBounds, check_protection
    from kogao_core.warp.protection import NOTHING

    protection = NOTHING
    for line in lines:
        protection = protection.with_stroke(line, width_px / 2.0, feather_px)
    with common.stopping(OutOfBounds, common.USAGE):
        check_protection(protection, Box.of(photo.pixels))
    return protection


def _write(
    photo: Photo,
    rendering: Rendering,
    what: str,
    disclosure: Disclosure,
    write: Callable[..., str],
) -> str:
    from kogao_core.photo.disclosure.disclosing import disclose, signing, undisclosed

    left_out = undisclosed(photo, rendering.pixels, disclosure)
    with _writing():
        told = disclose(photo, rendering.pixels, disclosure, what=what)
        note = write(*told, sign=signing(disclosure, what))
    return Text.joined("; ", [note, left_out])


def _write_to(output: Path, force: bool, photo: Photo, pixels: Image, **more: Any) -> str:
    from kogao_core.photo import write

    return write(photo, pixels, output, force=force, **more)


def _write_in_place(temporary: bool, photo: Photo, pixels: Image, **more: Any) -> str:
    from kogao_core.base.originals import Originals
    from kogao_core.photo import write_in_place

    with Originals.for_now() if temporary else nullcontext(Originals.of_user()) as originals:
        return write_in_place(photo, pixels, originals, **more)


@contextmanager
def _writing() -> Iterator[None]:
    """Stop where a photo can't be written, by what is in the way."""
    from kogao_core.photo import CannotWrite, RefusedOutput

    with (
        common.stopping(CannotWrite, common.UNREADABLE),
        common.stopping(RefusedOutput, common.USAGE),
    ):
        yield
