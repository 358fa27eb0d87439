"""Landmarks keep their places through every format, and strange files are refused in a sentence."""

import json

import numpy as np
import pytest
from kogao_resources.training.evaluate import distance_to_line
from scenes import oval_face

from kogao_core.base.geometry import Affine, Box
from kogao_core.base.json_reader import BadFile
from kogao_core.faces.face import Face
from kogao_core.projects import interchange, landmark_files
from kogao_core.projects.interchange import along, face_of, own_points, write

ROUNDED = 0.00051  # files hold thousandths of a px


PHOTO = Box(0, 0, 480, 360)


def read(path):
    return interchange.read(path, "photo.jpg", PHOTO)


def turned_face():
    return oval_face().mapped(Affine.similarity(1.7, 20.0, (40.0, -10.0)))


@pytest.mark.parametrize("suffix", ["json", "csv"])
def test_our_27_points_of_every_face_come_back_as_they_were(tmp_path, suffix):
    faces, path = [turned_face(), oval_face()], tmp_path / f"faces.{suffix}"
    assert write(faces, path) == ""
    atol = 0 if suffix == "json" else ROUNDED
    for back, face in zip(read(path), faces, strict=True):
        np.testing.assert_allclose(back.points, face.points, atol=atol)


def test_resampling_follows_the_curve_and_not_its_chords():
    angle = np.linspace(np.pi, 0.0, 17)
    half_circle = 100.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    radius = np.linalg.norm(along(half_circle, 21), axis=1)
    np.testing.assert_allclose(radius, 100.0, atol=0.15)
    np.testing.assert_allclose(along(half_circle, 17), half_circle, atol=0.05)
    straight = np.array([[0.0, 0.0], [3.0, 4.0]])
    np.testing.assert_allclose(along(straight, 3), [[0, 0], [1.5, 2], [3, 4]], atol=1e-12)


def test_another_programs_68_points_become_the_outline_by_arc_length():
    angle = np.linspace(np.pi, 0.0, 17) ** 1.2
    points = np.zeros((68, 2))
    points[:17] = np.column_stack([100 * np.cos(angle), 100 * np.sin(angle)])
    points[[36, 39, 42, 45]] = [(-40, -10), (-15, -10), (15, -10), (40, -10)]
    points[[48, 54]] = [(-20, 50), (20, 50)]
    face = face_of(points)
    steps = np.linalg.norm(np.diff(face.outline, axis=0), axis=1)
    assert np.ptp(steps) < 0.03 * steps.mean()
    np.testing.assert_array_equal(face.outline[[0, -1]], points[[0, 16]])
    np.testing.assert_array_equal(face.eyes, points[[36, 39, 42, 45]])
    assert face.source == "points"


def test_an_outline_of_another_count_is_resampled_and_said(tmp_path):
    face = oval_face()
    many = Face(np.repeat(face.outline, 2, axis=0)[:-1], face.eyes, face.mouth)
    assert "resampled to 21" in write([many], tmp_path / "face.csv")
    assert write([many], tmp_path / "face.json") == ""
    assert len(read(tmp_path / "face.json")[0].outline) == 41


def by_hand(suffix):
    """A file of the oval face as a hand or another program may have left it."""
    points = oval_face().points.tolist()
    if suffix == "pts":  # with comments
        rows = "\n".join(f"{x + 1:.3f} {y + 1:.3f}" for x, y in points)
        return f"# by hand\nversion: 1\nn_points: 27\n{{\n  # the jaw\n{rows}\n}}\n# end\n"
    if suffix == "of Europe.csv":
        return "\n".join(["x;y", *(f"{x:.3f};{y:.3f}".replace(".", ",") for x, y in points)])
    # Editors of Windows begin files with a byte order mark.
    if suffix == "json":  # what `detect` prints
        image = {"width": 480, "height": 360}
        return "\ufeff" + json.dumps({"image": image, "faces": [oval_face().to_dict()]}, indent=1)
    return "\r\n".join(["\ufeffY ,name,x", *(f"{y},p,{x}" for x, y in points)])


@pytest.mark.parametrize("suffix", ["pts", "of Europe.csv", "csv", "json"])
def test_files_by_hand_are_read(tmp_path, suffix):
    path = tmp_path / f"face.{suffix}"
    path.write_text(by_hand(suffix), encoding="utf-8")
    (face,) = read(path)
    np.testing.assert_allclose(face.points, oval_face().points, atol=ROUNDED)


def test_a_table_that_was_sorted_is_read_by_its_names(tmp_path):
    path = tmp_path / "face.csv"
    write([oval_face(), turned_face()], path)
    before = [face.points.tobytes() for face in read(path)]
    first, *rows = path.read_text().splitlines()
    path.write_text("\n".join([first, *sorted(rows, key=lambda row: float(row.split(",")[3]))]))
    assert sorted(face.points.tobytes() for face in read(path)) == sorted(before)


HEAD = "version: 1\nn_points: 2\n{\n"
HOSTILE = {
    "empty.pts": b"",
    "binary.pts": b"\x89PNG\r\n\x1a\n\0\0",
    "words.pts": b"hello there",
    "digits.pts": "version: 1\nn_points: \N{SUPERSCRIPT TWO}\n{\n1 2\n}".encode(),
    "infinite.pts": b"version: 1\nn_points: 1\n{\n1 inf\n}",
    "far.pts": b"version: 1\nn_points: 1\n{\n1e300 0\n}",
    "three.pts": b"version: 1\nn_points: 1\n{\n1 2 3\n}",
    "huge-count.pts": b"version: 1\nn_points: 99999999999\n{\n1 2\n}",
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
    ("content", "found", "advice"),
    [
        (
            '[{"id": 1, "annotations": [], "data": {}}]',
            "id, annotations, data",
            "Label Studio.*COCO",
        ),
        ('{"shapes": 1, "faces_of": 2}', "", "as labelme writes it"),
        ('{"format": "kogao-project", "unit_px": 1024}', "a project", "--project"),
    ],
)
def test_json_of_others_is_named_with_a_way_out(tmp_path, content, found, advice):
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(BadFile, match=f"it (has|is|isn't) .*{found}.*{advice}"):
        read(tmp_path / "a.json")


def test_files_too_large_missing_and_folders_are_refused(tmp_path, monkeypatch):
    (tmp_path / "folder.csv").mkdir()
    for name, words in (("folder.csv", "can't be read"), ("missing.pts", "doesn't exist; check")):
        with pytest.raises(BadFile, match=words):
            read(tmp_path / name)
    (tmp_path / "large.pts").write_bytes(b"# x\n" * 100)
    monkeypatch.setattr(landmark_files, "MOST_BYTES", 100)
    with pytest.raises(BadFile, match="too many for landmarks"):
        read(tmp_path / "large.pts")


def test_points_of_another_photo_are_told_from_this_ones():
    photo, face = Box(0, 0, 480, 360), oval_face()
    interchange.check_inside([face], photo)
    with pytest.raises(BadFile, match="another photo or size"):
        interchange.check_inside([face, oval_face(4800, 3600)], photo)
    outline = face.outline.copy()
    outline[2, 0] = 1260.0
    with pytest.raises(BadFile, match="landmark 3 of face 1"):
        interchange.check_inside([Face(outline, face.eyes, face.mouth)], photo)


def test_labels_of_189_points_agree_with_the_mesh(shared_data, weights):
    """Hand labels come in where the faces are: corners and outline near those found."""
    del weights
    from kogao_core.faces.landmarks import MeshSource
    from kogao_core.photo import read as read_photo

    apart = []
    for person in ("002", "003", "007"):
        photo = read_photo(shared_data / "frll" / f"{person}_neutral.jpg")
        (found,) = MeshSource().find(photo.pixels)
        table = shared_data / "frll" / f"{person}_neutral.csv"
        (labelled,) = interchange.read(table, photo.path.name, Box.of(photo.pixels))
        inner = labelled.outline[3:-3]
        errors = [
            np.linalg.norm(found.eyes - labelled.eyes, axis=1).mean(),
            np.linalg.norm(found.mouth - labelled.mouth, axis=1).mean(),
            distance_to_line(inner, found.outline).mean(),
        ]
        apart.append(np.array(errors) / labelled.interocular_px)
    assert np.mean(apart) < 0.03


def test_csv_text_names_our_points():
    text = interchange.csv_text([own_points(oval_face())])
    rows = text.splitlines()
    assert rows[0] == "face,point,x,y"
    assert rows[11].startswith("1,outline-11,")
    assert rows[-1].startswith("1,mouth-2,")


def labelme(points):
    """Shapes in the order of drawing: the outline as one polyline, corners as points."""
    outline, corners = points[:21], points[21:]
    names = ["Eye_3", "Eye_1", "Eye_2", "Eye_4", "mouth_1", "mouth_2"]
    order = [2, 0, 1, 3, 4, 5]
    shapes = [
        {"label": name, "points": [corners[k]], "group_id": None, "shape_type": "point"}
        for name, k in zip(names, order, strict=True)
    ]
    line = {"label": "outline", "points": outline, "group_id": None, "shape_type": "linestrip"}
    box = {"label": "face", "points": [[0, 0], [9, 9]], "group_id": None, "shape_type": "rectangle"}
    top = {"version": "6.3.1", "shapes": [box, *shapes, line], "imagePath": "photo.jpg"}
    return json.dumps(top | {"imageHeight": 360, "imageWidth": 480})


def coco(points):
    flat = [value for x, y in points for value in (x, y, 2)]
    images = [{"id": k, "file_name": f"a/{n}.jpg", "width": 480, "height": 360}
              for k, n in ((7, "other"), (8, "photo"))]  # fmt: skip
    faces = [{"id": 1, "image_id": 7, "category_id": 1, "keypoints": [1, 1, 2] * 27},
             {"id": 2, "image_id": 8, "category_id": 1, "keypoints": flat}]  # fmt: skip
    return json.dumps({"images": images, "annotations": faces})


def cvat(points):
    parts = "".join(
        f'<points label="{k + 1}" outside="0" points="{x:.2f},{y:.2f}"></points>'
        for k, (x, y) in sorted(enumerate(points), key=lambda part: str(part[0]))
    )
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<annotations><version>1.1</version>'
        '<image id="0" name="photo.jpg" width="480" height="360">'
        f'<box label="head" xtl="1" ytl="1" xbr="9" ybr="9"/>'
        f'<skeleton label="face" z_order="0">{parts}</skeleton></image></annotations>'
    )


def dlib_xml(points):
    parts = "".join(f"<part name='{k:02}' x='{x}' y='{y}'/>" for k, (x, y) in enumerate(points))
    return (
        "<?xml version='1.0' encoding='ISO-8859-1'?>\n<dataset><name>n</name><images>"
        "<image file='photo.jpg' width='480' height='360'>"
        f"<box top='1' left='1' width='9' height='9'>{parts}</box></image></images></dataset>"
    )


def tem(points):
    rows = "\n".join(f"{x}\t{y}" for x, y in points)
    return f"{len(points)}\n{rows}\n2\n0\n2\n0 1\n1\n3\n1 2 3\n"


def imagej(points):
    rows = "\n".join(f"{k},0,9,9,9,{x},{y}" for k, (x, y) in enumerate(points, 1))
    return f" ,Area,Mean,Min,Max,X,Y\n{rows}\n"


# Positions of the first pixel's centre, measured in the programs (docs/interchange.md).
OF_OTHERS = {
    "labelme.json": (labelme, 0.5),
    "coco.json": (coco, 0.5),
    "cvat.xml": (cvat, 0.5),
    "dlib.xml": (dlib_xml, 0.0),
    "webmorph.tem": (tem, 0.0),
    "imagej.csv": (imagej, 0.0),
}


@pytest.mark.parametrize("name", OF_OTHERS)
def test_files_of_other_programs_are_read_without_their_half_pixel(tmp_path, name):
    write_as, first_pixel = OF_OTHERS[name]
    (tmp_path / name).write_text(write_as((oval_face().points + first_pixel).tolist()))
    (face,) = read(tmp_path / name)
    np.testing.assert_allclose(face.points, oval_face().points, atol=0.006)


def test_mediapipes_shares_become_px(tmp_path):
    """478 points: eyes and mouth are corners of the mesh, the outline is its silhouette."""
    from kogao_core.faces.landmarks.mesh import EYES, MOUTH
    from kogao_core.faces.landmarks.outline import _RIM

    face, mesh = oval_face(), np.tile(oval_face().middle, (478, 1))
    angle = np.linspace(0, 2 * np.pi, len(_RIM), endpoint=False)
    radius = np.array([0.6, 0.8]) * np.ptp(face.outline[:, 0])
    mesh[_RIM] = face.middle + np.column_stack([np.sin(angle), np.cos(angle)]) * radius
    mesh[list(EYES)], mesh[list(MOUTH)] = face.eyes, face.mouth
    points = [{"x": x / 480, "y": y / 360, "z": 0.0} for x, y in mesh.tolist()]
    for number, top in enumerate(({"faceLandmarks": [points]}, [points], {"landmark": points})):
        path = tmp_path / f"{number}.json"
        path.write_text(json.dumps(top))
        (back,) = read(path)
        away = back.eyes - face.eyes
        np.testing.assert_allclose(
            away, np.full_like(away, -0.0038 * face.interocular_px), atol=1e-6
        )
        assert len(back.outline) == 21


def numbered(order, prefix="", first=1):
    rows = [f"{prefix}{k + first},{x},{y}" for k, (x, y) in enumerate(oval_face().points.tolist())]
    return "point,x,y\n" + "\n".join(sorted(rows, key=order) if order else rows[::-1])


@pytest.mark.parametrize(
    "text", [numbered(str), numbered(None), numbered(str, "P_", 0), numbered(str, "landmark ")]
)
def test_numbers_sort_points_whatever_a_spreadsheet_made_of_their_order(tmp_path, text):
    (tmp_path / "a.csv").write_text(text)
    (face,) = read(tmp_path / "a.csv")
    np.testing.assert_array_equal(face.points, oval_face().points)


def test_an_outline_of_another_count_is_told_by_its_names(tmp_path):
    face = oval_face()
    line = along(face.outline, 31)
    rows = [("Outline", *p) for p in line] + [("EYES", *p) for p in face.eyes]
    rows += [("mouth", *p) for p in face.mouth]
    text = "\n".join(f"{name},{x},{y}" for name, x, y in rows)
    (tmp_path / "a.csv").write_text(f"Point,X,Y\n{text}")
    (back,) = read(tmp_path / "a.csv")
    np.testing.assert_allclose(back.points, face.points, atol=0.1)


def odd(change):
    return change(oval_face().points.copy())


def reversed_outline(points):
    points[:21] = points[20::-1]
    return points


def shuffled(points):
    points[:21] = points[np.argsort([str(k) for k in range(21)])]
    return points


ODD = {
    "x and y are exchanged": lambda points: points[:, ::-1],
    "y counts upwards": lambda points: [0, 359] + points * [1, -1],
    "left and right are exchanged": lambda points: [479, 0] + points * [-1, 1],
    "runs from right to left": reversed_outline,
    "crosses itself": shuffled,
    "shares of the photo's size": lambda points: points / [480, 360],
}


@pytest.mark.parametrize("reason", ODD)
def test_points_that_form_no_face_are_refused_with_the_likely_reason(tmp_path, reason):
    rows = "\n".join(f"{x},{y}" for x, y in odd(ODD[reason]))
    (tmp_path / "a.csv").write_text(f"x,y\n{rows}")
    with pytest.raises(BadFile, match=reason):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("a.csv", "x\ty\n1\t2\n", "separated by tabs"),
        ("a.csv", numbered(str).replace("\n27,", "\n26,"), "numbered from 0 or 1"),
        ("a.json", labelme(oval_face().points.tolist()).replace("360", "720"), "of 480 x 720"),
        ("a.json", coco([]).replace("photo", "third"), "none for photo.jpg"),
        ("a.json", coco([[1.0, 20.0]] * 3), "3 points instead of 27"),
        ("a.xml", '<!DOCTYPE a [<!ENTITY b "c">]><annotations/>', "definitions"),
        ("a.xml", "<annotations><image>", "not XML"),
        ("a.xml", "<html/>", "it has .html. instead"),
        ("a.json", f'{{"faces": [{{"outline": [{"0," * 50_000}0]}}]}}', "50000 landmarks together"),
        ("a.csv", "x,y\n" + "1,2\n" * 400_001, "too many lines"),
        ("a.pts", "1 " * 100_000 + "\n", "too long ones, for landmarks"),
    ],
)  # fmt: skip
def test_files_of_others_that_cant_be_used_say_why(tmp_path, name, text, reason):
    (tmp_path / name).write_text(text)
    with pytest.raises(BadFile, match=reason):
        read(tmp_path / name)


BESIDE = {
    "as on a photo of 2(39|40|41) x 1(79|80|81) px": lambda face: face.mapped(
        Affine.similarity(0.5, 0.0, (0.0, 0.0))
    ),
    "the photo upside down": lambda face: face.mapped(
        Affine.similarity(1.0, 180.0, (479.0, 359.0))
    ),
}


def test_points_in_another_scale_or_turned_fit_a_found_face_only_so():
    found = oval_face().mapped(Affine.similarity(0.7, 0.0, (20.0, 30.0)))
    interchange.check_found([found], [found], PHOTO)
    interchange.check_found([oval_face()], [], PHOTO)
    for reason, change in BESIDE.items():
        with pytest.raises(BadFile, match=reason):
            interchange.check_found([change(found)], [found], PHOTO)
    mirrored = found.mapped(Affine(np.diag([-1.0, 1.0]), np.array([479.0, 0.0])))
    again = Face(mirrored.outline[::-1], mirrored.eyes[::-1], mirrored.mouth[::-1])
    with pytest.raises(BadFile, match="mirrored"):
        interchange.check_found([again], [found], PHOTO)
