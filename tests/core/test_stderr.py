"""Decoders' complaints become notes; everything else still reaches standard error."""

import faulthandler
import os
import re
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from files import directory
from PIL import Image
from programs import ran
from scenes import textured_photo
from timeouts import LONGEST_S

from kogao_core import photo
from kogao_core.base.stderr import hushed
from kogao_core.photo.formats import colour

posix = pytest.mark.skipif(sys.platform == "win32", reason="closes a descriptor")
SAVING = """
    import sys
    from kogao_core import photo
    from kogao_core.base.stderr import open_standard_streams
    open_standard_streams()
    source = photo.read(sys.argv[1])
    pixels = source.pixels.copy()
    pixels[:8, :8] ^= 255
    photo.write(source, pixels, sys.argv[2], force=True)
"""
READING = """
    import sys
    from kogao_core import photo
    for path in sys.argv[1:]:
        try:
            photo.read(path)
        except photo.UnreadablePhoto as problem:
            print(problem)
"""


@pytest.fixture
def heard(monkeypatch, capfd):
    """Let standard error be kept, as pytest doesn't; return what comes there after all."""
    monkeypatch.setattr(faulthandler, "is_enabled", lambda: False)
    return lambda: capfd.readouterr().err


@pytest.fixture
def saved(heard):
    """Save a photo with a change; return what is told of it."""

    def run(source, target):
        heard()  # what was said of the source when it was made
        read = photo.read(source)
        pixels = read.pixels.copy()
        pixels[:8, :8] ^= 255
        told = [*read.notes, photo.write(read, pixels, target, force=True)]
        assert heard() == ""
        return " ".join(told)

    return run


@pytest.fixture
def damaged(tmp_path):
    """A JPEG with bytes too many before its end, which decoders skip with a word."""
    path = tmp_path / "in.jpg"
    Image.fromarray(textured_photo(80, 64, 3)).save(path, quality=95)
    path.write_bytes(path.read_bytes()[:-2] + bytes(300) + b"\xff\xd9")
    return path


def test_what_a_decoder_says_of_damage_becomes_a_note(damaged, tmp_path, saved):
    said = saved(damaged, tmp_path / "out.jpg")
    assert re.search("slightly damaged: 2[0-9]+ extraneous bytes before marker 0xd9", said)


@pytest.mark.parametrize("orientation", [1, 3])
def test_coarse_tables_are_written_without_a_word(tmp_path, saved, orientation):
    """Blocks are kept, of a photo that lies on its side, too."""
    tags = Image.Exif()
    tags[0x0112] = orientation
    picture = Image.fromarray(textured_photo(80, 64, 3))
    picture.save(tmp_path / "in.jpg", qtables=[[300] * 64] * 2, exif=tags)
    assert "turned" not in saved(tmp_path / "in.jpg", tmp_path / "out.jpg")


def test_libtiff_and_pillow_are_not_heard(tmp_path):
    paths = []
    for tag, value in (
        (259, 8),  # libtiff, by way of Pillow's decoder
        (65000, 1),  # instead of 273: libtiff, by itself
        (277, 30208),  # Pillow, which logs it
    ):
        tags = {
            256: (4, 40), 257: (4, 30), 258: (3, [8] * 3), 259: (3, 5), 262: (3, 2), 273: (4, 8),
            277: (3, 3), 278: (4, 30), 279: (4, 200),
        }  # fmt: skip
        if tag not in tags:
            del tags[273]
        tags[tag] = (3, value)
        head = b"II*\0" + (208).to_bytes(4, "little") + b"\xaa" * 200
        paths.append(tmp_path / f"{tag}.tif")
        paths[-1].write_bytes(head + directory(tags, 208))
    done = ran(READING, *paths)
    assert re.findall("damaged or incomplete|TIFF of a kind", done.stdout) == [
        *["damaged or incomplete"] * 2,
        "TIFF of a kind",
    ]
    assert done.stderr == ""


def test_what_others_say_meanwhile_is_passed_on(heard):
    with hushed() as said:
        os.write(2, b"Corrupt JPEG data: bad Huffman code\ntempfile.tif: Bad\nof others\n")
        os.write(2, b"our own\n")
        warnings.warn("of Pillow", stacklevel=1)
    with hushed() as again:
        os.write(2, b"unknown file: data corrupted at 9\n")
    os.write(2, b"after\n")
    assert (said, again) == (["bad Huffman code"], ["data corrupted at 9"])
    assert heard() == "of others\nour own\nafter\n"


@posix
def test_a_closed_standard_error_changes_no_byte(damaged, tmp_path, saved):
    saved(damaged, tmp_path / "out.jpg")
    ran(SAVING, damaged, tmp_path / "closed.jpg", preexec_fn=lambda: os.close(2))
    assert (tmp_path / "closed.jpg").read_bytes() == (tmp_path / "out.jpg").read_bytes()


@posix
def test_files_never_get_the_descriptor_of_a_standard_stream(tmp_path):
    done = ran(
        """
        import sys
        from kogao_core.base.stderr import open_standard_streams
        open_standard_streams()
        with open(sys.argv[1], "wb") as file:
            print(file.fileno() > 2)
        """,
        tmp_path / "file",
        preexec_fn=lambda: os.closerange(2, 3),
    )
    assert done.stdout.strip() == "True"


def test_opencv_stays_silent_while_any_thread_decodes_and_gets_its_level_back(monkeypatch):
    """Its level is one for all threads; here the first that came is the first to leave."""
    level, levels = cv2.utils.logging.getLogLevel(), []
    second_began, first_left = threading.Event(), threading.Event()

    def decode(data, _):
        if data[0] == 1:
            pool.submit(colour.decoded_deep, b"\2")
            assert second_began.wait(LONGEST_S)
        else:
            second_began.set()
            assert first_left.wait(LONGEST_S)
        levels.append(cv2.utils.logging.getLogLevel())
        return np.zeros((1, 1), np.uint16)

    monkeypatch.setattr(cv2, "imdecode", decode)
    with ThreadPoolExecutor(1) as pool:
        colour.decoded_deep(b"\1")
        first_left.set()
    assert levels == [cv2.utils.logging.LOG_LEVEL_SILENT] * 2
    assert cv2.utils.logging.getLogLevel() == level
