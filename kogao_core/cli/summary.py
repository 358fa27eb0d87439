"""The summary that `kogao-cli warp` prints, as text and as JSON."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kogao_core.cli import common

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kogao_core.background import Bends
    from kogao_core.bend import BentLine
    from kogao_core.face import Face
    from kogao_core.photo import Photo
    from kogao_core.pipeline import Rendering


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
    sound = rendering.one_to_one
    lines = [
        f"{photo.path}: {common.count_of_faces(len(faces))}, {recipe.amount}, written to {output}",
        *(
            f"dose      asked for {asked:.2f} % of D, achieved {achieved:.2f} %{_of(number, faces)}"
            for number, (asked, achieved) in enumerate(_doses(rendering), start=1)
        ),
        "domain    " + ", ".join(f"{name} {count / share:.1f} %" for name, count in counts),
        f"residual  {rendering.residual.max_px:.2f} px at most; min det J {sound.min_det:.2f}",
        "time      " + ", ".join(f"{n} {ms:.1f}" for n, ms in rendering.timings_ms.items()) + " ms",
    ]
    if bends.lines:
        worst = bends.lines[0]
        (x, y), (u, v) = worst.start_px, worst.end_px
        where = "nearby" if bends.note else "in the background"
        lines.append(
            f"lines     {len(bends.lines)} straight ones {where}; the one from "
            f"{x:.0f},{y:.0f} to {u:.0f},{v:.0f} bends by {worst.bend_px:.1f} px (its edge was "
            f"{worst.before_px:.1f} px off straight and is {worst.after_px:.1f})"
        )
        lines += _held(bends.lines)
    if min(rendering.shares, default=1.0) < 1.0:
        kept = ", ".join(f"{100 * share:.0f} %" for share in rendering.shares)
        lines.append(f"guard     held back to {kept} of the move, which would have folded")
    if rendering.threshold_px < recipe.threshold_px:
        lines.append(
            f"guard     threshold {recipe.threshold_px:g} px not used, its edge could have folded: "
            "all that moves was worked on"
        )
    if sound.folded_cells:
        lines.append(
            f"warning   the warp folds in {len(sound.folded_cells)} places: lower --percent or "
            "raise --lattice"
        )
    elif not sound.edges_proven:
        lines.append(
            "warning   thin folds where the threshold fades in can't be ruled out: --guard"
        )
    elif not sound.settled:
        lines.append("warning   folds between the samples can't be ruled out: --guard")
    return "\n".join([*lines, *(f"note      {note}" for note in notes)])


def _held(lines: Sequence[BentLine]) -> list[str]:
    """Return how many lines were held, and of the one that gave way most, by how much."""
    from kogao_core.bend import SEEN_PX

    held = [line for line in lines if line.holding == "held" and line.unheld_px >= SEEN_PX]
    if not held:
        return []
    text = f"held      {len(held)} that would have bent by {SEEN_PX} px or more"
    worst = max(held, key=lambda line: line.bend_px)
    if worst.bend_px >= SEEN_PX:
        (x, y), (u, v) = worst.start_px, worst.end_px
        text += (
            f"; the one from {x:.0f},{y:.0f} to {u:.0f},{v:.0f} gave way to the face: "
            f"{worst.bend_px:.1f} of {worst.unheld_px:.1f} px are left"
        )
    return [text]


def _doses(rendering: Rendering) -> list[tuple[float, float]]:
    """Return how far each face was asked to come towards its centre, and how far it came."""
    from kogao_core.dose import asked_percent

    asked = (asked_percent(pairs) for pairs in rendering.pairs)
    return list(zip(asked, rendering.achieved, strict=True))


def _of(number: int, faces: Sequence[Face]) -> str:
    return f", face {number}" if len(faces) > 1 else ""
