"""Make the pictures of the documentation from the program's own sample.

``python docs/pictures/make.py docs/pictures [SHEETS]``

With the folder that has SFHQ's sheets of generated faces, the moving picture of the README and the
gallery are made, too. The window in Japanese needs a font with Japanese letters (Debian:
fonts-noto-cjk).
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

import cv2
import jpeglib
import numpy as np
import PIL.Image
from PIL import ImageDraw, ImageFont

from kogao_core.base import assets
from kogao_core.base.atomic import put
from kogao_core.base.geometry import Image
from kogao_core.faces.landmarks import MeshSource
from kogao_core.lab.experiments.lens import shown as shown_at_the_edge
from kogao_core.lab.subjects import Subject
from kogao_core.photo import read
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

PERCENT: Final = 6.0
GAP_PX: Final = 12
_INSPECT: Final = ("--workspace", "inspect")
WINDOWS: Final = {
    "window": (),
    "japanese": ("--language", "ja", "--show", "landmarks,targets"),
    "both": ("--workspace", "compare"),
    "inspect": (*_INSPECT, "--show", "landmarks,targets,centre,lattice,domains,legend"),
    "maps": (*_INSPECT, "--show", "heat,landmarks", "--percent", "7"),
    "compare": (*_INSPECT, "--show", "wipe,loupe", "--percent", "8"),
    "protect": (
        *("--show", "protection,line,landmarks", "--theme", "light"),
        *("--protect", "262,230 262,660", "--percent", "5"),
    ),
}
FIGURES: Final = ("centers", "domains", "landmarks", "lattice")
ORANGE: Final = (230, 159, 0)  # Okabe and Ito's
# Of the sheet of faces: the left and upper edge of three of its pictures, and their side.
SHEET: Final = "sheet02.jpg"
TILES: Final = ((930, 52), (930, 1024), (2759, 1024))
TILE_PX: Final = 890
# Of another: two larger ones.
LARGE_SHEET: Final = "sheet01.jpg"
LARGE_TILES: Final = ((12, 86), (1852, 86))
LARGE_TILE_PX: Final = 1796
WIDE_PX: Final = 276
GALLERY_PX: Final = 300
EDGE_PX: Final = 900  # the sample's own
EDGE_ROWS: Final = 316  # below, the generated pictures end
AMOUNTS: Final = (0.0, 4.0, 8.0)
FOLLOWS: Final = (0.0, 50.0, 100.0)
STEPS: Final = 8
HELD_MS: Final = 1100
STEP_MS: Final = 70
LARGEST_BYTES: Final = 600_000


def faces(sheets: Path) -> bytes:
    """Return three generated faces as an animated WebP, while the amount goes up and down again."""
    tiles = _tiles(sheets / SHEET, TILES, TILE_PX)
    frames = [_frame(tiles, PERCENT * step / STEPS) for step in range(STEPS + 1)]
    there_and_back = [*frames, *frames[-2:0:-1]]
    held = [HELD_MS if step in (0, STEPS) else STEP_MS for step in range(len(there_and_back))]
    file = io.BytesIO()
    first, *rest = there_and_back
    first.save(
        file, "WEBP", save_all=True, append_images=rest, duration=held, loop=0, quality=80, method=6
    )
    if file.tell() > LARGEST_BYTES:
        raise SystemExit(f"faces.webp would take {file.tell()} bytes")
    return file.getvalue()


def _frame(tiles: list[Image], percent: float) -> PIL.Image.Image:
    """Return the pictures side by side at an amount, and the slider that says so below."""
    row = [PIL.Image.fromarray(_warped(tile, percent)) for tile in tiles]
    small = [one.resize((WIDE_PX, WIDE_PX), PIL.Image.Resampling.LANCZOS) for one in row]
    frame = PIL.Image.new("RGB", (len(row) * (WIDE_PX + 6) - 6, WIDE_PX + 40), "white")
    for number, one in enumerate(small):
        frame.paste(one, (number * (WIDE_PX + 6), 0))
    draw = ImageDraw.Draw(frame)
    left, right, y = 24, frame.width - 90, WIDE_PX + 22
    knob = left + (right - left) * percent / PERCENT
    draw.line((left, y, right, y), "#999999", 4)
    draw.line((left, y, knob, y), "#0072b2", 4)
    draw.ellipse((knob - 9, y - 9, knob + 9, y + 9), "#0072b2")
    font = ImageFont.load_default(20)
    draw.text((frame.width - 8, y), f"{percent:.1f} %", "#333333", font, anchor="rm")
    return frame


def _tiles(sheet: Path, corners: tuple[tuple[int, int], ...], side_px: int) -> list[Image]:
    pixels = read(sheet).pixels
    return [pixels[y : y + side_px, x : x + side_px] for x, y in corners]


def gallery(sheets: Path) -> dict[str, bytes]:
    """Return the sample and five generated faces: by amount, as the head follows, at the edge."""
    faces = [
        read(assets.sample()).pixels[60:760, 100:800],
        *_tiles(sheets / SHEET, TILES, TILE_PX),
        *_tiles(sheets / LARGE_SHEET, LARGE_TILES, LARGE_TILE_PX),
    ]
    made = {}
    for number, face in enumerate(faces, 1):
        amounts = [_warped(face, percent) for percent in AMOUNTS]
        follows = [_warped(face, AMOUNTS[-1], "--head-follows", f"{far:g}") for far in FOLLOWS]
        made[f"gallery-{number}-amount.jpg"] = _side_by_side(amounts)
        made[f"gallery-{number}-follows.jpg"] = _side_by_side(follows)
        if number > 1:  # the sample is in `lens`
            made[f"gallery-{number}-lens.jpg"] = _jpeg(_at_the_edge(face)[:EDGE_ROWS])
    return made


def _side_by_side(pictures: list[Image]) -> bytes:
    side = (GALLERY_PX, GALLERY_PX)
    small = [cv2.resize(one[..., :3], side, interpolation=cv2.INTER_AREA) for one in pictures]
    gap = np.full((GALLERY_PX, GAP_PX // 2, 3), 255, np.uint8)
    return _jpeg(np.hstack([small[0], gap, small[1], gap, small[2]]))


def _warped(tile: Image, percent: float, *options: str) -> Image:
    """Return what ``kogao-cli warp`` makes of a picture by itself."""
    with tempfile.TemporaryDirectory() as folder:
        before, after = Path(folder, "before.png"), Path(folder, "after.png")
        cv2.imwrite(str(before), cv2.cvtColor(tile, cv2.COLOR_RGB2BGR))
        _kogao_cli("warp", before, "-o", after, "--percent", f"{percent:g}", *options)
        return read(after).pixels


def drawn() -> dict[str, bytes]:
    """Return the paper's figures of the sample, by ``kogao-cli experiment figures``."""
    with tempfile.TemporaryDirectory() as folder:
        _kogao_cli("experiment", "figures", "--sample", "-o", folder, "--width", "720")
        made = {file.stem.partition("-")[2]: read(file).pixels for file in Path(folder).iterdir()}
    return {f"figure-{name}.jpg": _jpeg(made[name]) for name in FIGURES}


def blocks() -> Image:
    """Return the sample's JPEG as it is saved, with the blocks that were written anew in orange."""
    with tempfile.TemporaryDirectory() as folder:
        saved = Path(folder, "saved.jpg")
        _kogao_cli("warp", "--sample", "-o", saved)
        before, after = (jpeglib.read_dct(str(one)).Y for one in (assets.sample(), saved))
        shown = read(saved).pixels.copy()
    changed = np.kron((before != after).any(axis=(2, 3)), np.ones((8, 8), bool))
    changed = changed[: shown.shape[0], : shown.shape[1]]
    shown[changed] = (0.55 * shown[changed] + 0.45 * np.array(ORANGE)).astype(np.uint8)
    return shown


def templates() -> Image:
    """Return our 27 landmarks of the sample beside the 189 that other programs are given."""
    photo = read(assets.sample()).pixels
    (face,) = MeshSource().find(photo)
    ours = np.vstack([face.outline, face.eyes, face.mouth])
    with tempfile.TemporaryDirectory() as folder:
        _kogao_cli("landmarks", "export", "--sample", "--format", "tem", "-o", folder)
        (file,) = Path(folder).iterdir()
        count, *rows = file.read_text(encoding="utf-8").splitlines()
    theirs = np.array([row.split()[:2] for row in rows[: int(count)]], float)
    return np.hstack([_marked(photo, ours, 5), _marked(photo, theirs, 3)])[150:800]


def _marked(photo: Image, points: Image, radius: int) -> Image:
    marked = photo.copy()
    for x, y in points:
        cv2.circle(marked, (round(x), round(y)), radius, ORANGE, -1, cv2.LINE_AA)
    return marked[:, 150:750]


def doses() -> Image:
    """Return one face of a study as its raters see it, at five doses."""
    photo = read(assets.sample()).pixels
    faces = MeshSource().find(photo)
    made = [render(photo, faces, Recipe(percent=percent)).pixels for percent in (0, 3, 6, 9, 12)]
    return cv2.resize(
        np.hstack([one[230:730, 230:670] for one in made]), None, fx=0.4, fy=0.4,
        interpolation=cv2.INTER_AREA,
    )  # fmt: skip


def lens() -> Image:
    """Return the sample at the edge of 26 mm: as the lens draws it, corrected, and on the axis."""
    return _at_the_edge(read(assets.sample()).pixels)


def _at_the_edge(photo: Image) -> Image:
    small = cv2.resize(photo[..., :3], (EDGE_PX, EDGE_PX), interpolation=cv2.INTER_AREA)
    subject = Subject("", small, tuple(MeshSource().find(small)))
    return np.hstack(shown_at_the_edge(subject, Recipe()))


def edit_window(path: Path) -> None:
    """Take a picture of the window as another program sees it that has asked for a photo."""
    from kogao_app.editor import Editor
    from kogao_app.start import Screenshot
    from kogao_app.storage import Storage
    from PySide6.QtWidgets import QApplication

    with tempfile.TemporaryDirectory() as folder:
        photo = Path(folder, "portrait.jpg")
        photo.write_bytes(assets.sample().read_bytes())
        app = QApplication([])
        editor = Editor(app, MeshSource(), Storage.in_folder(Path(folder, "own")), "dark", None)
        editor.window.resize(1280, 800)
        shot = Screenshot(editor, path)
        editor.window.show()
        editor.errand.begin([photo])
        app.exec()
        if shot.finish():
            raise SystemExit(f"{path} wasn't made")


def _kogao_cli(*words: object) -> None:
    program = "from kogao_core.cli import main; main()"
    command = [sys.executable, "-c", program, *map(str, words)]
    subprocess.run(command, check=True, capture_output=True)


def _jpeg(picture: Image) -> bytes:
    bgr = cv2.cvtColor(picture[..., :3], cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()


def before_after() -> Image:
    """Return the sample and its warp side by side, cut to head and shoulders, RGB."""
    photo = read(assets.sample()).pixels
    faces = MeshSource().find(photo)
    after = render(photo, faces, Recipe(percent=PERCENT)).pixels
    x, y, width, height = faces[0].box
    rows = slice(max(0, int(y - 0.9 * height)), int(y + 1.6 * height))
    columns = slice(max(0, int(x - 0.6 * width)), int(x + 1.6 * width))
    gap = np.full((rows.stop - rows.start, GAP_PX, 3), 255, np.uint8)
    return np.hstack([photo[rows, columns], gap, after[rows, columns]])


def main(arguments: list[str]) -> None:
    """Write all pictures into the folder named first."""
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    if arguments[1:]:
        sheets = Path(arguments[1])
        for name, picture in {"faces.webp": faces(sheets), **gallery(sheets)}.items():
            put(picture, folder / name)
    for make in (before_after, blocks, templates, doses, lens):
        put(_jpeg(make()), folder / f"{make.__name__.replace('_', '-')}.jpg")
    for name, figure in drawn().items():
        put(figure, folder / name)
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    edit_window(folder / "edit.png")
    for name, options in WINDOWS.items():
        window = ["--sample", "--screenshot", str(folder / f"{name}.png"), *options]
        subprocess.run([sys.executable, "-m", "kogao_app", *window], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
