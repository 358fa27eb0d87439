"""Close a photo and open it again: every declared field of its edits returns, in any program."""

import dataclasses

import numpy as np
import pytest
from kogao_app.document import Document, State, UndoSteps
from kogao_app.render.colour import pyramid_of
from PIL import Image
from PIL.ExifTags import Base as Tag
from scenes import oval_face, textured_photo

from kogao_core.additions.brush import BrushStroke, Brushwork
from kogao_core.cli.commands import run
from kogao_core.field.protection import Protection, Stroke
from kogao_core.photo import read
from kogao_core.photo.optics import UNKNOWN
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import Sheet
from kogao_core.recipe.recipe import SETTINGS, Recipe

FOCAL_MM = 26
# Values that make a visible difference without folding the picture; every other field of a recipe
# takes another value by its declaration.
CHOSEN = {
    "percent": 2.5,
    "lattice": 1.3,
    "threshold_px": 0.25,
    "lens": "auto",
    "guard": True,
    "center": 3,
    "domain": "threshold",
}
# Fields that keep their default here: switched off, they would hide other fields.
ON = {"guard", "domain"}


@pytest.fixture
def wide(tmp_path):
    """A photo whose EXIF data contains a focal length of 26 mm."""
    exif, path = Image.Exif(), tmp_path / "in" / "wide.jpg"
    path.parent.mkdir()
    exif.get_ifd(Tag.ExifOffset)[Tag.FocalLengthIn35mmFilm] = FOCAL_MM
    Image.fromarray(textured_photo()).save(path, exif=exif, quality=95)
    return path


def other_recipe(shift=0.0):
    """Return a recipe in which no field but those of `ON` has its default."""
    values = {}
    for name, setting in SETTINGS.items():
        default = getattr(Recipe(), name)
        if name in CHOSEN:
            values[name] = CHOSEN[name]
        elif setting.alternatives:
            names = [one.name for one in setting.alternatives]
            values[name] = next(one for one in names if one != default)
        elif setting.within is None:
            values[name] = not default
        else:
            low, high = setting.within
            step = 0.1 if low < 0 else 0.2 * (high - low)
            values[name] = default - step if default - step >= low else default + step
    values["percent"] += shift
    recipe = Recipe(**values)
    same = {name for name in SETTINGS if getattr(recipe, name) == getattr(Recipe(), name)}
    assert same == ON
    return recipe


def filled_state():
    """Return a state in which every declared field of its parts differs from its default."""
    first = oval_face(center=(310.0, 180.0), size=0.5, forehead=True)
    first = dataclasses.replace(
        first,
        score=0.8,
        pinned_anchor=first.anchor,
        source="mesh",
        recipe=other_recipe(0.5),
        confidence=np.linspace(0.3, 1.0, len(first.points)),
    ).with_target(10, (311.0, 256.0))
    faces = (first, oval_face(center=(90.0, 270.0), size=0.3))
    by_hand = (oval_face(center=(308.0, 182.0), size=0.5),)
    points, pressure = np.array([[280.0, 240.0], [290.0, 236.0]]), np.array([0.5, 1.0])
    stroke = BrushStroke("restore", points, 40.0, 0.7, 0.6, pressure)
    state = State(faces, frozenset({1}), other_recipe())
    return dataclasses.replace(
        state,
        kept=Sheet(by_hand, frozenset(), other_recipe(1.0)),
        protection=Protection((Stroke(np.array([[460.0, 20.0], [465.0, 340.0]]), 5.0),)),
        loose=(((10.0, 10.0), (300.0, 12.0)),),
        brushwork=Brushwork((stroke,)),
    )


def leaves(value, path=""):
    """Yield the path and value of every field, through dataclasses, sequences and arrays."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name), f"{path}.{field.name}")
    elif isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from leaves(item, f"{path}[{index}]")
    elif isinstance(value, np.ndarray):
        yield path, value.tobytes()
    else:
        yield path, value


def saved(driver, path):
    driver.save(path)
    return read(path).pixels


@pytest.fixture
def closed(start, wide, tmp_path):
    """The fields of a photo that was edited and closed, and the pixels of its saved copy."""
    driver = start(wide)
    document = driver.editor.document
    document.step(filled_state(), "Fill")
    document.step(dataclasses.replace(document.state, off=frozenset()), "Switch")
    document.undo.undo()
    driver.settle()
    assert document.state.optics is not UNKNOWN
    assert document.state.done.recipe.lens == FOCAL_MM
    made = dict(leaves(document.committed)), saved(driver, tmp_path / "first.png")
    driver.editor.close()
    return made


@pytest.mark.slow
def test_every_field_of_the_edits_returns_in_the_window(start, wide, closed, tmp_path):
    fields, pixels = closed
    again = start(wide)
    assert again.editor.document.undo.count() == 2
    assert dict(leaves(again.editor.document.committed)) == fields
    np.testing.assert_array_equal(saved(again, tmp_path / "again.png"), pixels)
    again.editor.history.redo()
    again.editor.history.undo()
    assert dict(leaves(again.editor.document.committed)) == fields


@pytest.mark.slow
@pytest.mark.usefixtures("in_process")
def test_both_commands_make_the_bytes_of_the_window(wide, closed, tmp_path):
    _, pixels = closed
    warped, folder = tmp_path / "warped.png", tmp_path / "out"
    for command in (
        ("warp", wide, "-o", warped, "--project", sidecar_of(wide)),
        ("batch", wide.parent, "-o", folder, "--projects", "--to", "png"),
    ):
        assert run([str(word) for word in command]) == 0
    np.testing.assert_array_equal(read(warped).pixels, pixels)
    np.testing.assert_array_equal(read(folder / "wide.png").pixels, pixels)


def test_restored_work_and_undo_steps_get_the_lens_data_of_the_photo(wide):
    document, photo = Document(), read(wide)
    document.open(photo, pyramid_of(photo))
    # Recovery files and undo files contain no lens data, like this state.
    state = filled_state()
    document.step(state, "Restore")
    restored = [document.state]
    steps = UndoSteps((state, State(recipe=state.recipe), state), ("Fill", "Fill"), 1)
    document.begin_with(state, steps)
    restored += [document.state, *document.steps.states]
    for one in restored:
        assert (one.optics.focal_mm, one.image.width) == (FOCAL_MM, 480)
    document.close()
