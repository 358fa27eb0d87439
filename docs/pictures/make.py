"""Make the pictures of the documentation and of the landing page.

``python docs/pictures/make.py docs/pictures [SHEETS]``

Without the folder of SFHQ's sheets, only the pictures of the built-in sample are made. The
window in Japanese needs a font with Japanese letters (Debian: fonts-noto-cjk).
"""

from __future__ import annotations

import base64
import io
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final, NamedTuple

import cv2
import jpeglib
import numpy as np
import PIL.Image
from PIL import ImageDraw, ImageFont

from kogao_core.base import assets
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Image
from kogao_core.faces.landmarks import MeshSource
from kogao_core.photo import read
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe


class Generated(NamedTuple):
    """A generated face: a square of one of SFHQ's sheets. All are adults."""

    sheet: str
    left_px: int
    top_px: int
    side_px: int
    name: str  # alternative text

    def pixels(self, sheets: Path) -> Image:
        """Return the square, RGB."""
        x, y, side = self.left_px, self.top_px, self.side_px
        return read(sheets / self.sheet).pixels[y : y + side, x : x + side]


FACES: Final = (
    Generated("sheet01.jpg", 1854, 86, 1794, "A man of about 30 with a short beard, smiling"),
    Generated("sheet02.jpg", 930, 52, 890, "A woman of about 35 with long red hair"),
    Generated("sheet05.jpg", 1848, 64, 570, "A man of about 45 with a shaved head"),
    Generated("sheet02.jpg", 15, 1024, 890, "A woman of about 50 with long grey hair"),
    Generated("sheet03.jpg", 1842, 42, 590, "A man of about 70 with spectacles"),
    Generated("sheet01.jpg", 15, 86, 1794, "A man of about 60 with long grey hair"),
)
SAMPLES: Final = ("women", "men")  # averages that travel with the program
SHOWN_PERCENT: Final = 8.0  # of the pictures that readers see first
GAP_PX: Final = 12
FRONT_PX: Final = 300
LANDING_PX: Final = 384
GALLERY_PX: Final = (420, 420)
GROUP: Final = (1, 3, 5)  # faces side by side in one picture, counted from 1
GROUP_PX: Final = 300
GALLERY_MS: Final = 1300
TRIED_PX: Final = 420  # the faces that visitors of the landing page warp
TRIED_PERCENTS: Final = (2, 4, 6, 8, 10)
NODE_PX: Final = 8
SOFT_PX: Final = 0.8
UNITS_PER_PX: Final = 1024
_INSPECT: Final = ("--workspace", "inspect")
WINDOWS: Final = {
    "window": (),
    "japanese": ("--language", "ja", "--show", "landmarks,targets"),
    "both": ("--workspace", "compare"),
    "inspect": (*_INSPECT, "--show", "landmarks,targets,centre,lattice,domains,legend"),
    "maps": (*_INSPECT, "--show", "heat,landmarks", "--amount", "7"),
    "compare": (*_INSPECT, "--show", "wipe,loupe", "--amount", "8"),
    "protect": (
        *("--show", "protection,line,landmarks", "--theme", "light"),
        *("--protect", "262,230 262,660", "--amount", "5"),
    ),
}
ORANGE: Final = (230, 159, 0)  # Okabe and Ito's
# The wide photo in which a face stands at the edge: size in px, focal length, place of the face.
EDGE_PX: Final = (1800, 1200)
EDGE_FOCAL_MM: Final = 26.0
EDGE_AT: Final = (0.8, -0.15)  # of the half width and half height
EDGE_FACE_PX: Final = 180  # width of the face
EDGE_SHOWN: Final = (165, 190, 110)  # px shown beside, above and below the middle of the face


def front(sheets: Path) -> dict[str, Image]:
    """Return the README's pairs and the two pictures of the landing page's wipe."""
    pairs = [(face.pixels(sheets), _warped(face.pixels(sheets), SHOWN_PERCENT)) for face in FACES]
    shown = []
    for before, after in pairs[1:3]:
        shown += [_labelled(_square(before, FRONT_PX), "Before")]
        shown += [_labelled(_square(after, FRONT_PX), "After")]
    wipe = [np.hstack([_square(pair[k], LANDING_PX) for pair in pairs[:3]]) for k in (0, 1)]
    return {
        "before-after": _row(shown),
        "landing-before": wipe[0],
        "landing-after": wipe[1],
    }


def gallery(sheets: Path) -> dict[str, bytes]:
    """Return each face before and after by the default recipe, and faces at a photo's edge."""
    pictures = [face.pixels(sheets) for face in FACES]
    pictures += [
        read(assets.sample().with_name(f"{name}.jpg")).pixels[60:760, 100:800] for name in SAMPLES
    ]
    made = {}
    for number, picture in enumerate(pictures, 1):
        made[f"gallery-{number}.webp"] = _flip(picture, _warped(picture))
    group = np.hstack([_square(pictures[n - 1], GROUP_PX) for n in GROUP])
    made["gallery-group.webp"] = _flip(group, _warped(group), (len(GROUP) * GROUP_PX, GROUP_PX))
    for number in (2, 3, 5):
        made[f"lens-{number}.jpg"] = _jpeg(_at_the_edge(pictures[number - 1]))
    return made


def _flip(before: Image, after: Image, size: tuple[int, int] = GALLERY_PX) -> bytes:
    """Return two pictures that alternate, as an animated WebP."""
    words = ("Before", "After")
    frames = [
        PIL.Image.fromarray(
            _labelled(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), word)
        )
        for picture, word in zip((before, after), words, strict=True)
    ]
    file = io.BytesIO()
    frames[0].save(
        file, "WEBP", save_all=True, append_images=frames[1:], duration=GALLERY_MS, loop=0,
        quality=82, method=6,
    )  # fmt: skip
    return file.getvalue()


def tried(sheets: Path) -> str:
    """Return faces.js: faces that visitors warp in the page, with control points per Amount."""
    faces = []
    for face in FACES[1:5]:
        # Slightly soft: the page may round a position to the next 1/32 px.
        picture = cv2.GaussianBlur(_square(face.pixels(sheets), TRIED_PX), (0, 0), SOFT_PX)
        jpeg = _jpeg(picture)
        decoded = np.asarray(PIL.Image.open(io.BytesIO(jpeg)).convert("RGB"))
        found = MeshSource().find(decoded)
        fields = [
            _control_points(render(decoded, found, Recipe(percent=percent)).field.on_grid)
            for percent in TRIED_PERCENTS
        ]
        rows, columns = fields[0].shape[1:]
        faces.append(
            {
                "name": face.name,
                "picture": "data:image/jpeg;base64," + _base64(jpeg),
                "width": TRIED_PX, "height": TRIED_PX,
                "columns": columns, "rows": rows, "spacing": NODE_PX, "unit": UNITS_PER_PX,
                "amounts": TRIED_PERCENTS,
                "fields": [_base64(phi.astype("<i2").tobytes()) for phi in fields],
            }
        )  # fmt: skip
    return f"window.KOGAO_FACES = {json.dumps(faces, indent=0)};\n"


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _control_points(on_grid: object) -> Array:
    """Return the cubic B-spline that meets a displacement on nodes, (2, rows, columns), rounded."""
    assert callable(on_grid)
    nodes = TRIED_PX // NODE_PX + 4
    at = NODE_PX * (np.arange(nodes) - 1.0)
    meets = (np.eye(nodes) * 4 + np.eye(nodes, k=1) + np.eye(nodes, k=-1)) / 6
    values = np.asarray(on_grid(at, at))
    phi = np.linalg.solve(meets, values)  # down
    phi = np.linalg.solve(meets, phi.swapaxes(1, 2)).swapaxes(1, 2)  # across
    return np.asarray(np.rint(phi * UNITS_PER_PX))


def _at_the_edge(photo: Image) -> Image:
    """Return a face at the edge of a wide photo, corrected, and in the middle, side by side.

    A camera that turns maps the picture by a homography: so the face at the edge is exact, and the
    face in the middle is the truth.
    """
    small = _square(photo, 600)
    face = max(MeshSource().find(small), key=lambda one: one.interocular_px)
    size = np.array(EDGE_PX, float)
    focal = EDGE_FOCAL_MM / np.hypot(36.0, 24.0) * np.hypot(*size)
    to = np.append(np.array(EDGE_AT) * size / 2, focal)
    to /= np.linalg.norm(to)
    axis = np.cross([0.0, 0.0, 1.0], to)
    turn, _ = cv2.Rodrigues(axis / np.linalg.norm(axis) * np.arccos(to[2]))
    scale = EDGE_FACE_PX / float(np.ptp(face.outline[:, 0]))
    middle = np.mean(face.outline, axis=0)
    on_axis = np.diag([scale, scale, 1.0])
    on_axis[:2, 2] = -scale * middle
    lens = np.diag([focal, focal, 1.0])
    centred = np.array([[1, 0, size[0] / 2], [0, 1, size[1] / 2], [0, 0, 1.0]])
    onto = centred @ lens @ turn @ np.linalg.inv(lens) @ on_axis
    wide = cv2.warpPerspective(
        small, onto, EDGE_PX, flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE
    )
    x, y = (centred @ lens @ to)[:2] / to[2]
    beside, above, below = EDGE_SHOWN
    box = slice(round(y - above), round(y + below)), slice(round(x - beside), round(x + beside))
    corrected = _warped(wide, 0.0, "--lens", f"{EDGE_FOCAL_MM:g}")
    # The same size: away from the middle, a lens draws the head larger by 1 / cos of the angle.
    as_large = on_axis[:2] / to[2] + np.array([[0, 0, beside], [0, 0, above]])
    middle_view = cv2.warpAffine(
        small, as_large, (2 * beside, above + below), flags=cv2.INTER_AREA,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    return _row([wide[box], corrected[box], np.asarray(middle_view)])


def _square(picture: Image, side_px: int) -> Image:
    size = (side_px, side_px)
    return np.asarray(cv2.resize(picture[..., :3], size, interpolation=cv2.INTER_AREA))


def _row(pictures: list[Image]) -> Image:
    gap = np.full((len(pictures[0]), GAP_PX // 2, 3), 255, np.uint8)
    parts = [part for picture in pictures for part in (gap, picture)]
    return np.hstack(parts[1:])


def _labelled(picture: Image, word: str) -> Image:
    image = PIL.Image.fromarray(np.ascontiguousarray(picture))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(18)
    width = draw.textlength(word, font)
    box = (8, image.height - 36, 24 + width, image.height - 8)
    draw.rounded_rectangle(box, 14, "#000000")
    draw.text((16, image.height - 22), word, "#ffffff", font, anchor="lm")
    return np.asarray(image)


def _warped(picture: Image, percent: float | None = None, *options: str) -> Image:
    """Return a picture as ``kogao-cli warp`` makes it, by the default Amount if None."""
    amount = () if percent is None else ("--amount", f"{percent:g}")
    with tempfile.TemporaryDirectory() as folder:
        before, after = Path(folder, "before.png"), Path(folder, "after.png")
        cv2.imwrite(str(before), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        _kogao_cli("warp", before, "-o", after, *amount, *options)
        return read(after).pixels


def blocks() -> Image:
    """Return the sample's JPEG as it is saved; blocks that were encoded again are orange."""
    with tempfile.TemporaryDirectory() as folder:
        saved = Path(folder, "saved.jpg")
        _kogao_cli("warp", "--sample", "-o", saved)
        before, after = (jpeglib.read_dct(str(one)).Y for one in (assets.sample(), saved))
        shown = read(saved).pixels.copy()
    changed = np.kron((before != after).any(axis=(2, 3)), np.ones((8, 8), bool))
    changed = changed[: shown.shape[0], : shown.shape[1]]
    shown[changed] = (0.55 * shown[changed] + 0.45 * np.array(ORANGE)).astype(np.uint8)
    return shown


def doses() -> Image:
    """Return one face of a study as its raters see it, at five Amounts."""
    photo = read(assets.sample()).pixels
    faces = MeshSource().find(photo)
    made = [render(photo, faces, Recipe(percent=percent)).pixels for percent in (0, 3, 6, 9, 12)]
    return cv2.resize(
        np.hstack([one[230:730, 230:670] for one in made]), None, fx=0.4, fy=0.4,
        interpolation=cv2.INTER_AREA,
    )  # fmt: skip


def lens() -> Image:
    """Return the sample at the edge of a 26 mm photo, corrected, and in the middle."""
    return _at_the_edge(read(assets.sample()).pixels)


def edit_window(path: Path) -> None:
    """Take a picture of the window that another program has opened to edit a photo."""
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


def windows(folder: Path, sheets: Path | None) -> None:
    """Take pictures of the window: generated faces where there are any, else the sample."""
    for number, (name, options) in enumerate(WINDOWS.items()):
        picture = ["--screenshot", str(folder / f"{name}.png"), *options]
        with tempfile.TemporaryDirectory() as temporary:
            photo = Path(temporary, "portrait.jpg")
            if sheets is None or name == "protect":  # whose stroke is placed on the sample
                photo.write_bytes(assets.sample().read_bytes())
            else:
                face = FACES[number % len(FACES)].pixels(sheets)
                photo.write_bytes(_jpeg(_square(face, 1100)))
            subprocess.run([sys.executable, "-m", "kogao_app", str(photo), *picture], check=True)


def _kogao_cli(*words: object) -> None:
    program = "from kogao_core.cli import main; main()"
    command = [sys.executable, "-c", program, *map(str, words)]
    subprocess.run(command, check=True, capture_output=True)


def _jpeg(picture: Image) -> bytes:
    bgr = cv2.cvtColor(picture[..., :3], cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()


def main(arguments: list[str]) -> None:
    """Write all pictures into the folder named first."""
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    sheets = Path(arguments[1]) if arguments[1:] else None
    if sheets is not None:
        for name, picture in front(sheets).items():
            atomic_write(_jpeg(picture), folder / f"{name}.jpg")
        for name, file in gallery(sheets).items():
            atomic_write(file, folder / name)
        atomic_write(tried(sheets).encode(), folder.parent / "site/landing/faces.js")
    for make in (blocks, doses, lens):
        atomic_write(_jpeg(make()), folder / f"{make.__name__}.jpg")
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    edit_window(folder / "edit.png")
    windows(folder, sheets)


if __name__ == "__main__":
    main(sys.argv[1:])
