"""Stimuli that come out whole: a face at several doses, with its points, measures and fields."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.atomic import put
from kogao_core.base.display import png, reduced, rgb8
from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.batch.measures import codebook_of, measured, write
from kogao_core.faces.face import Face
from kogao_core.lab.reports.report import Part, Picture, Report, Row, Table
from kogao_core.lab.subjects import Progress, no_progress
from kogao_core.photo import Photo
from kogao_core.pipeline import Rendering, render
from kogao_core.projects import evidence, interchange
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe
from kogao_core.warp.field import Field, shown_at
from kogao_core.warp.lattice import ORDER, Lattice
from kogao_core.warp.measures import moved

Mask = Literal["oval", "outline"]
Export = Literal["tfm", "evidence"]
# As the paper, but for a dose that is the one asked for, and the sharper kernel.
STIMULI: Final = dataclasses.replace(PAPER, fit="exact", interpolation="cubic")
# Where the middles of the eyes lie in an aligned picture, in shares of its width and height.
_EYES: Final = ((0.39, 0.45), (0.61, 0.45))
MEASURES: Final = "measures.csv"
CONTACT: Final = "contact.png"
_SUBPIXEL_BITS: Final = 4
_THUMBNAIL_PX: Final = 200
_KEPT_PX: Final = 320  # longer side of pictures to look at, once they are written


def doses(text: str) -> tuple[float, ...]:
    """Read different doses, % of D, with commas between them. Raises ValueError."""
    try:
        percents = tuple(float(part) for part in text.split(","))
        for percent in percents:
            SETTINGS["percent"].check(percent)
    except ValueError:
        raise ValueError(
            Text("{value} must be doses within -15..15, such as -8,-4,0,4,8.", value=shown(text))
        ) from None
    return tuple(dict.fromkeys(percents))


@dataclass(frozen=True)
class Wanted:
    """Doses and formats of the pictures."""

    percents: tuple[float, ...]  # doses asked for; below 0 the face gets larger
    recipe: Recipe = STIMULI  # all else
    size: tuple[int, int] | None = None  # width and height of aligned pictures; None as the photo
    mask: Mask | None = None  # visible part of a picture; None: all
    exports: tuple[Export, ...] = ()  # which kinds of fields are written


@dataclass(frozen=True, eq=False)
class Posed:
    """A photo with its faces and all points that are known of them, px of the photo."""

    photo: Photo
    faces: tuple[Face, ...]
    points: tuple[Array, ...] = ()  # as a file has them, of each face; empty where none had


@dataclass(frozen=True, eq=False)
class Stimulus:
    """One picture at one dose."""

    name: str  # of its files, without ending: the photo's and the dose
    percent: float  # the dose asked for
    pixels: Image  # (H, W, 3) or, masked, (H, W, 4): uint8
    faces: tuple[Face, ...]  # where the picture shows them
    points: tuple[Array, ...]  # likewise all points of the files
    records: list[dict[str, Any]] = field(default_factory=list)  # measures, one for each face
    files: dict[str, bytes] = field(default_factory=dict)  # fields by their endings


def stimuli(posed: Posed, wanted: Wanted) -> Iterator[Stimulus]:
    """Yield one photo at each dose; the field is evaluated where the picture is resampled, once."""
    align = Affine(np.eye(2), np.zeros(2))
    pixels = posed.photo.pixels
    if wanted.size is not None:
        align = aligning(posed.faces[0], wanted.size)
        pixels = np.asarray(cv2.warpAffine(pixels, align.opencv, wanted.size))
    faces = tuple(face.mapped(align) for face in posed.faces)
    points = tuple(align(one) for one in posed.points)
    for percent in wanted.percents:
        rendering = render(pixels, faces, dataclasses.replace(wanted.recipe, percent=percent))
        result = rendering.pixels
        if wanted.size is not None:
            result = _once(posed.photo.pixels, rendering.field, align, wanted.size)
        pairs = zip(faces, rendering.pairs, strict=True)
        there = tuple(moved(face, rendering.field, pair) for face, pair in pairs)
        name = f"{posed.photo.path.stem}_{percent:+06.2f}"
        yield Stimulus(
            name,
            percent,
            _masked(rgb8(result), there, wanted.mask),
            there,
            tuple(shown_at(rendering.field, one) for one in points),
            measured(f"{name}.png", posed.photo.path.name, rendering, faces),
            dict(_exported(rendering, wanted.exports)),
        )  # fmt: skip


def aligning(face: Face, size: tuple[int, int]) -> Affine:
    """Return the similarity that puts the middles of a face's eyes where all pictures have them."""
    goal = np.array(_EYES) * size
    eyes = face.eyes.reshape(2, 2, 2).mean(axis=1)
    (dx, dy), (gx, gy) = eyes[1] - eyes[0], goal[1] - goal[0]
    turn = complex(gx, gy) / complex(dx, dy)
    matrix = np.array([[turn.real, -turn.imag], [turn.imag, turn.real]])
    return Affine(matrix, goal.mean(axis=0) - matrix @ eyes.mean(axis=0))


def _once(photo: Image, field: Field, align: Affine, size: tuple[int, int]) -> Image:
    """Resample the photo through alignment and warp together."""
    xs, ys = np.arange(size[0]), np.arange(size[1])
    displacement = field.on_grid(xs, ys)
    read = np.stack([displacement[0] + xs, displacement[1] + ys[:, None]], axis=-1)
    x, y = align.inverse(read).astype(np.float32).transpose(2, 0, 1)
    return np.asarray(
        cv2.remap(photo, x.copy(), y.copy(), cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    )


def _masked(pixels: Image, faces: Sequence[Face], mask: Mask | None) -> Image:
    if mask is None:
        return pixels
    alpha = np.zeros(pixels.shape[:2], np.uint8)
    for face in faces:
        rim = () if face.forehead is None else (face.forehead[::-1],)
        line = np.vstack([face.outline, *rim])
        if mask == "oval":
            center, axes, degrees = cv2.fitEllipse(line.astype(np.float32))
            turn = Affine.similarity(1.0, degrees, center)
            angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
            line = turn(np.column_stack([np.cos(angle), np.sin(angle)]) * np.array(axes) / 2.0)
        fixed = np.round(line * 2**_SUBPIXEL_BITS).astype(np.int32)
        cv2.fillPoly(alpha, [fixed], (255,), cv2.LINE_AA, _SUBPIXEL_BITS)
    return np.dstack([pixels, alpha])


def written(
    posed: Posed, wanted: Wanted, folder: Path, form: str = "csv", progress: Progress = no_progress
) -> list[Stimulus]:
    """Write a photo's pictures with their points and fields; the folder is made if need be.

    Result: without fields, the pixels small.
    """
    folder.mkdir(parents=True, exist_ok=True)
    row = []
    for done, one in enumerate(stimuli(posed, wanted), start=1):
        out = io.BytesIO()
        Pillow.fromarray(one.pixels).save(out, "PNG", icc_profile=posed.photo.icc_profile)
        put(out.getvalue(), folder / f"{one.name}.png")
        points = one.points or [interchange.own_points(face) for face in one.faces]
        interchange.write_points(points, folder / f"{one.name}.{form}")
        for suffix, data in one.files.items():
            put(data, folder / f"{one.name}{suffix}")
        small = reduced(one.pixels, _KEPT_PX)
        row.append(dataclasses.replace(one, pixels=small, files={}))
        progress(done, len(wanted.percents))
    return row


def finish(rows: Sequence[Sequence[Stimulus]], folder: Path) -> None:
    """Write the files about all pictures: `MEASURES`, its codebook, and `CONTACT`."""
    records = (record for row in rows for one in row for record in one.records)
    write(records, folder / MEASURES)
    put(sheet(rows), folder / CONTACT)


def files_of(photo: Path, percents: Sequence[float], folder: Path) -> list[Path]:
    """Return a photo's pictures, and the files that tell of all."""
    names = [f"{photo.stem}_{percent:+06.2f}.png" for percent in percents]
    told = MEASURES, codebook_of(Path(MEASURES)).name, CONTACT
    return [folder / name for name in (*names, *told)]


def sheet(rows: Sequence[Sequence[Stimulus]]) -> bytes:
    """Return a contact sheet: a row for each photo, a column for each dose, with names, as PNG."""
    lines = []
    for row in rows:
        cells = []
        for one in row:
            small = reduced(one.pixels, _THUMBNAIL_PX)
            cell = np.full((_THUMBNAIL_PX + 20, _THUMBNAIL_PX, 3), 255, np.uint8)
            share = small[..., 3:] / 255.0 if small.shape[2] == 4 else 1.0
            place = cell[: small.shape[0], : small.shape[1]]
            place[:] = np.round(share * small[..., :3] + (1.0 - share) * place)
            at = 4, _THUMBNAIL_PX + 14
            font = cv2.FONT_HERSHEY_SIMPLEX
            cv2.putText(cell, one.name[-26:], at, font, 0.4, (32, 32, 32), 1, cv2.LINE_AA)
            cells.append(cell)
        lines.append(np.hstack(cells))
    return png(np.vstack(lines))


def report(rows: Sequence[Sequence[Stimulus]], recipe: Recipe) -> Report:
    """Return the report: requested and achieved dose of each face, with the pictures."""
    records = [record for row in rows for one in row for record in one.records]
    seen = [Picture(rgb8(one.pixels), one.name, one.name) for row in rows for one in row]
    names = (
        "asked_percent", "achieved_percent", "width_change_percent", "jaw_change_percent",
        "area_change_percent", "smallest_det_sampled",
    )  # fmt: skip
    cells = [[record["picture"], *(f"{record[name]:.2f}" for name in names)] for record in records]
    header = (
        Text("picture"), Text("asked for, % of D"), Text("achieved, % of D"), Text("width, %"),
        Text("jaw, %"), Text("area, %"), Text("smallest det J"),
    )  # fmt: skip
    note = Text("Width, jaw and area: how much each has changed. All else is in the table (CSV).")
    title = Text("Faces at several doses")
    document: dict[str, object] = {"experiment": "stimuli", "recipe": recipe.to_dict()}
    document["pictures"] = records
    parts: list[Part] = [Row(seen), Table(title, header, cells, note)]
    lead = Text("One face in pictures that differ by the dose alone.")
    hung = [(f"{one.percent:+g} %", rgb8(one.pixels)) for one in rows[0]]
    return Report(title, lead, parts, records, document, {Text("Pictures"): hung})


# -- fields for other programs ---------------------------------------------------------------------


def _exported(rendering: Rendering, kinds: Sequence[Export]) -> Iterator[tuple[str, bytes]]:
    if "tfm" in kinds:
        for number, lattice in enumerate(rendering.field.lattices, start=1):
            yield f"-face{number}.tfm", tfm(lattice)
    if "evidence" in kinds:
        yield "-evidence.npz", evidence.to_bytes(rendering.evidence())


def tfm(lattice: Lattice) -> bytes:
    """Return a lattice as ITK's BSplineTransform of order 3, a text file; exact, but for rounding.

    ITK moves nothing outside the cells with all their control points, so zeros go round them.
    """
    rows, columns = (n + 2 * ORDER for n in lattice.shape)
    first = lattice.first[0] - ORDER, lattice.first[1] - ORDER
    phi = lattice.window(first, (rows, columns))
    h, (x, y) = lattice.grid.spacing_px, lattice.grid.origin_px
    origin = x + h * first[0], y + h * first[1]
    fixed = (columns, rows, *origin, h, h, 1, 0, 0, 1)
    numbers = [*phi[..., 0].ravel().tolist(), *phi[..., 1].ravel().tolist()]
    lines = [
        "#Insight Transform File V1.0",
        "#Transform 0",
        "Transform: BSplineTransform_double_2_2",
        f"Parameters: {' '.join(map(repr, numbers))}",
        f"FixedParameters: {' '.join(map(repr, fixed))}",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")
