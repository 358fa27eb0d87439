"""Damage everything but photos: ``python tests/benchmarks/hostile_texts.py [--inputs N]``.

Recipes, points, projects, fonts, studies, setting times, reports of batches, the store of
originals, the list of results and the options themselves, through ``kogao-cli``, as ``hostile.py``
does it with photos.
"""

from __future__ import annotations

import functools
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageFont

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import ratings
from damaging import bytewise, texts
from damaging.trials import Trial, finish, options, run
from scenes import oval_face, textured_photo

from kogao_core.base import assets
from kogao_core.batch.tasks import Outcome
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.lab.experiments import trials
from kogao_core.lab.study import plan, results
from kogao_core.lab.study.design import variants
from kogao_core.photo.originals import Originals
from kogao_core.projects import interchange
from kogao_core.projects.json import face_dict
from kogao_core.projects.project import Original, Project, Sheet, to_dict
from kogao_core.projects.results import NAME, Results
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.warp.protection import NOTHING

WIDTH, HEIGHT = 120, 160
IN_BATCH = 6
LONGEST_ARGUMENT = 100
Rng = np.random.Generator
WARP = ["warp", "photo.png", "-o", "out.png", "--json"]
STORE = "../data/kogao"
STORE_COMMANDS = (
    (["restore", "photo.png"], ()),
    (["restore", "photo.png", "--force"], ()),
    (["originals"], ()),
    (["forget", "photo.png"], ()),
    (["warp", "--in-place", "photo.png", "--points", "p.csv", "--json"], ("photo.png",)),
    (["warp", "photo.png", "-o", "out.png", "--points", "p.csv", "--json"], ("out.png",)),
)
OPTIONS = (
    ("--amount", "4"), ("--center", "2"), ("--lattice", "1"), ("--threshold", "0.5"),
    ("--face", "1"), ("--protect", "10,20 60,70"), ("--protect-width", "3"),
    ("--label", "Retouched"),
    ("--max-megapixels", "50"), ("--lattice-unit", "warp"), ("--recipe", "recipe.json"),
)  # fmt: skip


def damaged(data: bytes, rng: Rng) -> bytes:
    """Return a text with some changes."""
    for _ in range(rng.geometric(bytewise.ENOUGH)):
        data = texts.change(data, rng)
    return data


@functools.cache
def face() -> object:
    """Return the face on the photo."""
    return oval_face(WIDTH, HEIGHT, size=0.5)


@functools.cache
def photo() -> bytes:
    """Return a small PNG file."""
    return cv2.imencode(".png", textured_photo(WIDTH, HEIGHT))[1].tobytes()


@functools.cache
def portrait() -> bytes:
    """Return a photo in which a face is found, quickly."""
    with Image.open(assets.path("samples/average.jpg")) as sample:
        pixels = np.asarray(sample.resize((200, 200)))
    return cv2.imencode(".jpg", pixels[..., ::-1])[1].tobytes()


@functools.cache
def points(name: str) -> bytes:
    """Return the face as a file of points."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        interchange.write([face()], path)
        return path.read_bytes()


def project() -> bytes:
    """Return a project with everything that projects hold."""
    about = Original("photo.png", "0" * 64, WIDTH, HEIGHT)
    aimed = face().with_target(3, (40.0, 90.0))
    protection = NOTHING.with_stroke([(10.0, 20.0), (60.0, 70.0)], 3.0)
    sheet = Sheet((aimed,), frozenset(), Recipe(percent=6.0))
    whole = Project(about, "manual", sheet, Sheet((aimed,)), protection)
    return json.dumps(to_dict(whole)).encode()


@functools.cache
def study() -> dict[str, bytes]:
    """Return a study of one photo: both halves, and a rater's answers."""
    kinds = variants(PAPER, (0.5, 1.0), control=True, satisfaction=True)
    names = {plan.picture_name("s", "0" * 64, 0, kind): kind for kind in kinds}
    graded = tuple(sorted(n for n, kind in names.items() if kind.kind == "satisfaction"))
    rated = tuple(sorted(set(names) - set(graded)))
    shown = plan.Study("a-study", rated, graded)
    measured = plan.PictureFigures(4.0, 1.5)
    meanings = {name: plan.Meaning(0, kind, measured) for name, kind in names.items()}
    photographed = plan.PhotoRecord("a.jpg", "0" * 64, ((1.0, 2.0), (3.0, 4.0)))
    made = plan.Origin("1.0", "2026-11-01T12:00:00+00:00", "mesh")
    key = plan.Key("a-study", "s", PAPER, (photographed,), meanings, made)
    order = (*rated, *graded)
    asked = results.Session(shown, "r1", order)
    lines = [{**results.header(shown, "r1", "program"), "keys": "fj", "order": list(order)}]
    while asked.current is not None:
        is_graded = asked.current in graded
        said = ratings.graded(asked, 90) if is_graded else ratings.answered(asked, "natural")
        asked.take(said)
        lines.append(said.to_dict())
    return {
        "study/study.json": json.dumps(shown.to_dict()).encode(),
        "study.key.json": json.dumps(key.to_dict()).encode(),
        "study/ratings/r1.jsonl": "".join(f"{json.dumps(line)}\n" for line in lines).encode(),
    }


def recipe_case(rng: Rng) -> Trial:
    """Return a warp by a damaged recipe."""
    recipe = damaged(json.dumps(Recipe(percent=5.0).to_dict()).encode(), rng)
    return _warp("recipe", ["--points", "p.json", "--recipe", "r.json"],
                 {"p.json": points("p.json"), "r.json": recipe})  # fmt: skip


def points_case(rng: Rng) -> Trial:
    """Return a warp by damaged points."""
    name = f"p.{('json', 'csv')[rng.integers(2)]}"
    return _warp(f"points {name[1:]}", ["--points", name], {name: damaged(points(name), rng)})


def project_case(rng: Rng) -> Trial:
    """Return a warp by a damaged project."""
    return _warp("project", ["--project", "p.json"], {"p.json": damaged(project(), rng)})


def options_case(rng: Rng) -> Trial:
    """Return a warp by damaged options."""
    given = {"--points": "p.csv", "--protect": "10,20 60,70"}
    for _ in range(rng.integers(1, 4)):
        option, value = OPTIONS[rng.integers(len(OPTIONS))]
        changed = damaged(value.encode(), rng).decode("utf-8", "replace").replace("\0", "")
        given[option] = changed[:LONGEST_ARGUMENT]
    arguments = [word for option, value in given.items() for word in (option, value)]
    recipe = json.dumps(Recipe().to_dict()).encode()
    return _warp("options", arguments, {"p.csv": points("p.csv"), "recipe.json": recipe})


def font_case(rng: Rng) -> Trial:
    """Return a warp with a label in a damaged font."""
    data = ImageFont.load_default(12).font_bytes
    for _ in range(rng.geometric(bytewise.ENOUGH)):
        data = bytewise.change(data, rng, data)
    return _warp("font", ["--points", "p.csv", "--label", "Retouched", "--label-font", "f.ttf"],
                 {"p.csv": points("p.csv"), "f.ttf": data})  # fmt: skip


def study_case(rng: Rng) -> Trial:
    """Return the report of a study of which one file is damaged."""
    files = dict(study())
    name = list(files)[rng.integers(len(files))]
    files[name] = damaged(files[name], rng)
    arguments = ["experiment", "study", "report", "study", "--csv", "r.csv", "--html", "r.html"]
    outputs = ("r.csv", "r.html")
    kind = f"study {Path(name).suffixes[0]}"
    return Trial(kind, arguments, files, outputs, codes=(0, 2, 3, 5))


def sessions_case(rng: Rng) -> Trial:
    """Return an experiment that reads damaged trials, and has no photo to work on."""
    numbers = {"width": 960, "height": 720, "looking_s": 6.1, "setting_s": 22.8}
    texts = {"trial": "t", "mode": "manual", "photo": "a.jpg", "at": trials.now()}
    faces = [face_dict(template_face((480, 360), 300), 960)]
    line = {"version": 2, **numbers, **texts, "cold": False, "corrections_s": [2.2], "faces": faces}
    text = f"{json.dumps(line)}\n" * 3
    arguments = ["experiment", "timing", "no.jpg", "--trials", "t.jsonl"]
    return Trial("trials of setting", arguments, {"t.jsonl": damaged(text.encode(), rng)})


def batch_case(rng: Rng) -> Trial:
    """Return a batch with damaged projects, and a damaged report of an earlier run."""
    names = [f"{number}.png" for number in range(IN_BATCH)]
    done = [Outcome(f"in/{name}", f"out/{name}", "done", key="0" * 64) for name in names]
    report = "".join(f"{one.to_json()}\n" for one in done).encode()
    files = {f"in/{name}": photo() for name in names}
    files |= {f"in/{name}.kogao.json": damaged(project(), rng) for name in names}
    files["out/kogao-batch.jsonl"] = damaged(report, rng)
    lines = ("kogao-cli: ", "in/", f"{IN_BATCH} of {IN_BATCH}: ")
    arguments = ["batch", "in", "-o", "out", "--projects", "--jobs", "1"]
    return Trial("batch", arguments, files, ("out/*",), codes=(0, 2, 3, 5), lines=lines)


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
            Results(Path(folder, NAME)).add(path, Path(folder, "copy.png"))
        kept = [Path(folder, NAME), *Path(folder, "originals").iterdir()]
        files = {f"{STORE}/{one.relative_to(folder)}": one.read_bytes() for one in kept}
        return {"photo.png": result, **files}


def store_case(rng: Rng) -> Trial:
    """Return a command that uses the store of originals, of which one file is damaged."""
    files = dict(store())
    name = list(files)[rng.integers(1, len(files))]
    change = damaged if rng.random() < 0.8 else lambda data, _: data[: rng.integers(len(data))]
    files[name] = change(files[name], rng)
    arguments, outputs = STORE_COMMANDS[rng.integers(len(STORE_COMMANDS))]
    files |= {"p.csv": points("p.csv")} if "--points" in arguments else {}
    return Trial(f"store {arguments[0]}", arguments, files, outputs,
                 {"photo.png": photo()} if arguments[0] == "restore" else {},
                 own=(f"{STORE}/*",))  # fmt: skip


def _warp(kind: str, more: list[str], files: dict[str, bytes]) -> Trial:
    return Trial(kind, [*WARP, *more], {"photo.png": photo(), **files}, ("out.png",))


SHARES: dict[str, tuple[float, Callable[[Rng], Trial]]] = {
    "recipe": (0.2, recipe_case),
    "points": (0.28, points_case),
    "project": (0.22, project_case),
    "options": (0.1, options_case),
    "study": (0.1, study_case),
    "sessions": (0.04, sessions_case),
    "font": (0.02, font_case),
    "batch": (0.01, batch_case),
    "store": (0.2, store_case),
}


def case(rng: Rng, only: list[str]) -> Trial:
    """Return a case of a kind drawn by its share."""
    names = only or list(SHARES)
    shares = np.array([SHARES[name][0] for name in names])
    return SHARES[names[rng.choice(len(names), p=shares / shares.sum())]][1](rng)


if __name__ == "__main__":
    chosen = options(__doc__, 10_000).parse_args()
    finish(run(lambda rng: case(rng, chosen.only), chosen), chosen)
