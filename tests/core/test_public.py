"""The promised names: all there, each its home's own, and free until they are asked for."""

import ast
import importlib.util
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from programs import ran
from scenes import oval_face, textured_photo

import kogao_core as kogao

HOME = Path(kogao.__file__)
LOADED = """
import sys, kogao_core
{then}
heavy = ('typing', 'numpy', 'cv2', 'PIL', 'PySide6', 'shiboken6', 'pyqtgraph')
print(sorted(set(heavy) & {{m.split('.')[0] for m in sys.modules}}))
"""


def loaded(then=""):
    return ran(LOADED.format(then=then)).stdout.strip()


def seen_by_type_checkers():
    """The public names of the block for type checkers, with their modules and names there."""
    tree = ast.parse(HOME.read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    *imports, renamed = block.body
    names = {
        alias.asname: (node.module, alias.name)
        for node in imports
        for alias in node.names
        if alias.asname
    }
    for name, value in zip(renamed.targets[0].elts, renamed.value.elts, strict=True):
        names[name.id] = f"kogao_core.projects.{value.value.id}", value.attr
    return names


def test_the_import_loads_nothing():
    assert loaded() == "[]"


def test_no_promised_name_loads_qt():
    assert loaded("for name in kogao_core.__all__: getattr(kogao_core, name)") == str(
        ["PIL", "cv2", "numpy", "typing"]
    )


def test_every_promised_name_is_its_homes_own():
    homes = seen_by_type_checkers()
    assert sorted(homes) == sorted(kogao.__all__)
    assert set(homes) <= set(dir(kogao))
    for name, (module, attribute) in homes.items():
        assert getattr(kogao, name) is getattr(sys.modules[module], attribute)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'kogao_core' has no attribute 'squeeze'"):
        _ = kogao.squeeze


def test_type_checkers_are_told_that_the_package_is_typed():
    assert HOME.with_name("py.typed").is_file()


@pytest.mark.parametrize(("dtype", "channels"), [(np.uint8, 4), (np.uint16, 1), (np.float32, 3)])
def test_a_notebook_shows_a_rendering(dtype, channels):
    photo = textured_photo(480, 360, channels, dtype)
    rendering = kogao.render(photo, [oval_face()], kogao.Recipe(percent=6))
    shown = cv2.imdecode(np.frombuffer(rendering._repr_png_(), np.uint8), cv2.IMREAD_COLOR_RGB)
    most = 1.0 if dtype is np.float32 else np.iinfo(dtype).max
    result = np.clip(rendering.pixels.reshape(360, 480, channels)[..., :3] / most, 0.0, 1.0)
    assert np.abs(shown - 255.0 * result).max() <= 1.0


def test_a_notebook_shows_a_photo():
    photo = kogao.read(kogao.sample())
    shown = cv2.imdecode(np.frombuffer(photo._repr_png_(), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert (shown == photo.pixels).all()


def test_a_large_rendering_is_shown_reduced():
    rendering = kogao.render(textured_photo(2500, 900), [], kogao.Recipe())
    shown = cv2.imdecode(np.frombuffer(rendering._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (369, 1024, 3)


PHOTO = textured_photo(480, 360)
FACE = oval_face()
FIELD = kogao.render(PHOTO, [FACE], kogao.PAPER).field
SAMPLE = kogao.sample()


def drawn(photo=PHOTO, faces=(FACE,), recipe=kogao.PAPER, **more):
    return lambda: kogao.render(photo, faces, recipe, **more)


WRONG = {
    "image of Pillow": (drawn(Image.fromarray(PHOTO)), r"got Image; .* numpy.asarray\(image\)"),
    "path": (drawn("a.jpg"), "numpy array, got str"),
    "Photo": (
        lambda: kogao.write(kogao.read(SAMPLE), kogao.read(SAMPLE), "x.png"),
        "pass photo.pixels of a Photo",
    ),
    "float64": (drawn(PHOTO / 255.0), r"\.astype\(numpy.float32"),
    "empty": (drawn(PHOTO[:0]), "at least one pixel"),
    "channels": (drawn(np.zeros((9, 9, 5), np.uint8)), r"shape \(H, W\)"),
    "dict": (drawn(recipe={"percent": 4}), r"expected a Recipe such as kogao.Recipe\(\), got dict"),
    "one face": (drawn(faces=FACE), r"sequence of Face, such as \[face"),
    "face as an array": (drawn(faces=[FACE.outline]), "sequence of Face"),
    "protection as a list": (drawn(protection=[(1, 2)]), "expected a Protection"),
    "brushwork as a text": (drawn(brushwork="x"), "expected a Brushwork"),
    "unknown brush": (
        lambda: kogao.Brushwork().with_stroke("pull", [(1, 2)], 20),
        "one of push, restore",
    ),
    "a list": (lambda: kogao.measures([FACE]), "expected a Face from kogao.find, got list"),
    "shown by a rendering": (
        lambda: kogao.shown_at(drawn()(), [(1, 2)]),
        "expected a Field such as rendering.field, got Rendering",
    ),
    "one shown point": (lambda: kogao.shown_at(FIELD, (3.0, 4.0)), r"shape \(N, 2\), got \(2,\)"),
    "project as a text": (
        lambda: kogao.apply_project("a.kogao.json", PHOTO),
        "expected a Project from kogao.load_project, got str",
    ),
    "gain map of pixels": (
        lambda: kogao.accompanied(PHOTO, lambda picture: picture),
        "expected a Photo from kogao.read",
    ),
    "target of one number": (lambda: FACE.with_target(0, 5), r"must be a point \(x, y\)"),
    "one point": (lambda: FIELD.at((3.0, 4.0)), r"shape \(N, 2\), got \(2,\)"),
    "points of a volume": (lambda: FIELD.at(np.zeros((4, 3))), r"shape \(N, 2\), got \(4, 3\)"),
    "picture of Pillow": (
        lambda: drawn()().warped(Image.fromarray(PHOTO)),
        "numpy array, got Image",
    ),
    "search in a path": (lambda: kogao.find("a.jpg"), "numpy array, got str"),
    "search in nothing": (lambda: kogao.find(PHOTO[:0]), "at least one pixel"),
    "search in float64": (lambda: kogao.find(PHOTO / 255.0), "must be uint8"),
    "unknown source": (lambda: kogao.source("model"), "use one of mesh, aam, chin"),
    "outline": (lambda: kogao.Face([1.0], FACE.eyes, FACE.mouth), r"points of shape \(N, 2\)"),
    "template in a volume": (lambda: kogao.template_face((1, 2, 3), 10.0), r"a point \(x, y\)"),
    "write without a Photo": (lambda: kogao.write(PHOTO, PHOTO, "x.png"), "expected a Photo"),
    "write a list": (lambda: kogao.write(kogao.read(SAMPLE), [1], "x.png"), "array, got list"),
    "evidence of a text": (lambda: kogao.load_evidence(__file__), "is not an evidence file"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_call_is_answered_by_a_sentence(name):
    call, words = WRONG[name]
    with pytest.raises((TypeError, ValueError), match=words) as refused:
        call()
    assert "\n" not in str(refused.value)


def test_the_reference_page_is_made_from_the_docstrings():
    folder = HOME.parents[1] / "docs"
    spec = importlib.util.spec_from_file_location("reference", folder / "reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (folder / "api.md").read_text(encoding="utf-8")
    assert page == module.page(), "run python docs/reference.py"
    for name in kogao.__all__:
        assert f"\n## `{name}" in page
