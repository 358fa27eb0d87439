"""``kogao-cli warp``: read, find, render, write; everything is checked before work begins."""

from __future__ import annotations

import dataclasses
import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kogao_core.cli import common, options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kogao_core.bend import BentLine
    from kogao_core.face import Face
    from kogao_core.photo import Photo
    from kogao_core.pipeline import Rendering
    from kogao_core.protection import Protection
    from kogao_core.recipe import Recipe


def _lines(_: click.Context, __: click.Parameter, values: Sequence[str]) -> list[Any]:
    lines = [_corners(value) for value in values]
    for value, line in zip(values, lines, strict=True):
        if not line or any(len(corner) != 2 or not all(map(isfinite, corner)) for corner in line):
            raise click.BadParameter(f"{value!r} is not a list such as '10,20 10,400'.")
    return lines


def _corners(value: str) -> list[list[float]]:
    try:
        return [[float(part) for part in corner.split(",")] for corner in value.split()]
    except ValueError:
        return []


@click.command("warp")
@common.takes_photo
@click.option(
    "-o", "--output", required=True, type=click.Path(path_type=Path),
    help="Where to write; .jpg, .png, .tif or .webp.",
)  # fmt: skip
@options.chooses
@click.option(
    "--protect", "lines", multiple=True, metavar="'X,Y X,Y'", callback=_lines,
    help="A line, or more corners, that must not move, px of the upright photo; repeatable.",
)  # fmt: skip
@click.option(
    "--protect-width", "width_px", type=click.FloatRange(0.0), default=0.0, metavar="PX",
    help="Width of the protected lines [0: the line alone].",
)  # fmt: skip
@click.option(
    "--protect-feather", "feather_px", type=click.FloatRange(0.0), default=0.0, metavar="PX",
    help="Keep the lines' very bytes and let the move fade in over PX beside them [0: don't].",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print what was done as JSON.")
@click.option("--force", is_flag=True, help="Replace an existing output, even IN itself.")
def command(
    source: Path | None,
    sample: bool,
    max_megapixels: float,
    landmarks: str | None,
    output: Path,
    which: str,
    recipe_file: Path | None,
    lines: list[Any],
    width_px: float,
    feather_px: float,
    as_json: bool,
    force: bool,
    **choices: Any,
) -> None:
    """Make the faces in the photo IN smaller and write the result to OUTPUT."""
    recipe = options.recipe_of(recipe_file, choices)
    path = common.input_path(source, sample)
    _check_output(path, output, force)
    photo = common.read_photo(path, max_megapixels)
    _check_holds(output, photo)
    faces = _chosen(common.find_faces(photo, landmarks), which)
    rendering = _render(photo, faces, recipe, _protection(lines, width_px, feather_px))
    said = _write(photo, rendering, output, force)
    notes = [*photo.notes, *filter(None, [said])]
    if as_json:
        click.echo(json.dumps(_report(photo, output, faces, rendering, notes)))
    else:
        click.echo(_summary(photo, output, faces, rendering, notes))


def _check_output(path: Path, output: Path, force: bool) -> None:
    from kogao_core.photo import CannotWrite, RefusedOutput, check_output

    if output.exists() and path.exists() and output.samefile(path) and not force:
        raise common.Stop(
            f"{output} is the photo itself; choose another output, or --force to replace it",
            common.USAGE,
        )
    with (
        common.stopping(CannotWrite, common.UNREADABLE),
        common.stopping(RefusedOutput, common.USAGE),
    ):
        check_output(output, force=force)


def _check_holds(output: Path, photo: Photo) -> None:
    from kogao_core.photo import RefusedOutput, check_holds

    with common.stopping(RefusedOutput, common.USAGE):
        check_holds(output, photo.pixels)


def _chosen(faces: Sequence[Face], which: str) -> list[Face]:
    from kogao_core.face import select

    with common.stopping(ValueError, common.USAGE):
        return select(faces, which)


def _render(
    photo: Photo, faces: Sequence[Face], recipe: Recipe, protection: Protection
) -> Rendering:
    from kogao_core.pipeline import render

    return render(photo.pixels, faces, recipe, protection=protection)


def _protection(lines: list[Any], width_px: float, feather_px: float) -> Protection:
    from kogao_core.protection import NOTHING

    protection = NOTHING
    for line in lines:
        protection = protection.with_stroke(line, width_px / 2.0, feather_px)
    return protection


def _bent_lines(photo: Photo, rendering: Rendering) -> list[BentLine]:
    from kogao_core.bend import bends, straight_lines

    return bends(rendering.field, straight_lines(photo.pixels, rendering.domain.bounds))


def _write(photo: Photo, rendering: Rendering, output: Path, force: bool) -> str:
    from kogao_core.photo import CannotWrite, RefusedOutput, write

    with (
        common.stopping(CannotWrite, common.UNREADABLE),
        common.stopping(RefusedOutput, common.USAGE),
    ):
        return write(photo, rendering.pixels, output, force=force)


def _report(
    photo: Photo, output: Path, faces: Sequence[Face], rendering: Rendering, notes: list[str]
) -> dict[str, Any]:
    return {
        "input": str(photo.path),
        "output": str(output),
        "image": {"width": photo.width, "height": photo.height},
        "faces": [face.to_dict() for face in faces],
        "recipe": rendering.recipe.to_dict(),
        "timings_ms": rendering.timings_ms,
        "domains": {
            name: {"pixels": count, "percent": 100.0 * count / (photo.width * photo.height)}
            for name, count in rendering.pixel_counts.items()
        },
        "residual": dataclasses.asdict(rendering.residual),
        "shares": list(rendering.shares),
        "one_to_one": dataclasses.asdict(rendering.one_to_one),
        "lines": [dataclasses.asdict(line) for line in _bent_lines(photo, rendering)],
        "notes": notes,
    }


def _summary(
    photo: Photo, output: Path, faces: Sequence[Face], rendering: Rendering, notes: list[str]
) -> str:
    recipe, share = rendering.recipe, photo.width * photo.height / 100.0
    counts = rendering.pixel_counts.items()
    sound = rendering.one_to_one
    lines = [
        f"{photo.path}: {common.count_of_faces(len(faces))}, {recipe.percent:g} % towards centre "
        f"{recipe.center}, written to {output}",
        "domain    " + ", ".join(f"{name} {count / share:.1f} %" for name, count in counts),
        f"residual  {rendering.residual.max_px:.2f} px at most; min det J {sound.min_det:.2f}",
        "time      " + ", ".join(f"{n} {ms:.1f}" for n, ms in rendering.timings_ms.items()) + " ms",
    ]
    if bent := _bent_lines(photo, rendering):
        worst = bent[0]
        (x, y), (u, v) = worst.start_px, worst.end_px
        lines.append(
            f"lines     {len(bent)} straight ones nearby; the one from {x:.0f},{y:.0f} to "
            f"{u:.0f},{v:.0f} bends by {worst.bend_px:.1f} px"
        )
    if min(rendering.shares) < 1.0:
        kept = ", ".join(f"{100 * share:.0f} %" for share in rendering.shares)
        lines.append(f"guard     held back to {kept} of the move, which would have folded")
    if sound.folded_cells:
        lines.append(
            f"warning   the warp folds in {len(sound.folded_cells)} places: lower --percent or "
            "raise --lattice"
        )
    elif not sound.edges_proven:
        lines.append(
            "warning   thin folds where the threshold fades in can't be ruled out: --guard"
        )
    return "\n".join([*lines, *(f"note      {note}" for note in notes)])
