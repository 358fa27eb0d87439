"""Project files: the same points again, at any size, and nothing hostile taken in."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.additions.brush import BrushStroke, Brushwork
from kogao_core.base.geometry import Affine
from kogao_core.base.json_reader import BadFile, Node, parse
from kogao_core.field.protection import Protection
from kogao_core.projects import json as project_json
from kogao_core.projects.project import (
    Original,
    Project,
    Sheet,
    from_node,
    load,
    save,
    to_dict,
    unit_px,
)
from kogao_core.recipe.recipe import Recipe

WIDTH, HEIGHT = 480, 360


def project():
    rng = np.random.default_rng(5)
    first = oval_face(center=(130.3, 170.7), size=0.5).with_target(10, (131.1, 230.9))
    jitter = first.outline + rng.normal(0, 1, first.outline.shape)
    first = dataclasses.replace(first, outline=jitter, confidence=rng.random(27))
    second = dataclasses.replace(oval_face(center=(350, 170), size=0.5), recipe=Recipe(percent=9.3))
    protection = Protection().with_stroke(rng.random((5, 2)) * 300, 7.7)
    manual = Sheet((oval_face(center=(131, 170), size=0.5),), recipe=Recipe(threshold_px=0.7))
    automatic = Sheet((first, second), frozenset({1}), Recipe(percent=6.1, lattice=1.3))
    original = Original("portrait.png", "0" * 64, WIDTH, HEIGHT)
    loose = (((10.5, 20.25), (10.5, 300.0)), ((0.0, 7.1), (90.0, 8.3)))
    work = Brushwork().with_stroke("push", rng.random((3, 2)) * 300, 21.3, 0.31)
    work = work.with_stroke("restore", rng.random((1, 2)) * 300, 33.3, 0.9, 0.41)
    pressed = BrushStroke("push", rng.random((3, 2)) * 99, 9.9, 0.3, 0.7, rng.random(3))
    work = Brushwork((*work.strokes, pressed))
    return Project(original, "automatic", automatic, manual, protection, loose, work)


def same_faces(mine, theirs):
    for name in ("outline", "eyes", "mouth", "targets", "confidence"):
        ours, other = getattr(mine, name), getattr(theirs, name)
        if ours is None:
            assert other is None
        else:
            np.testing.assert_array_equal(ours, other)
    assert mine.pinned_anchor == theirs.pinned_anchor
    assert (mine.score, mine.source, mine.recipe) == (theirs.score, theirs.source, theirs.recipe)


def test_what_is_read_is_what_was_written_to_the_bit(tmp_path):
    written, path = project(), tmp_path / "photo.kogao.json"
    save(written, path)
    read = load(path)
    assert read.original == written.original
    for sheet, other in ((read.automatic, written.automatic), (read.manual, written.manual)):
        assert (sheet.off, sheet.recipe) == (other.off, other.recipe)
        for mine, theirs in zip(sheet.faces, other.faces, strict=True):
            same_faces(mine, theirs)
    for mine, theirs in zip(read.protection.strokes, written.protection.strokes, strict=True):
        np.testing.assert_array_equal(mine.points_px, theirs.points_px)
        assert mine.radius_px == theirs.radius_px
    assert read.loose == written.loose
    for mine, theirs in zip(read.brushwork.strokes, written.brushwork.strokes, strict=True):
        np.testing.assert_array_equal(mine.points_px, theirs.points_px)
        np.testing.assert_array_equal(mine.pressure, theirs.pressure)
        assert (mine.kind, mine.radius_px) == (theirs.kind, theirs.radius_px)
        assert (mine.strength, mine.falloff) == (theirs.strength, theirs.falloff)
    assert sorted(path.parent.iterdir()) == [path]


def test_lines_let_go_are_scaled_with_the_photo():
    twice = project().at_size(2 * WIDTH, 2 * HEIGHT)
    np.testing.assert_allclose(twice.loose, 2.0 * np.array(project().loose) + 0.5)
    with pytest.raises(BadFile, match="loose"):
        from_node(Node({**to_dict(project()), "loose": [[[0.1, 0.2]]]}))


@pytest.mark.parametrize("scale", [0.5, 2.0, 1.7])
def test_at_another_size_points_lie_in_the_same_place(scale):
    width, height = round(WIDTH * scale), round(HEIGHT * scale)
    resized = project().at_size(width, height)
    resize = Affine.resize(width / WIDTH, height / HEIGHT)
    for mine, theirs in zip(resized.automatic.faces, project().automatic.faces, strict=True):
        np.testing.assert_allclose(mine.points, resize(theirs.points))
    assert resized.manual.recipe.threshold_px == pytest.approx(0.7 * scale, rel=0.01)
    assert (resized.original.width, resized.original.height) == (width, height)


def test_a_photo_of_another_shape_is_refused():
    with pytest.raises(BadFile, match="another shape"):
        project().at_size(WIDTH, HEIGHT - 60)


@pytest.mark.parametrize(("sides", "unit"), [((1, 1), 1), ((480, 360), 512), ((512, 4), 512)])
def test_the_unit_is_a_power_of_two_that_covers_the_photo(sides, unit):
    assert unit_px(*sides) == unit


def changed(*way, to):
    values = json.loads(json.dumps(to_dict(project())))
    inner = values
    for step in way[:-1]:
        inner = inner[step]
    inner[way[-1]] = to
    return values


FACE = ("automatic", "faces", 0)
HOSTILE = {
    "another format": changed("format", to="zip"),
    "no version": changed("version", to=None),
    "version as text": changed("version", to="1"),
    "unknown field": changed("command", to="rm"),
    "wide": changed("photo", "width", to=10**9),
    "negative": changed("photo", "height", to=-5),
    "true as number": changed("photo", "width", to=True),
    "wrong unit": changed("unit_px", to=333),
    "path with a line break": changed("photo", "path", to="a\nb"),
    "path of a megabyte": changed("photo", "path", to="a" * 10**6),
    "path with half a letter": changed("photo", "path", to="\ud800"),
    "path as a list": changed("photo", "path", to=["/etc/passwd"]),
    "mode": changed("mode", to="turbo"),
    "no faces": changed("automatic", "faces", to=None),
    "a face as text": changed(*FACE, to="face"),
    "two points": changed(*FACE, "outline", to=[[0.1, 0.1], [0.2, 0.2]]),
    "three numbers": changed(*FACE, "outline", 0, to=[1, 2, 3]),
    "far away": changed(*FACE, "outline", 0, to=[1e300, 0]),
    "five eyes": changed(*FACE, "eyes", to=[[0, 0]] * 5),
    "three eyes": changed(*FACE, "eyes", to=[[0, 0]] * 3),
    "score": changed(*FACE, "score", to=2),
    "on": changed(*FACE, "on", to=1),
    "spacing": changed(*FACE, "frame", to={"origin": [0, 0], "spacing": 0}),
    "few targets": changed(*FACE, "targets", to=[None]),
    "confidence": changed(*FACE, "confidence", to=[0.5]),
    "percent": changed("automatic", "recipe", "percent", to=1e9),
    "recipe as a list": changed("automatic", "recipe", to=[]),
    "unknown choice": changed("automatic", "recipe", "exec", to="x"),
    "an empty stroke": changed("protection", "strokes", 0, "points", to=[]),
    "a wide stroke": changed("protection", "strokes", 0, "radius", to=1e9),
    "a thousand faces": changed("automatic", "faces", to=[{}] * 1001),
    "percent of 400 digits": changed("automatic", "recipe", "percent", to=10**400),
}


@pytest.mark.parametrize("values", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_values_are_refused_in_a_sentence(values):
    with pytest.raises(BadFile) as refused:
        from_node(Node(values))
    text = str(refused.value)
    assert "\n" not in text
    assert 10 < len(text) < 400


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff\xfe",
        b"{",
        b"[" * 100_000,
        b'{"a": ' * 20_000,
        b"NaN",
        b'{"version": Infinity}',
        b'{"version": ' + b"9" * 5000 + b"}",
        b'{"version": 1, "version": 1}',
        b"null",
        b"3",
        b'"text"',
    ],
)
def test_hostile_bytes_are_refused_in_a_sentence(data, tmp_path):
    path = tmp_path / "hostile.json"
    path.write_bytes(data)
    with pytest.raises(BadFile) as refused:
        load(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (changed("protection", "strokes", to=[{"points": [[0, 0]] * 5001}] * 2), "corners"),
        (changed("automatic", "faces", to=[{"outline": [[0, 0]] * 9000}] * 6), "landmarks"),
    ],
)
def test_too_much_of_everything_is_refused_before_it_is_read(values, words):
    with pytest.raises(BadFile, match=f"{words} together"):
        from_node(Node(values))


def test_a_huge_file_is_refused_unread():
    with pytest.raises(BadFile, match="at most"):
        parse(b" " * 101, 100)


def test_a_number_beyond_all_floats_is_refused():
    with pytest.raises(BadFile, match="within"):
        parse(b'{"score": 1e999}', 2**20).field("score").number(0.0, 1.0)


def test_a_newer_version_says_to_update():
    with pytest.raises(BadFile, match="newer Kogao"):
        from_node(Node(changed("version", to=2) | {"unheard-of": 1}))


def test_every_field_of_a_face_is_written():
    from kogao_core.faces.face import Face

    known = {"pinned_anchor": "frame"}
    fields = {known.get(f.name, f.name) for f in dataclasses.fields(Face)}
    assert fields == set(project_json.face_dict(oval_face(), 512))
