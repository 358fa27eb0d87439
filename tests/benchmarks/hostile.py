"""Damage files at random: ``python tests/benchmarks/hostile.py [--inputs N] [--seed S]``.

Photos, recipes, points, projects, fonts, studies, setting times, reports of batches, the store of
originals, the list of results, and the options themselves go through ``kogao-cli``. The program
must succeed, or refuse with one sentence and a documented exit code, within seconds and bounded
memory. It must leave nothing behind, and no library may print anything. Not on Windows.
``--only heic,recipe`` takes some kinds; folders of inputs that went wrong stay in ``--keep``.
"""

from __future__ import annotations

import argparse
import functools
import io
import json
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

# Cases are forks of this process, which must have one thread.
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cv2
import files
import metadata_cases
import numpy as np
import ratings
import tifffile
from damaging import bytewise, parts, texts
from damaging.trials import Trial, run
from PIL import Image, ImageFont
from scenes import oval_face, textured_photo

from kogao_core.base.index import NAME
from kogao_core.batch.tasks import Outcome
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.field.protection import NOTHING
from kogao_core.lab.experiments.trials import now
from kogao_core.lab.study import plan
from kogao_core.lab.study.design import variants
from kogao_core.photo.originals import Originals
from kogao_core.projects.interchange import faces_text
from kogao_core.projects.json import face_dict
from kogao_core.projects.project import Original, Project, Sheet, to_dict
from kogao_core.projects.results import Results
from kogao_core.recipe.recipe import PAPER, Recipe

STRUCTURED = 0.6  # share of changes to photos that keep the file's parts in order
SEARCHED = 0.05  # share of photos in which faces are looked for, which is slow
PHOTOS = 0.55  # share of photos among all inputs
WIDTH, HEIGHT = 120, 160
IN_BATCH = 6
LONGEST_ARGUMENT = 100
SUFFIXES = (".jpg", ".png", ".tif", ".webp", ".avif")
MORE = (
    ["--motion", "keep"],
    ["--disclose"],
    ["--label", "Retouched"],
    ["--amount", "0"],
    ["--save-project"],
)
STORE = "../data/kogao"
STORE_COMMANDS = (
    (["restore", "photo.png"], ()),
    (["restore", "photo.png", "--force"], ()),
    (["originals"], ()),
    (["forget", "photo.png"], ()),
    (["warp", "--in-place", "photo.png", "--points", "p.json", "--json"], ("photo.png",)),
    (["warp", "photo.png", "-o", "out.png", "--points", "p.json", "--json"], ("out.png",)),
)
OPTIONS = (
    ("--amount", "4"), ("--center", "2"), ("--lattice", "1"), ("--threshold", "0.5"),
    ("--face", "1"), ("--protect", "10,20 60,70"), ("--protect-width", "3"),
    ("--label", "Retouched"),
    ("--max-megapixels", "50"), ("--lattice-unit", "warp"), ("--recipe", "recipe.json"),
)  # fmt: skip
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
POINTS = {"p.json": faces_text([FACE]).encode()}
BY_POINTS = ["--points", "p.json"]
Rng = np.random.Generator


def damaged(data: bytes, rng: Rng, change: Callable[[bytes, Rng], bytes] = texts.change) -> bytes:
    """Return a file with some changes."""
    for _ in range(rng.geometric(bytewise.ENOUGH)):
        data = change(data, rng)
    return data


# ---- photos ---------------------------------------------------------------------------------


@functools.cache
def seeds() -> dict[str, bytes]:
    """Return small sound files of every format, depth and kind that is read."""
    rng = np.random.default_rng(3)
    picture = cv2.GaussianBlur(rng.integers(0, 256, (40, 56, 3), np.uint8), (0, 0), 1.5)
    exif = Image.Exif()
    exif[0x112], exif[0x13B] = 6, "someone"
    found = {
        "jpeg": files.saved(picture, "JPEG", exif=exif, icc_profile=b"p" * 500, dpi=(72, 72)),
        "progressive": files.saved(picture, "JPEG", progressive=True, subsampling="4:2:2"),
        "grey": files.saved(picture[..., 0], "JPEG"),
        "rgb": files.saved(picture, "JPEG", keep_rgb=True),
        "png": files.saved(picture, "PNG", exif=exif, icc_profile=b"p" * 500),
        "palette": files.saved(np.array(Image.fromarray(picture).quantize(16)), "PNG"),
        "webp": files.saved(picture, "WEBP", exif=exif),
        "lossless webp": files.saved(picture, "WEBP", lossless=True),
        "tiff": files.saved(picture, "TIFF", compression="tiff_lzw", exif=exif),
        "plain tiff": files.saved(picture, "TIFF"),
    }
    deep = picture.astype(np.uint16) * 257
    for name, pixels in (("16-bit", deep), ("float", picture.astype(np.float32) / 255.0)):
        found[f"{name} tiff"] = cv2.imencode(".tiff", pixels)[1].tobytes()
    found["16-bit png"] = cv2.imencode(".png", deep)[1].tobytes()
    for suffix, make in files.MAKERS.items():
        found[f"{suffix[1:]} with all metadata"] = make(picture, 6)
    rare = {"photometric": "rgb", "tile": (16, 16), "compression": "zlib"}
    with io.BytesIO() as out:
        tifffile.imwrite(out, deep, **rare)
        found["tiled tiff"] = out.getvalue()
    narrow = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_411]
    found["4:1:1"] = cv2.imencode(".jpg", picture, narrow)[1].tobytes()
    found["hdr"], found["motion"] = metadata_cases.ultra_hdr(), metadata_cases.motion_photo()
    found["kept"] = metadata_cases.kept()
    found["kept webp"] = metadata_cases.webp((b"wxyz", b"?"), (b"abcd", b"odd"))
    found["kept tiff"] = metadata_cases.tiff({42112: (2, b"text\0"), 40000: (12, (0.5, -1.5))})
    found["heic"], found["dng"] = files.heic(picture), files.dng()
    found["grey dng"] = files.dng(colours=1)
    return found


def photo_case(kind: str, rng: Rng) -> Trial:
    """Return the warp of a damaged photo, or the search for faces in it."""
    sound = seeds()

    def change(data: bytes, rng: Rng) -> bytes:
        way = parts if rng.random() < STRUCTURED else bytewise
        return way.change(data, rng, sound[list(sound)[rng.integers(len(sound))]])

    photo = "photo.dng" if kind.endswith("dng") else "photo"
    given = {photo: damaged(sound[kind], rng, change)}
    limits = ["--max-megapixels", "50", "--json"]
    if rng.random() < SEARCHED:
        return Trial(kind, ["detect", photo, *limits], given, codes=(0, 2, 3, 4))
    out = f"out{SUFFIXES[rng.integers(len(SUFFIXES))]}"
    more = MORE[rng.integers(len(MORE))] if rng.random() < 0.3 else []
    outputs = (out, f"{photo}.kogao.json") if "--save-project" in more else (out,)
    given["p.json"] = faces_text([oval_face(40, 40, size=0.5)]).encode()
    return Trial(kind, ["warp", photo, "-o", out, *BY_POINTS, *limits, *more], given, outputs)


# ---- other files ----------------------------------------------------------------------------


@functools.cache
def photo() -> bytes:
    """Return a small PNG file."""
    return cv2.imencode(".png", textured_photo(WIDTH, HEIGHT))[1].tobytes()


def _warp(kind: str, more: list[str], given: dict[str, bytes]) -> Trial:
    command = ["warp", "photo.png", "-o", "out.png", "--json", *more]
    return Trial(kind, command, {"photo.png": photo(), **POINTS, **given}, ("out.png",))


def recipe_case(rng: Rng) -> Trial:
    """Return a warp by a damaged recipe."""
    recipe = damaged(json.dumps(Recipe(percent=5.0).to_dict()).encode(), rng)
    return _warp("recipe", [*BY_POINTS, "--recipe", "r.json"], {"r.json": recipe})


def points_case(rng: Rng) -> Trial:
    """Return a warp by damaged points."""
    if rng.random() < 0.5:
        return _warp("points json", BY_POINTS, {"p.json": damaged(POINTS["p.json"], rng)})
    rows = "".join(f"{x:.3f},{y:.3f}\n" for x, y in FACE.points)
    return _warp(
        "points csv", ["--points", "p.csv"], {"p.csv": damaged(f"x,y\n{rows}".encode(), rng)}
    )


def project() -> bytes:
    """Return a project with everything that projects hold."""
    about = Original("photo.png", "0" * 64, WIDTH, HEIGHT)
    aimed = FACE.with_target(3, (40.0, 90.0))
    protection = NOTHING.with_stroke([(10.0, 20.0), (60.0, 70.0)], 3.0)
    sheet = Sheet((aimed,), frozenset(), Recipe(percent=6.0))
    whole = Project(about, "manual", sheet, Sheet((aimed,)), protection)
    return json.dumps(to_dict(whole)).encode()


def project_case(rng: Rng) -> Trial:
    """Return a warp by a damaged project."""
    return _warp(
        "project", ["--project", "project.json"], {"project.json": damaged(project(), rng)}
    )


def options_case(rng: Rng) -> Trial:
    """Return a warp by damaged options."""
    given = {"--points": "p.json", "--protect": "10,20 60,70"}
    for _ in range(rng.integers(1, 4)):
        option, value = OPTIONS[rng.integers(len(OPTIONS))]
        changed = damaged(value.encode(), rng).decode("utf-8", "replace").replace("\0", "")
        given[option] = changed[:LONGEST_ARGUMENT]
    arguments = [word for option, value in given.items() for word in (option, value)]
    return _warp("options", arguments, {"recipe.json": json.dumps(Recipe().to_dict()).encode()})


def font_case(rng: Rng) -> Trial:
    """Return a warp with a label in a damaged font."""
    font = ImageFont.load_default(12).font_bytes
    data = damaged(font, rng, lambda data, rng: bytewise.change(data, rng, data))
    label = ["--label", "Retouched", "--label-font", "f.ttf"]
    return _warp("font", [*BY_POINTS, *label], {"f.ttf": data})


@functools.cache
def study() -> dict[str, bytes]:
    """Return a study of one photo: both halves, and a rater's answers."""
    kinds = variants(PAPER, (0.5, 1.0), control=True, satisfaction=True)
    names = {plan.picture_name("s", "0" * 64, 0, kind): kind for kind in kinds}
    graded = tuple(sorted(n for n, kind in names.items() if kind.kind == "satisfaction"))
    shown = plan.Study("a-study", tuple(sorted(set(names) - set(graded))), graded)
    measured = plan.PictureFigures(4.0, 1.5)
    meanings = {name: plan.Meaning(0, kind, measured) for name, kind in names.items()}
    photographed = plan.PhotoRecord("a.jpg", "0" * 64, ((1.0, 2.0), (3.0, 4.0)))
    made = plan.Origin("1.0", "2026-11-01T12:00:00+00:00", "mesh")
    key = plan.Key("a-study", "s", PAPER, (photographed,), meanings, made)
    with tempfile.TemporaryDirectory() as folder:
        session = ratings.begun(shown)
        while session.current is not None:
            session.take(ratings.judged(session))
        ratings.save(session, Path(folder, "r1.jsonl"))
        answers = Path(folder, "r1.jsonl").read_bytes()
    return {
        "study/study.json": json.dumps(shown.to_dict()).encode(),
        "study.key.json": json.dumps(key.to_dict()).encode(),
        "study/ratings/r1.jsonl": answers,
    }


def study_case(rng: Rng) -> Trial:
    """Return the report of a study of which one file is damaged."""
    given = dict(study())
    name = list(given)[rng.integers(len(given))]
    given[name] = damaged(given[name], rng)
    command = ["experiment", "study", "report", "study", "--csv", "r.csv", "--html", "r.html"]
    kind = f"study {Path(name).suffixes[0]}"
    return Trial(kind, command, given, ("r.csv", "r.html"), codes=(0, 2, 3, 5))


def sessions_case(rng: Rng) -> Trial:
    """Return an experiment that reads damaged trials, and has no photo to work on."""
    numbers = {"width": 960, "height": 720, "looking_s": 6.1, "setting_s": 22.8}
    told = {"trial": "t", "mode": "manual", "photo": "a.jpg", "at": now()}
    faces = [face_dict(template_face((480, 360), 300), 960)]
    line = {"version": 2, **numbers, **told, "cold": False, "corrections_s": [2.2], "faces": faces}
    text = f"{json.dumps(line)}\n" * 3
    command = ["experiment", "timing", "no.jpg", "--trials", "t.jsonl"]
    return Trial("trials of setting", command, {"t.jsonl": damaged(text.encode(), rng)})


def batch_case(rng: Rng) -> Trial:
    """Return a batch with damaged projects, and a damaged report of an earlier run."""
    names = [f"{number}.png" for number in range(IN_BATCH)]
    done = [Outcome(f"in/{name}", f"out/{name}", "done", key="0" * 64) for name in names]
    report = "".join(f"{one.to_json()}\n" for one in done).encode()
    given = {f"in/{name}": photo() for name in names}
    given |= {f"in/{name}.kogao.json": damaged(project(), rng) for name in names}
    given["out/kogao-batch.jsonl"] = damaged(report, rng)
    lines = ("kogao-cli: ", "in/", f"{IN_BATCH} of {IN_BATCH}: ")
    command = ["batch", "in", "-o", "out", "--projects", "--jobs", "1"]
    return Trial("batch", command, given, ("out/*",), codes=(0, 2, 3, 5), lines=lines)


@functools.cache
def store() -> dict[str, bytes]:
    """Return a result that was written in place, its original's store, and the list of results."""
    with tempfile.TemporaryDirectory() as folder:
        inverted = 255 - textured_photo(WIDTH, HEIGHT)
        path, result = Path(folder, "photo.png"), cv2.imencode(".png", inverted)[1].tobytes()
        path.write_bytes(photo())
        Originals(Path(folder, "originals")).keep(path, [result])
        path.write_bytes(result)
        Path(folder, "copy.png").write_bytes(photo())
        for _ in range(3):
            Results(Path(folder)).add(path, Path(folder, "copy.png"))
        kept = [Path(folder, NAME), *Path(folder, "originals").iterdir()]
        given = {f"{STORE}/{one.relative_to(folder)}": one.read_bytes() for one in kept}
        return {"photo.png": result, **given}


def store_case(rng: Rng) -> Trial:
    """Return a command that uses the store of originals, of which one file is damaged."""
    given = dict(store())
    name = list(given)[rng.integers(1, len(given))]
    cut = given[name][: rng.integers(len(given[name]))]
    given[name] = damaged(given[name], rng) if rng.random() < 0.8 else cut
    command, outputs = STORE_COMMANDS[rng.integers(len(STORE_COMMANDS))]
    restored = {"photo.png": photo()} if command[0] == "restore" else {}
    return Trial(f"store {command[0]}", command, given | POINTS, outputs, restored,
                 own=(f"{STORE}/*",))  # fmt: skip


# Of each kind, its share among all inputs and a function that returns a case.
CASES: dict[str, tuple[float, Callable[[Rng], Trial]]] = {
    **{kind: (PHOTOS / len(seeds()), functools.partial(photo_case, kind)) for kind in seeds()},
    "recipe": (0.08, recipe_case),
    "points": (0.11, points_case),
    "project": (0.09, project_case),
    "options": (0.04, options_case),
    "study": (0.04, study_case),
    "sessions": (0.02, sessions_case),
    "font": (0.01, font_case),
    "batch": (0.01, batch_case),
    "store": (0.05, store_case),
}


def main() -> None:
    """Try the cases and print the counts; end with 1 if anything went wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=lambda text: text.split(","), default=list(CASES))
    parser.add_argument("--keep", type=Path, help="folder for what went wrong")
    options = parser.parse_args()
    shares = np.array([CASES[kind][0] for kind in options.only])

    def case(rng: Rng) -> Trial:
        kind = options.only[rng.choice(len(shares), p=shares / shares.sum())]
        return CASES[kind][1](rng)

    keep = options.keep or Path(tempfile.mkdtemp(prefix="hostile-"))
    counts = run(case, options.inputs, options.seed, keep)
    print(json.dumps(counts, indent=1, ensure_ascii=False))
    if not any(keep.iterdir()):
        keep.rmdir()
    sys.exit(bool(counts["wrong"]))


if __name__ == "__main__":
    main()
