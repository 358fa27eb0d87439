"""The summary that `kogao-cli warp` prints, as text and as JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from kogao_core.background.find import Bends
from kogao_core.background.lines import SEEN_PX, BentLine
from kogao_core.base.language import Text, tr, translated
from kogao_core.base.wording import columns
from kogao_core.cli import common
from kogao_core.faces.face import Face
from kogao_core.photo import Photo
from kogao_core.pipeline import STAGES, Rendering
from kogao_core.recipe.recipe import SETTINGS
from kogao_core.warp.measures import asked_percent
from kogao_core.warp.one_to_one import OneToOne

# What the lines begin with, in a column of their own.
DOSE, DOMAIN, RESIDUAL = Text("dose"), Text("domain"), Text("residual")
TIME, LINES, HELD = Text("time"), Text("lines"), Text("held")
GUARD, WARNING, NOTE = Text("guard"), Text("warning"), Text("note")
_LABEL_COLUMNS: Final = 10


def as_json(
    photo: Photo,
    output: Path,
    faces: Sequence[Face],
    rendering: Rendering,
    bends: Bends,
    notes: list[str],
) -> dict[str, Any]:
    """Return all figures as plain values."""
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
        "dose": [
            {"asked_percent": asked, "achieved_percent": achieved}
            for asked, achieved in _doses(rendering)
        ],
        "residual": dataclasses.asdict(rendering.residual),
        "shares": list(rendering.shares),
        "brush_shares": list(rendering.brush_shares),
        "threshold_px": rendering.threshold_px,
        "one_to_one": dataclasses.asdict(rendering.one_to_one),
        "lines": [dataclasses.asdict(line) for line in bends.lines],
        "notes": notes,
    }


def as_text(
    photo: Photo,
    output: Path,
    faces: Sequence[Face],
    rendering: Rendering,
    bends: Bends,
    notes: list[str],
) -> str:
    """Return the figures that matter most, in lines."""
    recipe, share = rendering.recipe, photo.width * photo.height / 100.0
    counts = rendering.pixel_counts.items()
    sound, laps = rendering.one_to_one, rendering.timings_ms.items()
    lines = [
        tr(
            "{path}: {faces}, {amount}, written to {output}",
            path=photo.path,
            faces=common.count_of_faces(len(faces)),
            amount=recipe.amount,
            output=output,
        ),
        *(
            _line(DOSE, _dose(asked, achieved, number if len(faces) > 1 else None))
            for number, (asked, achieved) in enumerate(_doses(rendering), start=1)
        ),
        _line(DOMAIN, Text.joined(", ", (_share(name, count / share) for name, count in counts))),
        _line(
            RESIDUAL,
            Text(
                "{px:.2f} px at most at the targets; smallest det J of the samples {det:.2f}",
                px=rendering.residual.max_px,
                det=sound.min_det,
            ),
        ),
        _line(TIME, Text("{stages} ms", stages=Text.joined(", ", (_lap(*one) for one in laps)))),
    ]
    if bends.lines:
        lines += [_line(LINES, _bent(bends)), *_held(bends.lines)]
    if min(rendering.shares, default=1.0) < 1.0:
        kept = ", ".join(f"{100 * share:.0f} %" for share in rendering.shares)
        held = Text("held back to {kept} of the move, which would have folded", kept=kept)
        lines.append(_line(GUARD, held))
    if min(rendering.brush_shares, default=1.0) < 1.0:
        kept = ", ".join(f"{100 * share:.0f} %" for share in rendering.brush_shares)
        held = Text("brush strokes held back to {kept}, more would have folded", kept=kept)
        lines.append(_line(GUARD, held))
    if rendering.threshold_px < recipe.threshold_px:
        unused = Text(
            "threshold {px:g} px not used, its edge could have folded: all that moves was worked "
            "on",
            px=recipe.threshold_px,
        )
        lines.append(_line(GUARD, unused))
    if warning := _warning(sound):
        lines.append(_line(WARNING, warning))
    return "\n".join([*lines, *(_line(NOTE, note) for note in notes)])


def _line(label: Text, what: str) -> str:
    said = translated(label)
    return f"{said}{' ' * (_LABEL_COLUMNS - columns(said))}{translated(what)}"


def _share(domain: str, percent: float) -> Text:
    called = SETTINGS["domain"].alternative(domain).word
    return Text("{domain} {percent:.1f} %", domain=called, percent=percent)


def _lap(stage: str, ms: float) -> Text:
    return Text("{stage} {ms:.1f}", stage=STAGES[stage], ms=ms)


def _dose(asked: float, achieved: float, face: int | None) -> Text:
    if face is None:
        return Text(
            "asked for {asked:.2f} % of D, achieved {achieved:.2f} %",
            asked=asked,
            achieved=achieved,
        )
    return Text(
        "asked for {asked:.2f} % of D, achieved {achieved:.2f} %, face {face}",
        asked=asked,
        achieved=achieved,
        face=face,
    )


def _warning(sound: OneToOne) -> Text | None:
    if sound.folded_cells:
        return Text.counted(
            len(sound.folded_cells),
            "the warp folds in {n} place: lower --percent or raise --lattice",
            "the warp folds in {n} places: lower --percent or raise --lattice",
        )
    if not sound.edges_proven:
        return Text("thin folds where the threshold fades in can't be ruled out: --guard")
    if not sound.settled:
        return Text("folds between the samples can't be ruled out: --guard")
    return None


def _bent(bends: Bends) -> Text:
    """Return how many lines are near, and how far the worst one bends."""
    worst = bends.lines[0]
    return Text(
        "{count} straight ones {where}; the one from {x:.0f},{y:.0f} to {u:.0f},{v:.0f} bends by "
        "{bend:.1f} px (its edge was {before:.1f} px off straight and is {after:.1f})",
        count=len(bends.lines),
        where=Text("nearby") if bends.note else Text("in the background"),
        **_ends(worst),
        bend=worst.bend_px,
        before=worst.before_px,
        after=worst.after_px,
    )


def _held(lines: Sequence[BentLine]) -> list[str]:
    """Return how many lines were held, and of the one that gave way most, by how much."""
    meant = ("held", "gave way")
    held = [line for line in lines if line.holding in meant and line.unheld_px >= SEEN_PX]
    if not held:
        return []
    count = Text("{count} that would have bent by {px} px or more", count=len(held), px=SEEN_PX)
    worst = max(held, key=lambda line: line.bend_px)
    if worst.bend_px < SEEN_PX:
        return [_line(HELD, count)]
    gave_way = Text(
        "the one from {x:.0f},{y:.0f} to {u:.0f},{v:.0f} gave way to the face: {bend:.1f} of "
        "{unheld:.1f} px are left",
        **_ends(worst),
        bend=worst.bend_px,
        unheld=worst.unheld_px,
    )
    return [_line(HELD, Text.joined("; ", [count, gave_way]))]


def _ends(line: BentLine) -> dict[str, float]:
    return dict(zip("xyuv", (*line.start_px, *line.end_px), strict=True))


def _doses(rendering: Rendering) -> list[tuple[float, float]]:
    """Return how far each face was asked to come towards its centre, and how far it came."""
    asked = (asked_percent(pairs) for pairs in rendering.pairs)
    return list(zip(asked, rendering.achieved, strict=True))
