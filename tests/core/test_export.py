"""A result as another program wants it: smaller, in sRGB, by another name, without metadata."""

import dataclasses
import io
from pathlib import Path

import files
import numpy as np
import pytest
from colours import profile
from PIL import Image as Pillow
from PIL import ImageCms
from scenes import oval_face, textured_photo

from kogao_core import photo as photos
from kogao_core.base.geometry import Box
from kogao_core.cli import ending
from kogao_core.cli.commands import run
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.model import Photo
from kogao_core.pipeline import render
from kogao_core.recipe.export import EXPORT_SETTINGS
from kogao_core.recipe.recipe import Recipe
from kogao_core.resample.canvas import size_of

FACE = oval_face(center=(239.5, 190.0), size=0.5, forehead=True)
STRONG = Recipe(percent=8)


def waves(x, y):
    """A picture without edges, known at every place: 40 px a wave and more."""
    return 128 + 50 * np.sin(x / 7.0 + 0.3) + 40 * np.cos(y / 9.0) + 20 * np.sin((x + y) / 11.0)


def known(width=480, height=360):
    y, x = np.mgrid[:height, :width].astype(float)
    return waves(x, y).astype(np.float32)


def wanted(field, image, size):
    """The mean of the warped waves over each pixel of a smaller picture, from their formula."""
    width, height = size
    fine = 6
    xs = (np.arange(width * fine) + 0.5) / fine * image.width / width - 0.5
    ys = (np.arange(height * fine) + 0.5) / fine * image.height / height - 0.5
    moved = field.on_grid(xs, ys)
    values = waves(xs + moved[0], ys[:, None] + moved[1])
    return values.reshape(height, fine, width, fine).mean(axis=(1, 3))


@pytest.mark.parametrize("longest", [170, 401])
def test_a_reduced_result_is_the_warp_seen_by_larger_pixels(longest):
    made = render(known(), [FACE], STRONG, longest_px=longest)
    size = size_of(Box.of(known()), longest)
    assert made.pixels.shape == size[::-1]
    inside = slice(4, -4), slice(4, -4)  # at the edge the photo is repeated, the waves go on
    off = made.pixels - wanted(made.field, Box.of(known()), size)
    assert np.abs(off[inside]).max() < 1.0  # half a px beside it would be 5
    assert np.sqrt((off[inside] ** 2).mean()) < 0.3


def test_nothing_that_moves_is_nothing_but_smaller():
    picture = textured_photo(480, 360)
    made = render(picture, [FACE], Recipe(percent=0), longest_px=240)
    mean = picture.reshape(180, 2, 240, 2, -1).mean(axis=(1, 3)).reshape(made.pixels.shape)
    assert np.abs(made.pixels - mean).max() <= 0.5


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [(), (1,), (2,), (4,)])
def test_any_depth_and_layout_is_reduced_the_same_by_any_number_of_threads(kind, channels):
    rng = np.random.default_rng(1)
    most = 1 if kind is np.float32 else np.iinfo(kind).max
    picture = (rng.random((350, 450, *channels)) * most).astype(kind)
    faces = [oval_face(center=(225, 150), size=0.45)]
    one, many = (
        render(picture, faces, STRONG, longest_px=167, threads=threads).pixels for threads in (1, 4)
    )
    assert (one.dtype, one.shape) == (kind, (130, 167, *channels))
    assert one.tobytes() == many.tobytes()


@pytest.mark.parametrize("longest", [0, 480, 9000])
def test_a_photo_is_never_enlarged(longest):
    same = render(textured_photo(480, 360), [FACE], STRONG).pixels
    made = render(textured_photo(480, 360), [FACE], STRONG, longest_px=longest).pixels
    assert made.tobytes() == same.tobytes()


# -- colours, sharpness, metadata ------------------------------------------------------------------


def chart(dtype=np.uint8, icc="Display P3"):
    levels = np.linspace(0, 255, 9).round().astype(np.uint8)
    rgb = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(9, 81, 3)
    pixels = rgb if dtype == np.uint8 else rgb.astype(np.uint16) * 257
    return Photo(pixels, Path("chart.png"), "PNG", icc_profile=profile(icc) if icc else None)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_srgb_is_what_colour_management_makes_of_it(dtype):
    photo = chart(dtype)
    told, pixels = Export(srgb=True).applied(photo, photo.pixels)
    assert pixels.dtype == np.uint8
    name = ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(told.icc_profile)))
    assert "sRGB" in name
    middle = ImageCms.profileToProfile(
        Pillow.fromarray(chart().pixels),
        ImageCms.ImageCmsProfile(io.BytesIO(photo.icc_profile)),
        ImageCms.createProfile("sRGB"),
        ImageCms.Intent.RELATIVE_COLORIMETRIC,
    )
    assert np.abs(pixels.astype(int) - np.asarray(middle)).max() <= 1
    assert np.abs(pixels.astype(int) - chart().pixels).max() > 20


def test_a_profile_that_nobody_can_follow_is_kept_and_said():
    photo = dataclasses.replace(chart(), icc_profile=b"nonsense")
    told, pixels = Export(srgb=True).applied(photo, photo.pixels)
    assert (told.icc_profile, pixels.tobytes()) == (b"nonsense", photo.pixels.tobytes())
    assert "can't be followed" in told.notes[-1]


def test_transparency_stays_beside_srgb_and_sharpness():
    alpha = np.arange(9 * 81, dtype=np.uint8).reshape(9, 81)
    photo = dataclasses.replace(chart(), pixels=np.dstack([chart().pixels, alpha]))
    _, pixels = Export(srgb=True).applied(photo, photo.pixels)
    assert (pixels[..., 3] == alpha).all()
    small = photo.pixels[:, :40]
    _, sharp = Export(longest_px=40, sharpen=100).applied(photo, small)
    assert (sharp[..., 3] == small[..., 3]).all()
    assert (sharp != small).any()


def test_sharpening_is_of_what_was_reduced():
    photo = chart(icc=None)
    _, whole = Export(sharpen=100).applied(photo, photo.pixels)
    assert whole is photo.pixels


def read_back(path):
    with Pillow.open(path) as image:
        image.load()
        return image


@pytest.fixture
def camera(tmp_path):
    path = tmp_path / "camera.jpg"
    path.write_bytes(files.jpeg(textured_photo(160, 120)))
    return photos.read(path)


def test_metadata_are_left_out_where_nobody_wants_them(camera, tmp_path):
    assert camera.exif
    assert camera.xmp
    for name, metadata in (("with.jpg", True), ("without.jpg", False)):
        told, pixels = Export(metadata=metadata, quality=90).applied(camera, camera.pixels)
        photos.write(told, pixels, tmp_path / name, quality=90)
    seen = {name: read_back(tmp_path / name) for name in ("with.jpg", "without.jpg")}
    assert {"exif", "xmp"} <= seen["with.jpg"].info.keys()
    assert not {"exif", "xmp", "photoshop", "comment"} & seen["without.jpg"].info.keys()
    assert seen["without.jpg"].info["icc_profile"] == camera.icc_profile


@pytest.mark.parametrize("metadata", [True, False])
def test_a_photo_that_lay_on_its_side_is_exported_upright(tmp_path, metadata):
    path = tmp_path / "camera.jpg"
    path.write_bytes(files.jpeg(textured_photo(160, 120), orientation=6))
    lying = photos.read(path)
    told, pixels = Export(quality=90, metadata=metadata).applied(lying, lying.pixels)
    photos.write(told, pixels, tmp_path / "out.jpg", quality=90)
    again = photos.read(tmp_path / "out.jpg")
    assert (again.orientation, again.pixels.shape) == (1, lying.pixels.shape)
    assert np.abs(again.pixels.astype(int) - lying.pixels).mean() < 8


@pytest.mark.parametrize("quality", [60, 90])
def test_a_quality_is_that_of_the_file(camera, tmp_path, quality):
    photos.write(camera, camera.pixels, tmp_path / "out.jpg", quality=quality)
    Pillow.new("RGB", (16, 16)).save(tmp_path / "like.jpg", quality=quality)
    made, like = read_back(tmp_path / "out.jpg"), read_back(tmp_path / "like.jpg")
    assert made.quantization == like.quantization


def test_what_keeps_no_byte_of_the_source_says_so_by_its_coding():
    assert AS_IT_IS.coding is None
    assert Export(name="{n}", ending=".png", first=12).coding is None


@pytest.mark.parametrize("name", sorted(EXPORT_SETTINGS.keys() - {"name", "ending", "first"}))
def test_every_other_option_takes_a_new_coding_and_is_refused_in_place(name, tmp_path, capsys):
    """Without a line of its own here, so that a new option is held to it, too."""
    default, setting = getattr(AS_IT_IS, name), EXPORT_SETTINGS[name]
    value = not default if isinstance(default, bool) else type(default)(setting.most)
    assert Export(**{name: value}).coding is not None
    if setting.option:
        given = [] if isinstance(default, bool) else [str(value)]
        needed = [setting.needs, "100"] if setting.needs else []
        photo = tmp_path / "a.jpg"
        Pillow.new("RGB", (16, 16)).save(photo)
        arguments = ["warp", str(photo), "--in-place", setting.option, *given, *needed]
        assert run(arguments) == ending.USAGE
        assert "can't be combined with --in-place" in capsys.readouterr().err


def test_every_option_has_a_row_of_the_dialog_by_its_name():
    """Of a type that the dialog has a control for; otherwise the dialog can't be built."""
    assert set(EXPORT_SETTINGS) == {field.name for field in dataclasses.fields(Export)}
    for name, setting in EXPORT_SETTINGS.items():
        default = getattr(AS_IT_IS, name)
        assert isinstance(default, (bool, int, float, str)), name
        assert setting.title, name
        assert setting.most > 0 or isinstance(default, (bool, str)), name
        assert bool(setting.help) == bool(setting.option), name


def test_16_bits_become_8_where_a_format_holds_no_more(tmp_path):
    photo = chart(np.uint16)
    with pytest.raises(photos.RefusedOutput):
        photos.write(photo, photo.pixels, tmp_path / "out.jpg")
    photos.write(photo, photo.pixels, tmp_path / "out.jpg", quality=95)
    photos.write(photo, photo.pixels, tmp_path / "out.tif", quality=95)
    assert [photos.read(tmp_path / f"out.{end}").bits for end in ("jpg", "tif")] == [8, 16]


# -- names -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("export", "source", "name"),
    [
        (Export(), "a.JPG", "a.JPG"),
        (Export(), "a.heic", "a.heic.jpg"),
        (Export(ending=".png"), "a.jpg", "a.png"),
        (Export(name="{name}_{amount}"), "a.b.jpg", "a.b_4.5.jpg"),
        (Export(name="wedding-{n}", ending=".webp"), "a.tif", "wedding-007.webp"),
        (Export(name="{n}"), "a.nef", "007.jpg"),
    ],
)
def test_a_name_is_made_of_the_photos_a_number_and_the_amount(export, source, name):
    assert export.place(Path("deep") / source, 7, 4.5) == Path("deep") / name


@pytest.mark.parametrize(
    "wrong",
    [
        *({"name": ""}, {"name": "a/b"}, {"name": "{0}"}, {"name": "{date}"}, {"name": "a:b"}),
        *({"quality": 101}, {"longest_px": -1}, {"sharpen": 201}, {"ending": ".gif"}),
    ],
)
def test_what_makes_no_sense_is_refused(wrong):
    with pytest.raises(ValueError, match=r"."):
        Export(**wrong)


def test_numbers_start_anywhere_and_go_on_where_an_export_ended():
    photos = [Path(f"{one}.jpg") for one in "abcd"]
    export = Export(name="{name}_web_{n}", first=12)
    assert export.numbers(photos[:2], {}) == [12, 13]
    earlier = {"b.jpg": "out/b_web_012.jpg", "c.jpg": "out/c_web_013.jpg", "x.jpg": "out/x.jpg"}
    goes_on = Export(name="{name}_web_{n}")
    assert goes_on.numbers(photos, earlier) == [14, 12, 13, 15]
    assert Export(name="{n}").numbers(photos[:2], earlier) == [1, 2]
    assert Export(name="new_{n}").coding is None, "numbers change no pixels"
    assert Export(first=7).coding is None
