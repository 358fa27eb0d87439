"""The promised names: all there, each its home's own, and free until they are asked for."""

import ast
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
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
    program = [sys.executable, "-c", LOADED.format(then=then)]
    return subprocess.run(program, capture_output=True, text=True, check=True).stdout.strip()


def seen_by_type_checkers():
    """The promised names with the modules that `__init__` imports them from for type checkers."""
    tree = ast.parse(HOME.read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.asname or alias.name: (node.module, alias.name)
        for node in block.body
        if node.module != "typing"
        for alias in node.names
    }


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
