"""Names in a photo's metadata go to the faces that they mean, or to none."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from named import HEAD, head_of, microsoft, mwg

from kogao_core.faces.landmarks import template_face
from kogao_core.faces.names import (
    NO_FACE,
    NO_REGION,
    OUTDATED,
    SEVERAL,
    NobodyNamed,
    identify,
    names_of,
    people_of,
)
from kogao_core.photo.metadata.upright import Turn
from kogao_core.photo.model import Photo
from kogao_core.recipe.recipe import Recipe

SIZE = WIDTH, HEIGHT = 600, 400
ANN, KATE = (template_face((x, y), 120) for x, y in ((150, 180), (420, 230)))
BOTH = [ANN, KATE]


def stored(place, orientation):
    """Return a place of the upright photo in the stored photo."""
    back = {6: 8, 8: 6}.get(orientation, orientation)
    turn = Turn(back, 0, 0)
    return turn.place(place[0], (1.0, 1.0)), turn.sides(place[1])


def photo_with(content, orientation=1, size=(WIDTH, HEIGHT)):
    packet = HEAD.format(content).encode()
    pixels = np.zeros((size[1], size[0]), np.uint8)
    return Photo(pixels, Path("me.jpg"), "JPEG", xmp=packet, orientation=orientation)


NAMED = [("Ann", head_of(ANN, SIZE)), ("Kate", head_of(KATE, SIZE))]
NO_PACKETS = [
    b"",
    b"<x",
    b"<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>",
    HEAD.format(mwg([("", NAMED[0][1])], SIZE)).encode(),
    HEAD.format(mwg([("Ann", (("x", "nan"), ("1e999", "1")))], SIZE)).encode(),
]


@pytest.mark.parametrize("orientation", [1, 2, 3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("is_upright", [False, True])
@pytest.mark.parametrize("form", ["attributes", "elements", "microsoft", "both"])
def test_two_people_keep_their_names_in_every_form_and_orientation(form, orientation, is_upright):
    named, size = NAMED, (WIDTH, HEIGHT)
    if not is_upright:
        named = [(name, stored(place, orientation)) for name, place in NAMED]
        size = Turn(orientation, 0, 0).sides(size)
    content = microsoft(named) if form in ("microsoft", "both") else ""
    if form != "microsoft":
        content += mwg(named, size, as_elements=form == "elements")
    found = names_of(photo_with(content, orientation), BOTH)
    # One reading may fit as well as the other; then the names are doubted, never exchanged.
    if found.names != ("Ann", "Kate"):
        assert found.names == ("", "")
        assert set(found.doubts.values()) == {OUTDATED}
        assert orientation in (2, 3, 4) or form == "microsoft"
    assert names_of(photo_with(content, orientation), BOTH[::-1]).names == found.names[::-1]


def test_a_smaller_copy_keeps_its_names_and_a_crop_is_doubted():
    small = names_of(
        photo_with(mwg(NAMED, SIZE), size=(WIDTH // 2, HEIGHT // 2)),
        [dataclasses.replace(f, **halves(f)) for f in BOTH],
    )
    assert small.names == ("Ann", "Kate")
    # Ann's place lies on Kate's face, and nobody is where Kate was.
    shifted = [(name, (place[0] + (0.45, 0.1), place[1])) for name, place in NAMED]
    for size in ((WIDTH, HEIGHT - 100), (2 * WIDTH, 2 * HEIGHT)):
        cropped = names_of(photo_with(mwg(shifted, size)), BOTH)
        assert cropped.names == ("", "")
        assert set(cropped.doubts.values()) == {OUTDATED}
    alone = names_of(photo_with(mwg(NAMED[:1], (WIDTH, HEIGHT - 100))), BOTH)
    assert alone.index("ann") == OUTDATED


def halves(face):
    return {name: getattr(face, name) / 2.0 for name in ("outline", "eyes", "mouth")} | {
        "forehead": None
    }


def test_what_is_not_one_face_for_one_name_is_doubted():
    (middle, size), (other, _) = NAMED[0][1], NAMED[1][1]
    wide = ((middle + other) / 2, np.abs(middle - other) + 2 * size)
    assert names_of(photo_with(mwg([("Ann", wide)], SIZE)), BOTH).names == ("", "")
    twice = names_of(photo_with(mwg([("Ann", NAMED[0][1]), ("ann ", NAMED[1][1])], SIZE)), BOTH)
    assert twice.index("Ann") == SEVERAL
    one = names_of(photo_with(mwg([("Ann", NAMED[0][1]), ("Kate", NAMED[0][1])], SIZE)), BOTH)
    assert one.index("Ann") == one.index("Kate") == SEVERAL
    none = names_of(photo_with(mwg(NAMED, SIZE)), [KATE])
    assert (none.index("Ann"), none.index("KATE"), none.index("Eve")) == (NO_FACE, 0, NO_REGION)
    pet = names_of(photo_with(mwg(NAMED, SIZE, kind="Pet")), BOTH)
    assert pet.names == ("", "")


@pytest.mark.parametrize("packet", NO_PACKETS)
def test_damaged_or_empty_metadata_name_nobody(packet):
    photo = dataclasses.replace(photo_with(""), xmp=packet)
    assert names_of(photo, BOTH).names == ("", "")


def test_only_named_people_change_and_each_by_the_own_amount():
    people = people_of("kate=3, Ann=-2.5")
    faces, which, note = identify(people, photo_with(mwg(NAMED, SIZE)), BOTH, Recipe(percent=7))
    assert [face.recipe.percent for face in faces] == [-2.5, 3.0]
    assert (which, note) == ("2,1", "")
    faces, which, note = identify(
        people_of("Kate=3,Eve=1"), photo_with(mwg(NAMED, SIZE)), BOTH, Recipe()
    )
    assert (which, faces[0]) == ("2", ANN)
    assert note == f"person 2 of the named people: {NO_REGION}"
    with pytest.raises(NobodyNamed, match="person 1 of the named"):
        identify(people_of("Eve=1"), photo_with(mwg(NAMED, SIZE)), BOTH, Recipe())


def test_the_option_takes_names_with_commas_and_refuses_the_rest():
    assert people_of("Doe, Ann=3,Kate = 0") == (("Doe, Ann", 3.0), ("Kate", 0.0))
    for wrong in ("", "Ann", "Ann=", "=3", "Ann=3;Kate=0", "Ann=3,ann=4", "Ann=3,Kate"):
        assert people_of(wrong) == ()
