"""The choice of a source, and what holds for the mesh without any photograph of a face."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from inspect import signature
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from few_cases import few_of
from scenes import oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.base import assets
from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Affine
from kogao_core.base.threads import Stopped, default_threads, stoppable
from kogao_core.cli.commands import program
from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import CHOICES, Choice, MeshSource, search, sources
from kogao_core.faces.landmarks.aam.source import AamSource
from kogao_core.faces.landmarks.blazeface import BlazeFace, Detection, Look, Square
from kogao_core.faces.landmarks.pixels import Pyramid, sharpened


def ramp(rows: int, columns: int) -> np.ndarray:
    """An image whose red is its x and whose green is its y."""
    y, x = np.mgrid[:rows, :columns]
    return np.dstack([x, y, np.full_like(x, 50)]).astype(np.uint8)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 1), (5, 7, 2), (5, 7, 3), (5, 7, 4)])
def test_every_kind_of_pixel_becomes_8_bit_rgb(dtype: type, shape: tuple[int, ...]) -> None:
    scale = {np.uint8: 1, np.uint16: 257, np.float32: 1.0 / 255.0}[dtype]
    image = np.full(shape, 100 * scale, dtype)
    result = rgb8(image)
    assert (result.dtype, result.shape) == (np.uint8, (5, 7, 3))
    np.testing.assert_array_equal(result, 100)


def test_float_pixels_out_of_range_are_clipped() -> None:
    row = np.array([[-3.0, 0.0, 1.0, 9.0, np.nan, np.inf]], np.float32)
    np.testing.assert_array_equal(rgb8(row)[0, :, 0], [0, 0, 255, 255, 0, 255])


@pytest.mark.parametrize("shape", [(0, 4, 3), (4,), (4, 4, 5), (2, 3, 4, 3)])
def test_what_is_no_image_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="image"):
        rgb8(np.zeros(shape, np.uint8))
    with pytest.raises(ValueError, match="float64"):
        rgb8(np.zeros((4, 4)))  # type: ignore[arg-type]


@pytest.mark.parametrize("side", [40.0, 100.0, 190.0])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 180.0])
def test_a_view_samples_where_its_map_says(side: float, degrees: float) -> None:
    view = Square(np.array([120.0, 118.0]), side, degrees)
    image = np.clip(ramp(241, 237), 0, 255)
    sampled = Pyramid(image).sample(view.to_image, 256)
    points = np.array([(60.0, 70.0), (128.0, 127.0), (190.0, 170.0)])
    there = view.to_image(points)
    got = np.array([sampled[int(y), int(x), :2] for x, y in points])
    np.testing.assert_allclose(got, there, atol=0.75)


@pytest.mark.parametrize("shrink", [1.5, 2.0, 3.3, 8.0])
def test_shrinking_keeps_places_and_averages_noise(shrink: float) -> None:
    rng = np.random.default_rng(1)
    noise = rng.integers(0, 2, (512, 512), np.uint8) * 255
    to_image = Affine.resize(shrink, shrink)
    size = int(512 / shrink)
    sampled = Pyramid(noise).sample(to_image, size).astype(float)
    ideal = cv2.resize(noise, (size, size), interpolation=cv2.INTER_AREA).astype(float)
    inner = slice(2, size - 2)
    assert sampled[inner, inner].std() < 1.25 * ideal[inner, inner].std()
    y, x = np.mgrid[:512, :512] / 2.0
    gradient = Pyramid(np.dstack([x, y, x]).astype(np.uint8)).sample(to_image, size)
    centers = np.arange(size) * shrink + (shrink - 1.0) / 2.0
    np.testing.assert_allclose(gradient[size // 2, inner, 0], centers[inner] / 2.0, atol=1.3)


def test_what_is_sharp_stays_and_what_is_soft_gets_its_detail_back() -> None:
    crisp = textured_photo(256, 256)
    assert np.array_equal(sharpened(crisp), crisp)
    portrait = cv2.imread(str(assets.sample()))[..., ::-1]
    face = np.ascontiguousarray(cv2.resize(portrait[200:760, 170:730], (256, 256)))
    soft = np.asarray(cv2.GaussianBlur(face, (0, 0), 8.0))
    assert detail(soft) < 0.5 * detail(face) < detail(sharpened(soft))


def detail(picture: np.ndarray) -> float:
    fine = picture.astype(np.float32)
    return float((fine - cv2.GaussianBlur(fine, (0, 0), 6.0)).std())


def test_sources_wider_than_opencv_warps_are_sampled() -> None:
    wide = np.zeros((40, 40_000, 3), np.uint8)
    wide[:, 39_000:] = 200
    sampled = Pyramid(wide).sample(Square(np.array([39_500.0, 20.0]), 30.0).to_image, 256)
    np.testing.assert_array_equal(sampled, 200)
    assert not Pyramid(wide).sample(Square(np.array([-900.0, 20.0]), 30.0).to_image, 256).any()


def test_boxes_of_one_face_overlap_and_neighbours_do_not() -> None:
    face = Detection(np.array([100.0, 100.0]), 80.0, 0.0, 0.9)
    cut = Detection(np.array([115.0, 100.0]), 45.0, 0.0, 0.8)
    neighbour = Detection(np.array([170.0, 100.0]), 80.0, 0.0, 0.8)
    assert face.overlaps(face)
    assert face.overlaps(cut)
    assert cut.overlaps(face)
    assert not face.overlaps(neighbour)


@pytest.mark.parametrize("shape", [(3000, 4000), (4000, 3000), (1000, 1000), (500, 3000)])
@pytest.mark.parametrize("parts", sorted(search.OVERLAP))
def test_some_tile_holds_every_face_that_tiles_are_for(shape: tuple[int, int], parts: int) -> None:
    rows, columns = shape
    tiles = search._tiles(Pyramid(np.zeros(shape, np.uint8)), parts)
    corners = np.array([(*(tile.center_px - tile.side_px / 2.0), tile.side_px) for tile in tiles])
    side = search.OVERLAP[parts] * max(shape) / parts
    rng = np.random.default_rng(6)
    for low in rng.uniform(0.0, 1.0, (300, 2)) * (columns - side, rows - side):
        inside = (corners[:, :2] <= low + 1.0) & (
            corners[:, :2] + corners[:, 2:] >= low + side - 1.0
        )
        assert inside.all(axis=1).any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 9, 3), (3, 3, 4), (2, 500, 3), (17, 5)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_an_image_of_almost_nothing_has_no_face(
    source: MeshSource, shape: tuple[int, ...], dtype: type
) -> None:
    assert source.find(np.zeros(shape, dtype)) == []


@pytest.mark.parametrize("pattern", few_of(["stretched", "ramp", "white", "noise"], 1))
def test_patterns_have_no_face(source: MeshSource, pattern: str) -> None:
    noise = np.random.default_rng(2).integers(0, 256, (150, 200, 3), np.uint8)
    soft = cv2.GaussianBlur(noise, (0, 0), 5)
    patterns = {
        "noise": noise,
        "stretched": cv2.normalize(soft, None, 0, 255, cv2.NORM_MINMAX),
        "ramp": ramp(255, 255),
        "white": np.full((300, 300), 255, np.uint8),
    }
    assert source.find(patterns[pattern]) == []


@pytest.mark.parametrize(("share", "level", "looked"), [(0.17, 2, False), (0.5, 3, True)])
def test_a_view_of_a_bare_wall_needs_no_network(
    source: MeshSource, share: float, level: int, looked: bool
) -> None:
    """The levels spread by 0.75 and by 1.5 (standard deviation)."""
    wall = np.zeros((256, 256, 3), np.uint8)
    wall[:, : int(share * 256)] = level
    look = source._detector.look(Pyramid(wall), Square(np.array([127.5, 127.5]), 256.0), 0.5)
    assert (look.most > 0.0) is looked


def test_one_source_serves_several_threads(source: MeshSource) -> None:
    picture = np.random.default_rng(4).integers(0, 256, (48, 48, 3), np.uint8)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(source.find, [picture] * 4)) == [[]] * 4


@pytest.mark.usefixtures("weights")
def test_a_search_that_nobody_wants_any_more_ends_between_two_looks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks: list[object] = []

    def look(*given: object) -> Look:
        looks.append(given)
        return Look([], 1.0)

    monkeypatch.setattr(BlazeFace, "look", look)
    source = MeshSource()
    with pytest.raises(Stopped), stoppable(lambda: len(looks) >= 5):
        source.find(textured_photo())
    assert 5 <= len(looks) < 5 + default_threads()
    assert source.find(textured_photo()) == [], "the next search isn't stopped, nor kept waiting"


def test_faces_are_handed_on_while_the_search_goes_on(
    source: MeshSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks, heard = [], []
    look = BlazeFace.look

    def counted(*given: object) -> object:
        looks.append(given)
        return look(*given)

    monkeypatch.setattr(BlazeFace, "look", counted)
    portrait = cv2.imread(str(assets.sample()))[..., ::-1]
    wall = np.full((600, 900, 3), 120, np.uint8)
    for left in (100, 600):
        wall[200:400, left : left + 200] = cv2.resize(portrait, (200, 200))
    faces = source.find(wall, lambda face: heard.append((face, len(looks))))
    assert len(faces) == 2
    assert {face for face, _ in heard} == set(faces)
    assert heard[0][1] < len(looks), "there was more to look at"


def test_who_is_done_first_does_not_decide_what_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two proposals come to one face: the better one's counts."""
    monkeypatch.setattr(search, "default_threads", lambda: 2)
    better, worse = (Detection(np.array([x, 50.0]), 20.0, 0.0, x / 100.0) for x in (90.0, 60.0))
    same, done = Detection(np.array([75.0, 50.0]), 20.0, 0.0, 1.0), threading.Event()

    class Detector:
        def look(self, *_: object) -> Look:
            return Look([better, worse], better.score)

    def fit(box: Detection) -> search.Fitted:
        if box is worse:
            done.set()
        assert done.wait(LONGEST_S)
        return search.Fitted(oval_face(100, 100, size=box.score), same)

    (face,) = search.faces(Pyramid(np.zeros((100, 100, 3), np.uint8)), Detector(), fit)
    assert np.array_equal(face.points, oval_face(100, 100, size=better.score).points)


def test_a_missing_network_is_named_with_a_way_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = type(sys)("kogao_resources")
    package.__path__ = [str(tmp_path)]
    monkeypatch.setitem(sys.modules, "kogao_resources", package)
    with pytest.raises(assets.AssetMissing, match=r"--force-reinstall .*placed by hand"):
        MeshSource().find(np.zeros((64, 64, 3), np.uint8))


def test_a_checkout_that_is_not_installed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "kogao_resources", None)
    with pytest.raises(assets.AssetMissing, match=r"pip install -e \."):
        assets.path("models/face_detection_back.tflite")


def test_names_give_their_sources() -> None:
    assert isinstance(sources.source("mesh"), MeshSource)
    assert isinstance(sources.source("aam"), AamSource)
    measured = [choice.measured for choice in CHOICES if choice.measured is not None]
    assert all(0.0 < one.studio_jaw < one.wild_jaw < 10.0 for one in measured)


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.name)
def test_help_and_the_document_name_every_source(choice: Choice) -> None:
    said = CliRunner().invoke(program, ["detect", "--help"]).output
    assert choice.name in said[said.index("--landmarks [") :].split("]")[0]
    measured = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    assert choice.measured is None or f"\n| {choice.name} | " in measured


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.name)
def test_every_source_has_the_name_and_the_signature_of_a_source(choice: Choice) -> None:
    made = choice.make()
    assert made.name == choice.name
    assert signature(type(made).find) == signature(LandmarkSource.find)


def test_without_networks_the_aam_is_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "networks_are_here", lambda: False)
    assert isinstance(sources.source(), AamSource)
    monkeypatch.setattr(sources, "networks_are_here", lambda: True)
    assert isinstance(sources.source(), MeshSource)


def test_an_unknown_source_is_refused() -> None:
    with pytest.raises(ValueError, match="use one of mesh, aam, chin"):
        sources.source("model.yaml")
