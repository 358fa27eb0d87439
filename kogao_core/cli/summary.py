"""The report of `kogao-cli warp`: one line, warnings, measurements, JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from kogao_core.background.find import MeasuredLines
from kogao_core.background.lines import SEEN_DEGREES
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import columns
from kogao_core.cli import common
from kogao_core.faces.face import Face
from kogao_core.field.measures import asked_percent, reduced
from kogao_core.photo import Photo
from kogao_core.pipeline import STAGES, Measurement, Rendering
from kogao_core.recipe.recipe import SETTINGS, Recipe

_LABEL_COLUMNS: Final = 15
_LEAST_PERCENT: Final = 0.005  # a smaller change prints "unchanged"
_DEFAULTS: Final = Recipe()


@dataclass(frozen=True, kw_only=True)
class WarpReport:
    """Everything known about a saved result."""

    photo: Photo
    output: Path
    faces: Sequence[Face]
    rendering: Rendering
    measurement: Measurement
    lines: MeasuredLines
    file_note: str  # unchanged share of a JPEG, lost metadata
    notes: Sequence[str]  # further sentences

    def to_dict(self) -> dict[str, Any]:
        """Return all figures as plain values."""
        photo, rendering = self.photo, self.rendering
        return {
            "input": str(photo.path),
            "output": str(self.output),
            "image": {"width": photo.width, "height": photo.height},
            "faces": [face.to_dict() for face in self.faces],
            "recipe": rendering.recipe.to_dict(),
            "timings_ms": rendering.timings_ms,
            "domains": {
                name: {"pixels": count, "percent": 100.0 * count / (photo.width * photo.height)}
                for name, count in self.measurement.pixel_counts.items()
            },
            "dose": [
                {"asked_percent": requested, "achieved_percent": achieved}
                for requested, achieved in _amounts(rendering, self.measurement)
            ],
            "residual": dataclasses.asdict(self.measurement.residual),
            "shares": list(rendering.shares),
            "limits": [dataclasses.asdict(limit) for limit in rendering.limits],
            "brush_shares": list(rendering.brush_shares),
            "protected_shares": [list(shares) for shares in self.measurement.protected_shares],
            "threshold_px": rendering.threshold_px,
            "one_to_one": dataclasses.asdict(self.measurement.one_to_one),
            "lines": [dataclasses.asdict(line) for line in self.lines.lines],
            "notes": [*filter(None, [*self.notes, self.file_note])],
        }

    def headline(self) -> str:
        """Return one line: output file, faces, change, unchanged share of the file."""
        done = Text(
            "{output}: {faces}, {change}",
            output=self.output,
            faces=common.count_of_faces(len(self.faces)),
            change=_change(self.rendering.recipe, self.faces, self.measurement.achieved),
        )
        return translated(Text.joined("; ", [done, self.file_note]))

    def warnings(self) -> Iterator[str]:
        """Yield sentences on anything the user should check."""
        rendering = self.rendering
        yield from self.notes
        limited = zip(rendering.shares, rendering.limited_points, strict=True)
        for face, (share, point) in enumerate(limited, start=1):
            if share < 1.0:
                yield Text(
                    "face {face} is reduced to {kept:.0f} % near point {point}; more would "
                    "squeeze the picture",
                    face=face,
                    kept=100 * share,
                    point=point,
                )
        if min(rendering.brush_shares, default=1.0) < 1.0:
            limits = ", ".join(f"{100 * share:.0f} %" for share in rendering.brush_shares)
            yield Text(
                "brush strokes limited to {limits}, more would fold the picture", limits=limits
            )
        if slowed := reduced(self.measurement.protected_shares):
            yield Text.counted(
                len(slowed),
                "{n} outline point moves less because of protection, {least:.0f} % of its way",
                "{n} outline points move less because of protection, the least {least:.0f} % "
                "of its way",
                least=100 * min(slowed),
            )
        if rendering.threshold_px < rendering.recipe.threshold_px:
            yield Text(
                "threshold {px:g} px ignored, because the edge could fold; all moving pixels "
                "were computed",
                px=rendering.recipe.threshold_px,
            )
        if told := self.lines.told:
            yield told
        found = self.measurement.one_to_one
        if found.folded_cells:
            yield Text.counted(
                len(found.folded_cells),
                "the picture folds in {n} place; use a smaller --amount, a larger --lattice or "
                "--guard",
                "the picture folds in {n} places; use a smaller --amount, a larger --lattice or "
                "--guard",
            )
        elif not found.edges_proven:
            yield Text("the edge of the threshold could fold; use --guard")
        elif not found.settled:
            yield Text("folds between the samples are possible; use --guard")

    def details(self) -> str:
        """Return the measurements, one labelled line each."""
        lines = []
        for label, measured in self._measurements():
            name = translated(label)
            space = " " * max(1, _LABEL_COLUMNS - columns(name))
            lines.append(f"  {name}{space}{translated(measured)}")
        return "\n".join(lines)

    def _measurements(self) -> Iterator[tuple[Text, str]]:
        """Yield label and value of each measurement."""
        rendering, percent_px = self.rendering, self.photo.width * self.photo.height / 100.0
        yield Text("centre"), str(rendering.recipe.center)
        amounts = [
            Text(
                "requested {requested:.2f} %, achieved {achieved:.2f} % of the distance to the "
                "centre",
                requested=requested,
                achieved=achieved,
            )
            for requested, achieved in _amounts(rendering, self.measurement)
        ]
        if len(set(amounts)) == 1:
            yield Text("amount"), amounts[0]
        else:
            for number, amount in enumerate(amounts, start=1):
                yield (
                    Text("amount"),
                    Text("face {number}: {why}", number=number, why=amount),
                )
        yield (
            Text("accuracy"),
            Text("largest error at the targets {px:.2f} px", px=self.measurement.residual.max_px),
        )
        yield (
            Text("folds"),
            Text(
                "{count}; smallest Jacobian determinant of the samples {det:.2f}",
                count=len(self.measurement.one_to_one.folded_cells),
                det=self.measurement.one_to_one.min_det,
            ),
        )
        domains = SETTINGS["domain"]
        parts = (
            Text(
                "{domain} {percent:.1f} %",
                domain=domains.alternative(name).word,
                percent=pixels / percent_px,
            )
            for name, pixels in self.measurement.pixel_counts.items()
        )
        yield Text("domain"), Text.joined(", ", parts)
        yield from self._lines()
        laps = (
            Text("{stage} {ms:.1f}", stage=STAGES[stage], ms=ms)
            for stage, ms in rendering.timings_ms.items()
        )
        yield Text("time"), Text("{stages} ms", stages=Text.joined(", ", laps))

    def _lines(self) -> Iterator[tuple[Text, Text]]:
        """Yield the number of straight lines, and the figures of the one that turns most."""
        if not self.lines.lines:
            return
        worst = self.lines.lines[0]
        yield (
            Text("lines nearby") if self.lines.note else Text("lines"),
            Text(
                "{count}; largest turn {degrees:.1f}°, from {x:.0f},{y:.0f} to {u:.0f},{v:.0f}; "
                "largest rise {rise:.0f} thousandths of the face's width",
                count=len({one.number for one in self.lines.lines}),
                **dict(zip("xyuv", (*worst.start_px, *worst.end_px), strict=True)),
                degrees=worst.turn_degrees,
                rise=max(one.rise_permille for one in self.lines.lines),
            ),
        )
        kept = {
            one.number
            for one in self.lines.lines
            if one.holding == "held" and one.unheld_turn_degrees >= SEEN_DEGREES
        }
        if kept:
            yield (
                Text("kept straight"),
                Text(
                    "{count} would have turned by {degrees:.0f}° or more",
                    count=len(kept),
                    degrees=SEEN_DEGREES,
                ),
            )


def _change(recipe: Recipe, faces: Sequence[Face], achieved: Sequence[float]) -> Text:
    """Return the achieved amount in words, or "reshaped" if other settings changed the face."""
    recipes = [recipe, *(face.recipe for face in faces)]
    if any(each is not None and _reshapes(each) for each in recipes):
        return Text("reshaped")
    low, high = min(achieved, default=0.0), max(achieved, default=0.0)
    if low < -_LEAST_PERCENT and high > _LEAST_PERCENT:
        return Text("reshaped")
    if max(-low, high) < _LEAST_PERCENT:
        return Text("unchanged")
    first, last = sorted((_rounded(abs(low)), _rounded(abs(high))), key=float)
    amount = first if first == last else Text("{first} to {last}", first=first, last=last)
    if high > _LEAST_PERCENT:
        return Text("{amount} % smaller", amount=amount)
    return Text("{amount} % larger", amount=amount)


def _reshapes(recipe: Recipe) -> bool:
    """Return True if settings other than the amount, its centre and the head change faces."""
    for name, setting in SETTINGS.items():
        if setting.is_method or name in ("percent", "center", "scope"):
            continue
        if setting.counts(recipe) and getattr(recipe, name) != getattr(_DEFAULTS, name):
            return True
    return False


def _rounded(percent: float) -> str:
    return f"{percent:.2g}" if percent < 1.0 else f"{round(percent, 1):g}"


def _amounts(rendering: Rendering, measurement: Measurement) -> list[tuple[float, float]]:
    """Return the requested and the achieved amount of each face, in % of the distance."""
    requested = (asked_percent(pairs) for pairs in rendering.pairs)
    return list(zip(requested, measurement.achieved, strict=True))
