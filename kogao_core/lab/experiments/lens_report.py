"""What the lens' correction leaves as a report: one table by place, one by photo, pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Final

import numpy as np

from kogao_core.base.language import Text
from kogao_core.lab.experiments.lens import LensResult, Scene, Stretch
from kogao_core.lab.reports.report import (
    NONE,
    Part,
    Picture,
    Report,
    Row,
    Table,
    recipe_in_words,
)

_SCENES: Final[dict[Scene, Text]] = {
    "alone": Text("with room"),
    "near": Text("its hair at the edge"),
    "cut": Text("cut by the edge"),
    "touching": Text("one of three that touch"),
}
SHOWN: Final = (Text("as the lens draws it"), Text("corrected"), Text("on the axis"))


def report(result: LensResult) -> Report:
    """Return what is left by scene, focal length and place, photos together."""
    name = result.stretches[0].photo
    pictures = [
        Picture(pixels, Text("{photo}, {what}", photo=name, what=what), what)
        for what, pixels in zip(SHOWN, result.shown, strict=False)
    ]
    parts: list[Part] = [
        *([Row(pictures)] if pictures else []),
        Text("{recipe}.", recipe=recipe_in_words(result.recipe)),
        _table(result),
    ]
    return Report(
        Text("A face at the edge of a wide photo"),
        Text(
            "A face that was photographed on the axis is put at the edge of a wide photo by the "
            "homography of a camera aimed elsewhere; how far does the correction bring it back?"
        ),
        parts,
        [asdict(one) for one in result.stretches],
        {
            "experiment": "lens",
            "recipe": result.recipe.to_dict(),
            "stretches": [asdict(one) for one in result.stretches],
        },
    )


def _table(result: LensResult) -> Table:
    groups: dict[tuple[Scene, float, float], list[Stretch]] = {}
    for one in result.stretches:
        groups.setdefault((one.scene, one.focal_mm, one.share), []).append(one)
    return Table(
        Text("A face that the lens stretched, before and after: median (worst)"),
        (
            Text("face"),
            Text("mm"),
            Text("% of the half width"),
            Text("residual before, %"),
            Text("after, known points"),
            Text("after, found points"),
            Text("aspect before, %"),
            Text("after"),
            Text("least det J"),
            Text("lines, 1/1000"),
            Text("neighbours, px"),
        ),
        [
            (
                _SCENES[scene], f"{focal_mm:.0f}", f"{100.0 * share:.0f}",
                _spread(group, lambda one: one.before_percent),
                _spread(group, lambda one: one.after_percent),
                _spread(group, lambda one: one.found_percent),
                _spread(group, lambda one: one.aspect_before_percent),
                _spread(group, lambda one: one.aspect_after_percent),
                f"{min(one.min_det for one in group):.2f}",
                _spread(group, lambda one: one.bent_per_mille),
                _spread(group, lambda one: one.dragged_px),
            )
            for (scene, focal_mm, share), group in groups.items()
        ],
        Text(
            "Residual: after the best similarity, of the landmarks in the photo, % of the distance "
            "of the outer eye corners. Aspect: width over height. Lines: the most bent one beside "
            "the head, of the face's width. Neighbours: at 1000 px of height."
        ),
    )  # fmt: skip


def _spread(group: Sequence[Stretch], figure: Callable[[Stretch], float | None]) -> str:
    values = [value for value in map(figure, group) if value is not None]
    if not values:
        return NONE
    worst = max(values, key=abs)
    return f"{np.median(values):.2f} ({worst:.2f})"
