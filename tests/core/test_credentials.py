"""Content credentials: seen, named where they go, and signed anew, as C2PA's own reader finds."""

import hashlib
import re
import struct
import sys

import files
import metadata_cases
import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo
from signers import Person, dsa, ec, ed25519, key_pem, rsa, self_signed

from kogao_core import photo
from kogao_core.photo import CannotDisclose, CannotWrite, originals
from kogao_core.photo.disclosure.credentials import PASSWORD, Signer, check_signer
from kogao_core.photo.disclosure.disclosing import Disclosure, disclose, signing, undisclosed
from kogao_core.photo.errors import MissingExtra
from kogao_core.photo.metadata import kinds

WRITTEN = [".jpg", ".png", ".tif", ".webp"]


@pytest.fixture(scope="module")
def person(tmp_path_factory):
    return Person(tmp_path_factory.mktemp("person"))


@pytest.fixture
def signer(person):
    return Signer(person.certificate, person.key_file)


@pytest.fixture
def path(tmp_path):
    """A small photo."""
    (tmp_path / "in.png").write_bytes(files.png(textured_photo(64, 48)))
    return tmp_path / "in.png"


def smaller(source):
    pixels = source.pixels.copy()
    pixels[5:20, 9:30] = pixels.max() - pixels[5:20, 9:30]
    return pixels


def written(source, path, signer, pixels=None):
    pixels = smaller(source) if pixels is None else pixels
    told = Disclosure(signer=signer)
    sign = signing(told, "one face made smaller")
    return photo.write(*disclose(source, pixels, told), path, sign=sign)


def actions(manifest):
    (found,) = (one for one in manifest["assertions"] if one["label"].startswith("c2pa.actions"))
    return found["data"]["actions"]


@pytest.mark.parametrize("suffix", WRITTEN)
def test_a_result_names_its_source_and_what_was_done_to_it(tmp_path, person, signer, suffix):
    path = tmp_path / f"in{suffix}"
    path.write_bytes(files.MAKERS[suffix](textured_photo(160, 120)))
    note = written(photo.read(path), tmp_path / f"out{suffix}", signer)
    assert note.endswith("signed, with the photo as its source")
    state, manifest, whole = person.told(tmp_path / f"out{suffix}")
    assert state == "Trusted"
    opened, edited = actions(manifest)
    assert (opened["action"], edited["action"]) == ("c2pa.opened", "c2pa.edited")
    assert edited["description"] == "one face made smaller"
    assert edited["digitalSourceType"].endswith("/humanEdits")
    assert edited["softwareAgent"]["name"] == "Kogao"
    (source,) = manifest["ingredients"]
    assert source["relationship"] == "parentOf"
    assert source["description"] == f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"
    assert manifest["signature_info"]["common_name"] == "Photographer"
    assert "thumbnail" not in str(whole), "it would show the face as it was"


@pytest.mark.parametrize("suffix", WRITTEN)
def test_signing_adds_to_a_file_and_changes_nothing_in_it(tmp_path, signer, suffix):
    path, plain, told = (tmp_path / f"{name}{suffix}" for name in ("in", "plain", "told"))
    path.write_bytes(files.MAKERS[suffix](textured_photo(160, 120)))
    source = photo.read(path)
    written(source, plain, None)
    written(source, told, signer)
    if suffix == ".jpg":
        rest, at = bytearray(), 0
        data = told.read_bytes()
        for found in re.finditer(rb"\xff\xeb(..)JP", data, re.DOTALL):
            rest += data[at : found.start()]
            at = found.start() + 2 + int.from_bytes(found[1], "big")
        assert bytes(rest + data[at:]) == plain.read_bytes()
    one, other = photo.read(plain), photo.read(told)
    np.testing.assert_array_equal(one.pixels, other.pixels)
    for name in ("icc_profile", "exif", "xmp", "photoshop", "dpi", "carried", "tiff_compression"):
        assert getattr(one, name) == getattr(other, name), name
    assert {one.kind for one in other.extras} - {one.kind for one in one.extras} == {
        kinds.CREDENTIALS
    }


def signed_elsewhere(folder, person, suffix):
    """Return a photo whose file already carries somebody's credentials."""
    pytest.importorskip({".heic": "pi_heif", ".dng": "rawpy"}.get(suffix, "PIL"))
    path = folder / f"in{suffix}"
    more = {".heic": files.heic, ".dng": lambda _: files.dng()}
    path.write_bytes((files.MAKERS | more)[suffix](textured_photo(160, 120)))
    person.sign(path)
    return photo.read(path, bits=8)


@pytest.mark.parametrize("suffix", [*WRITTEN, ".heic", ".dng"])
def test_credentials_of_other_programs_are_seen_and_named(tmp_path, person, suffix):
    source = signed_elsewhere(tmp_path, person, suffix)
    assert kinds.CREDENTIALS in [one.kind for one in source.extras]
    note = written(source, tmp_path / "out.jpg", None)
    assert "content credentials (C2PA)" in note
    assert b"c2pa" not in (tmp_path / "out.jpg").read_bytes()


@pytest.mark.parametrize("suffix", [*WRITTEN, ".heic", ".dng"])
def test_a_source_s_own_credentials_go_into_the_new_ones(tmp_path, person, signer, suffix):
    source = signed_elsewhere(tmp_path, person, suffix)
    note = written(source, tmp_path / "out.jpg", signer)
    assert "content credentials" not in note
    state, manifest, whole = person.told(tmp_path / "out.jpg")
    assert (state, len(whole["manifests"])) == ("Trusted", 2)
    first = whole["manifests"][manifest["ingredients"][0]["active_manifest"]]
    assert actions(first)[0]["digitalSourceType"].endswith("/digitalCapture")


def test_a_link_to_credentials_goes_and_is_named_signed_or_not(tmp_path, signer):
    path = tmp_path / "in.jpg"
    path.write_bytes(
        metadata_cases.jpeg(xmp=metadata_cases.packet('dcterms:provenance="https://e.org/x"'))
    )
    for hand in (None, signer):
        note = written(photo.read(path), tmp_path / "out.jpg", hand)
        assert "not kept: a link to content credentials (C2PA)" in note
        assert b"dcterms:provenance" not in (tmp_path / "out.jpg").read_bytes()
        (tmp_path / "out.jpg").unlink()


def test_credentials_that_were_broken_before_are_no_trouble(tmp_path, person, signer):
    path = tmp_path / "in.jpg"
    Image.fromarray(textured_photo(160, 120)).save(path)
    person.sign(path)
    data = bytearray(path.read_bytes())
    data[-100] ^= 1
    path.write_bytes(data)
    written(photo.read(path), tmp_path / "out.jpg", signer)
    assert person.told(tmp_path / "out.jpg")[0] in ("Trusted", "Valid")


def test_what_didnt_change_is_copied_unsigned_and_that_is_said(tmp_path, path, signer):
    source = photo.read(path)
    assert written(source, tmp_path / "out.png", signer, source.pixels) == ""
    assert (tmp_path / "out.png").read_bytes() == path.read_bytes()
    said = undisclosed(source, source.pixels, Disclosure(signer=signer))
    assert said == "nothing was changed, so there is no signature"


def test_a_photo_written_in_place_is_signed_from_its_original(tmp_path, person, signer):
    path = tmp_path / "in.jpg"
    Image.fromarray(textured_photo(160, 120)).save(path)
    first = path.read_bytes()
    source, store = photo.read(path), originals.Originals(tmp_path / "store")
    for shade in (0, 99):
        pixels = source.pixels.copy()
        pixels[:8, :8] = shade
        told = Disclosure(signer=signer)
        photo.write_in_place(source, pixels, store, sign=signing(told, "one face"))
        state, manifest, _ = person.told(path)
        assert state == "Trusted"
        digest = hashlib.sha256(first).hexdigest()
        assert manifest["ingredients"][0]["description"] == f"SHA-256 {digest}"
    assert store.restore(path)
    assert path.read_bytes() == first


def test_a_photo_that_others_have_changed_since_is_no_source(tmp_path, path, signer):
    source = photo.read(path)
    path.write_bytes(path.read_bytes() + b"x")
    with pytest.raises(CannotWrite, match="has changed since it was read; open it again"):
        written(source, tmp_path / "out.png", signer)
    assert not (tmp_path / "out.png").exists()


def test_a_protected_key_takes_its_password_from_the_environment(
    tmp_path, path, person, signer, monkeypatch
):
    (tmp_path / "key.pem").write_bytes(key_pem(person.key, b"secret"))
    mine = Signer(signer.certificate, str(tmp_path / "key.pem"))
    with pytest.raises(CannotDisclose, match=f"protected by a password; put it into .*{PASSWORD}"):
        check_signer(mine)
    monkeypatch.setenv(PASSWORD, "wrong")
    with pytest.raises(CannotDisclose, match="its password is another"):
        check_signer(mine)
    monkeypatch.setenv(PASSWORD, "secret")
    check_signer(mine)
    check_signer(signer)
    written(photo.read(path), tmp_path / "out.png", mine)
    assert person.told(tmp_path / "out.png")[0] == "Trusted"


def test_who_cannot_sign_is_told_why(tmp_path, signer):
    other, late = Person(tmp_path / "other"), Person(tmp_path / "late", days=(-9, -2))
    old = Person(tmp_path / "dsa", key=dsa.generate_private_key(2048))
    (tmp_path / "text").write_text("nothing")
    for mine, words in (
        (Signer("none.pem", signer.key), "none.pem can't be read .No such file"),
        (Signer(signer.certificate, "none.pem"), "none.pem can't be read"),
        (Signer(str(tmp_path / "text"), signer.key), "holds no certificate; name a PEM file"),
        (Signer(signer.certificate, str(tmp_path / "text")), "holds no private key"),
        (Signer(signer.certificate, other.key_file), "isn't that of the first certificate"),
        (Signer(late.certificate, late.key_file), "is valid from .* only; ask for a new one"),
        (Signer(old.certificate, old.key_file), "of a kind that C2PA doesn't know"),
    ):
        with pytest.raises(CannotDisclose, match=words) as refused:
            check_signer(mine)
        assert "\n" not in str(refused.value)


def test_a_certificate_that_c2pa_refuses_leaves_no_file(tmp_path, path, person):
    itself = Signer(str(tmp_path / "self.pem"), person.key_file)
    (tmp_path / "self.pem").write_bytes(self_signed(person.key))
    with pytest.raises(CannotDisclose, match=r"the result can't be signed .*self-signed"):
        written(photo.read(path), tmp_path / "out.png", itself)
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("make", [ec.SECP384R1, ec.SECP521R1, "ed25519", "rsa"])
def test_keys_of_all_kinds_sign(tmp_path, path, make):
    key = {
        "ed25519": ed25519.Ed25519PrivateKey.generate,
        "rsa": lambda: rsa.generate_private_key(65537, 2048),
    }.get(make, lambda: ec.generate_private_key(make()))()
    person = Person(tmp_path / "person", key=key)
    written(photo.read(path), tmp_path / "out.png", Signer(person.certificate, person.key_file))
    assert person.told(tmp_path / "out.png")[0] == "Trusted"


def test_without_the_extra_it_says_how_to_get_it(signer, monkeypatch):
    monkeypatch.setitem(sys.modules, "c2pa", None)
    with pytest.raises(MissingExtra, match=r"pip install .*\[credentials\]"):
        check_signer(signer)


def test_what_goes_along_is_still_found_where_the_index_says(tmp_path, person, signer):
    """Signing puts a segment between the picture and its gain map."""
    more = metadata_cases.gain_map(metadata_cases.packet('hdrgm:Version="1.0"'))
    (tmp_path / "in.jpg").write_bytes(files.jpeg(textured_photo(160, 120)) + more)
    source = photo.read(tmp_path / "in.jpg")
    along = photo.accompanied(source, lambda picture: 255 - picture)
    written(along, tmp_path / "out.jpg", signer)
    data = (tmp_path / "out.jpg").read_bytes()
    at = data.index(b"MPF\0") + 4
    (first, _), (length, offset) = (struct.unpack_from(">II", data, at + n) for n in (54, 70))
    assert data[first - 2 : first + 3] == b"\xff\xd9\xff\xd8\xff"
    assert at + offset == first
    assert first + length == len(data)
    assert person.told(tmp_path / "out.jpg")[0] == "Trusted"
