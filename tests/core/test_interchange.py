"""Landmarks keep their places through every format, and strange files are refused in a sentence."""

import json

import numpy as np
import pytest
from kogao_resources.training.evaluate import distance_to_line
from scenes import oval_face

from kogao_core.base.geometry import Affine, Box
from kogao_core.base.strict import BadFile
from kogao_core.faces.face import Face
from kogao_core.projects import interchange
from kogao_core.projects.interchange import formats, read, template, write
from kogao_core.projects.interchange.formats import Line, PointSet
from kogao_core.projects.interchange.templates import along, shares_of

ROUNDED = 0.00051  # files hold thousandths of a px


def turned_face():
    return oval_face().mapped(Affine.similarity(1.7, 20.0, (40.0, -10.0)))


def farthest(face, other):
    """How far the corners of eyes and mouth, and the outlines as curves, lie apart, px."""
    corners = np.abs(np.vstack([face.eyes - other.eyes, face.mouth - other.mouth])).max()
    there = distance_to_line(face.outline, other.outline).max()
    return corners, max(there, distance_to_line(other.outline, face.outline).max())


@pytest.mark.parametrize("suffix", ["json", "csv", "tem", "pts"])
def test_our_27_points_come_back_as_they_were(tmp_path, suffix):
    face, path = turned_face(), tmp_path / f"face.{suffix}"
    (written,) = write([face], path, None if suffix == "json" else "27")
    assert written.note == ""
    (back,) = read(path)
    np.testing.assert_allclose(back.points, face.points, atol=0 if suffix == "json" else ROUNDED)


@pytest.mark.parametrize(("suffix", "wanted"), [("pts", "68"), ("tem", "189"), ("csv", "68")])
def test_larger_templates_keep_corners_exactly_and_the_outline_as_a_curve(tmp_path, suffix, wanted):
    face, path = turned_face(), tmp_path / f"face.{suffix}"
    (written,) = write([face], path, wanted)
    guessed = {"68": 45, "189": 164}[wanted]
    assert f"{guessed} of {wanted} points are a mean face's" in written.note
    (back,) = read(path)
    corners, apart = farthest(face, back)
    assert corners < ROUNDED
    # `apart` counts the sagitta between the points, which the curve through them doesn't have.
    assert apart < 0.005 * face.interocular_px


def test_resampling_follows_the_curve_and_not_its_chords():
    angle = np.linspace(np.pi, 0.0, 17)
    half_circle = 100.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    radius = np.linalg.norm(along(half_circle, 21), axis=1)
    np.testing.assert_allclose(radius, 100.0, atol=0.15)
    np.testing.assert_allclose(along(half_circle, 17), half_circle, atol=0.05)
    straight = np.array([[0.0, 0.0], [3.0, 4.0]])
    np.testing.assert_allclose(along(straight, 3), [[0, 0], [1.5, 2], [3, 4]], atol=1e-12)


@pytest.mark.parametrize("wanted", ["68", "189"])
def test_what_isnt_ours_follows_the_face(wanted):
    """The mean face turns, grows and moves with ours, and its eyes lie on ours."""
    move = Affine.similarity(2.5, -35.0, (300.0, 80.0))
    plain, moved = (
        template(wanted).points(oval_face()),
        template(wanted).points(oval_face().mapped(move)),
    )
    np.testing.assert_allclose(moved.points, move(plain.points), atol=1e-6)
    rows = {"68": (range(36, 42), range(42, 48)), "189": ((0,), (1,))}[wanted]
    face = oval_face()
    for side, eye in zip(rows, (face.eyes[:2], face.eyes[2:]), strict=True):
        middle = plain.points[list(side)].mean(axis=0)
        assert np.linalg.norm(middle - eye.mean(axis=0)) < 0.1 * face.interocular_px


def test_ibug_counts_pixels_from_one():
    first = formats.parse_pts(b"version: 1\nn_points: 1\n{\n1 1\n}\n")
    np.testing.assert_array_equal(first.points, [[0.0, 0.0]])
    assert "\n1.000 11.000\n" in formats.pts_text(PointSet([[0.0, 10.0]]))


def test_webmorph_counts_pixels_from_zero_and_y_runs_down():
    points = formats.parse_tem(b"2\n0\t0\n10\t20\n")
    np.testing.assert_array_equal(points.points, [[0.0, 0.0], [10.0, 20.0]])
    chin, eyes = template("189").points(oval_face()).points[[129, 18]]
    assert chin[1] > eyes[1]


def test_templates_keep_their_lines_and_read_comments_and_blank_rows():
    lines = (Line((0, 2, 1), True), Line((1,)))
    text = formats.tem_text(PointSet([[0, 0], [1.5, 2], [3, 4]], lines))
    assert text == "3\n0.000\t0.000\n1.500\t2.000\n3.000\t4.000\n2\n1\n3\n0 2 1\n0\n1\n1\n"
    spaced = b"# made by hand\r\n" + text.replace("\n", "\r\n\r\n").encode()
    assert formats.parse_tem(spaced).lines == lines
    for one in interchange.TEMPLATES.values():
        again = formats.parse_tem(formats.tem_text(one.points(oval_face())).encode())
        assert again.lines == one.lines
        assert len(again.points) == one.count


def test_another_programs_68_points_become_the_outline_by_arc_length():
    angle = np.linspace(np.pi, 0.0, 17) ** 1.2
    points = np.zeros((68, 2))
    points[:17] = np.column_stack([100 * np.cos(angle), 100 * np.sin(angle)])
    points[[36, 39, 42, 45]] = [(-40, -10), (-15, -10), (15, -10), (40, -10)]
    points[[48, 54]] = [(-20, 50), (20, 50)]
    face = template("68").face(PointSet(points))
    steps = np.linalg.norm(np.diff(face.outline, axis=0), axis=1)
    assert np.ptp(steps) < 0.03 * steps.mean()
    np.testing.assert_array_equal(face.outline[[0, -1]], points[[0, 16]])
    np.testing.assert_array_equal(face.eyes, points[[36, 39, 42, 45]])
    assert face.source == "points"


def test_any_template_comes_in_by_a_mapping(tmp_path):
    points = np.random.default_rng(3).uniform(0, 100, (50, 2))
    path = tmp_path / "other.tem"
    path.write_text(formats.tem_text(PointSet(points)))
    with pytest.raises(BadFile, match="50 points are none of the templates"):
        read(path)
    (face,) = read(path, template("20-0/30,31,32,33/40,41"))
    np.testing.assert_allclose(face.outline[[0, -1]], points[[20, 0]], atol=ROUNDED)
    np.testing.assert_allclose(face.eyes, points[30:34], atol=ROUNDED)
    with pytest.raises(BadFile, match="point 99"):
        read(path, template("0-20/30,31,32,33/40,99"))


@pytest.mark.parametrize(
    "spec", ["", "70", "0-16/1,2,3/4,5", "0-1/1,2,3,4/5,6", "a/b/c", "0--3/1,2,3,4/5,6", "1/2/3/4"]
)
def test_mappings_that_are_none_are_refused(spec):
    with pytest.raises(ValueError, match="such as 0-16/36,39,42,45/48,54"):
        template(spec)


@pytest.mark.parametrize(
    ("suffix", "names"),
    [("csv", ["group.csv"]), ("json", ["group.json"]), ("tem", ["group.tem", "group-2.tem"])],
)
def test_several_faces_take_one_file_or_each_its_own(tmp_path, suffix, names):
    faces = [turned_face(), oval_face()]
    written = write(faces, tmp_path / f"group.{suffix}")
    assert [one.path.name for one in written] == names
    back = [face for name in names for face in read(tmp_path / name)]
    assert len(back) == 2
    np.testing.assert_allclose(back[1].points, faces[1].points, atol=ROUNDED)


def test_an_outline_of_another_count_is_resampled_and_said(tmp_path):
    face = oval_face()
    many = Face(np.repeat(face.outline, 2, axis=0)[:-1], face.eyes, face.mouth)
    (written,) = write([many], tmp_path / "face.tem")
    assert "resampled to 21" in written.note
    (json_file,) = write([many], tmp_path / "face.json")
    assert len(read(json_file.path)[0].outline) == 41


def test_what_detect_prints_is_read(tmp_path):
    path = tmp_path / "found.json"
    printed = {"image": {"width": 480, "height": 360}, "faces": [oval_face().to_dict()]}
    path.write_text(json.dumps(printed))
    np.testing.assert_array_equal(read(path)[0].points, oval_face().points)


def by_hand(suffix):
    """A file of the oval face as a hand or another program may have left it."""
    points, plain = oval_face().points.tolist(), formats.pts_text(PointSet(oval_face().points))
    if suffix == "pts":  # with comments
        first, rest = plain.split("{\n")
        return f"# by hand\n{first}{{\n  # the jaw\n{rest}# end\n"
    if suffix == "of Europe.csv":
        return "\n".join(["x;y", *(f"{x:.3f};{y:.3f}".replace(".", ",") for x, y in points)])
    return "\n".join(["\ufeffY ,name,x", *(f"{y},p,{x}" for x, y in points)])


@pytest.mark.parametrize("suffix", ["pts", "of Europe.csv", "csv"])
def test_files_by_hand_are_read(tmp_path, suffix):
    path = tmp_path / f"face.{suffix}"
    path.write_text(by_hand(suffix))
    (face,) = read(path)
    np.testing.assert_allclose(face.points, oval_face().points, atol=ROUNDED)


@pytest.mark.parametrize("wanted", ["27", "68"])
def test_a_table_that_was_sorted_is_read_by_its_names(tmp_path, wanted):
    path = tmp_path / "face.csv"
    write([oval_face(), turned_face()], path, wanted)
    before = [face.points.tobytes() for face in read(path)]
    first, *rows = path.read_text().splitlines()
    path.write_text("\n".join([first, *sorted(rows, key=lambda row: float(row.split(",")[3]))]))
    assert sorted(face.points.tobytes() for face in read(path)) == sorted(before)


@pytest.mark.parametrize("suffix", ["json", "csv", "tem", "pts"])
def test_files_of_windows_editors_begin_with_a_byte_order_mark(tmp_path, suffix):
    path = tmp_path / f"face.{suffix}"
    write([oval_face()], path, None if suffix == "json" else "27")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    np.testing.assert_allclose(read(path)[0].points, oval_face().points, atol=ROUNDED)


HEAD = "version: 1\nn_points: 2\n{\n"
HOSTILE = {
    "empty.tem": b"",
    "binary.tem": bytes(range(256)),
    "words.tem": b"hello there",
    "short.tem": b"3\n1 2\n",
    "huge-count.tem": b"99999999999\n1 2\n",
    "minus.tem": b"-1\n",
    "nan.tem": b"1\nnan 2\n",
    "infinite.tem": b"1\n1 inf\n",
    "far.tem": b"1\n1e300 0\n",
    "three.tem": b"1\n1 2 3\n",
    "lines.tem": b"1\n1 2\n1\n0\n1\n",
    "line-to-nowhere.tem": b"1\n1 2\n1\n0\n1\n7\n",
    "line-count.tem": b"1\n1 2\n1\n0\n2\n0\n",
    "open-or-not.tem": b"1\n1 2\n1\n2\n1\n0\n",
    "digits.tem": "\N{SUPERSCRIPT TWO}\n1 2\n".encode(),
    "few.tem": b"2\n1 2\n3 4\n0\n",
    "empty.pts": b"",
    "binary.pts": b"\x89PNG\r\n\x1a\n\0\0",
    "two.pts": HEAD.encode() + b"1 2\n}",
    "version.pts": b"version: 2\nn_points: 0\n{\n}\n",
    "open.pts": HEAD.encode() + b"1 2\n3 4\n",
    "nan.pts": HEAD.encode() + b"1 2\nnan 4\n}",
    "text.pts": HEAD.encode() + b"1 2\nthree 4\n}",
    "empty.csv": b"",
    "header.csv": b"a,b\n1,2\n",
    "twice.csv": b"x,y,x\n1,2,3\n",
    "ragged.csv": b"x,y\n1\n",
    "none.csv": b"x,y\n",
    "quote.csv": b'x,y\n"1,2\n',
    "nan.csv": b"x,y\n1,NaN\n",
    "count.csv": b"x,y\n" + b"1,2\n" * 26,
    "one-place.csv": b"x,y\n" + b"5,5\n" * 27,
    "none.json": b'{"faces": []}',
    "list.json": b"[1, 2]",
    "other.json": b'{"%s": []}' % (b"x" * 10_000),
    "nan.json": b'{"faces": [{"outline": [[NaN, 1]], "eyes": [], "mouth": []}]}',
    "triple.json": b'{"faces": [{"outline": [[1, 1, 1]], "eyes": [], "mouth": []}]}',
    "few.json": b'{"faces": [{"outline": [[1, 1]], "eyes": [], "mouth": []}]}',
    "far.json": b'{"faces": [{"outline": [[1e99, 1]], "eyes": [], "mouth": []}]}',
    "deep.json": b"[" * 100_000,
    "some.txt": b"1 2",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_strange_files_are_refused_in_a_sentence(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(HOSTILE[name])
    with pytest.raises(BadFile) as refusal:
        read(path)
    said = str(refusal.value)
    assert str(path) in said
    assert "\n" not in said
    assert len(said) < len(str(path)) + 250


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.json", b'{"faces": [{"outline": [' + b"0," * 50_000 + b"0]}]}", "landmarks together"),
        ("a.csv", b"x,y\n" + b"1,2\n" * 400_001, "too many lines"),
        ("a.tem", b"1\n" + b"1 " * 100_000, "too long ones, for landmarks"),
        ("a.pts", b"1 " * 100_000 + b"\n", "too long ones, for landmarks"),
    ],
)
def test_more_points_than_photos_have_faces_for_are_refused(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadFile, match=words):
        read(tmp_path / name)


@pytest.mark.parametrize(
    ("content", "found", "advice"),
    [
        ('{"version": "5.4.1", "flags": {}, "shapes": []}', "version, flags, shapes", ".csv file"),
        ('{"images": [], "annotations": []}', "images, annotations", ".csv file"),
        ('{"format": "kogao-project", "unit_px": 1024}', "a project", "--project"),
    ],
)
def test_json_of_others_is_named_with_a_way_out(tmp_path, content, found, advice):
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(BadFile, match=f"it (holds|is) .*{found}.*; .*{advice}"):
        read(tmp_path / "a.json")


def test_files_too_large_missing_and_folders_are_refused(tmp_path, monkeypatch):
    (tmp_path / "folder.tem").mkdir()
    for name in ("folder.tem", "missing.pts"):
        with pytest.raises(BadFile, match="can't be read"):
            read(tmp_path / name)
    (tmp_path / "large.tem").write_bytes(b"1\n1 2\n" + b"# x\n" * 100)
    monkeypatch.setattr(formats, "MOST_BYTES", 100)
    with pytest.raises(BadFile, match="too many for landmarks"):
        read(tmp_path / "large.tem")


def test_templates_that_a_format_hasnt_are_refused_and_nothing_is_written(tmp_path):
    with pytest.raises(BadFile, match="not in '68'"):
        write([oval_face()], tmp_path / "face.json", "68")
    with pytest.raises(BadFile, match=r"must end in one of \.json"):
        write([oval_face()], tmp_path / "face.doc")
    assert not list(tmp_path.iterdir())


def test_points_of_another_photo_are_told_from_this_ones():
    photo, face = Box(0, 0, 480, 360), oval_face()
    interchange.check_inside([face], photo)
    with pytest.raises(BadFile, match="another photo or size"):
        interchange.check_inside([face, oval_face(4800, 3600)], photo)
    outline = face.outline.copy()
    outline[2, 0] = 1260.0
    with pytest.raises(BadFile, match="landmark 3 of face 1"):
        interchange.check_inside([Face(outline, face.eyes, face.mouth)], photo)


def test_labels_of_the_189_template_agree_with_the_mesh(shared_data, weights):
    """Hand labels come in where the faces are: corners and outline near those found."""
    del weights
    from kogao_core.faces.landmarks import MeshSource
    from kogao_core.photo import read as read_photo

    apart = []
    for person in ("002", "003", "007"):
        photo = read_photo(shared_data / "frll" / f"{person}_neutral.jpg")
        (found,) = MeshSource().find(photo.pixels)
        (labelled,) = read(shared_data / "frll" / f"{person}_neutral.csv")
        inner = labelled.outline[3:-3]
        errors = [
            np.linalg.norm(found.eyes - labelled.eyes, axis=1).mean(),
            np.linalg.norm(found.mouth - labelled.mouth, axis=1).mean(),
            distance_to_line(inner, found.outline).mean(),
        ]
        apart.append(np.array(errors) / labelled.interocular_px)
    assert np.mean(apart) < 0.03


def test_csv_text_names_our_points():
    text = formats.csv_text([oval_face().points])
    rows = text.splitlines()
    assert rows[0] == "face,point,x,y"
    assert rows[11].startswith("1,outline-11,")
    assert rows[-1].startswith("1,mouth-2,")


def test_shares_of_a_line_go_by_length():
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 3.0)])
    assert shares_of(corners).tolist() == [0.0, 0.25, 1.0]
