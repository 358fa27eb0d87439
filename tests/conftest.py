"""What tests need beyond the repository: shared photographs and the networks' weights."""

from __future__ import annotations

import gettext
import importlib.util
import os
import shutil
import sys

# Workers of pytest-xdist share the processors out; NumPy and OpenCV look when they are loaded.
os.environ.setdefault(
    "OMP_NUM_THREADS",
    str(max(1, (os.cpu_count() or 1) // int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))),
)
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", os.environ["OMP_NUM_THREADS"])

# Tests read English, wherever they run.
os.environ["LANGUAGE"] = "en"
# Programs that they start are compiled once, as installed ones are.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image
from pseudolocale import PseudoTranslations

from kogao_core.base import assets, language
from kogao_core.batch import Workers

ROOT = Path(__file__).resolve().parents[1]


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark what needs the shared photographs; nobody has to think of it."""
    if "shared_data" in getattr(item, "fixturenames", ()):
        item.add_marker("data")


@pytest.fixture(autouse=True)
def own_data(
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """What the programs list and keep is a test's own, and nothing of the user's."""
    folder = tmp_path_factory.getbasetemp() / "data" / str(abs(hash(request.node.nodeid)))
    for name in ("XDG_DATA_HOME", "LOCALAPPDATA", *(["HOME"] if sys.platform == "darwin" else [])):
        monkeypatch.setenv(name, str(folder))


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of labelled photographs; they may not be copied into the repository."""
    folder = Path(os.environ.get("KOGAO_SHARED", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"the folder of test photographs is absent: {folder} (set KOGAO_SHARED)")
    return folder


@pytest.fixture(scope="session")
def weights() -> Path:
    """Folder of the network weights, fetched by the build hook."""
    try:
        assets.path("models/face_detection_back.tflite")
        return assets.path("models/face_landmarks_detector.tflite").parent
    except assets.AssetMissing as missing:
        pytest.skip(f"the network weights are absent: {missing}")


@pytest.fixture
def lack(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Let the files be missing whose names hold some letters, of those that come along."""
    found = assets.path

    def missing(letters: str) -> None:
        def path(name: str) -> Path:
            if letters in name:
                raise assets.AssetMissing(f"{name} is missing; reinstall")
            return found(name)

        monkeypatch.setattr(assets, "path", path)

    return missing


@pytest.fixture(scope="session")
def portrait(weights: Path) -> Path:
    """The sample portrait, where the networks find its face."""
    assert weights.is_dir()
    return assets.sample()


@pytest.fixture(scope="session")
def small_png(portrait: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, 300 px wide, quick and lossless."""
    path = tmp_path_factory.mktemp("portrait") / "small.png"
    Image.open(portrait).resize((300, 300)).save(path)
    return path


@pytest.fixture(scope="session")
def small_portrait(portrait: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, 300 px wide and quick."""
    path = tmp_path_factory.mktemp("portrait") / "small.jpg"
    Image.open(portrait).resize((300, 300)).save(path, quality=92)
    return path


@pytest.fixture(scope="session")
def catalogues() -> ModuleType:
    """The command that gathers the words, with Babel behind it."""
    pytest.importorskip("babel", reason="pip install -e '.[test]' again")
    spec = importlib.util.spec_from_file_location("catalogues", ROOT / "resources/catalogues.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.gathered = cache(module.gathered)
    return module


@pytest.fixture
def spoken(
    catalogues: ModuleType,
    english: None,  # noqa: ARG001
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The Japanese catalogue lies where the programs look for it, freshly compiled."""
    folder = tmp_path / "translations"
    folder.mkdir()
    shutil.copy(ROOT / "resources" / "translations" / "ja.po", folder)
    catalogues.compile_all(folder)
    monkeypatch.setattr(language, "_folder", lambda: folder)


@pytest.fixture(scope="session")
def gathered(catalogues: ModuleType) -> frozenset[str]:
    """Every text that a catalogue has."""
    found = catalogues.gathered()
    return frozenset(text for one in found for text in (one.id if one.pluralizable else [one.id]))


@pytest.fixture
def pseudolocale(english: None, gathered: frozenset[str], monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: ARG001
    """A language that nobody speaks has the word, in the libraries that say ours, too."""
    catalogue = PseudoTranslations(gathered)
    language.use_catalogue("xx", catalogue)
    monkeypatch.setattr(gettext, "dgettext", lambda _, text: catalogue.gettext(text))
    monkeypatch.setattr(gettext, "dngettext", lambda _, *counted: catalogue.ngettext(*counted))


@pytest.fixture
def english(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Whatever language a test speaks: all say it in English again at its end."""
    monkeypatch.setenv("LANGUAGE", "en")  # remembered before another one is set
    yield
    language.use_language("en")


@pytest.fixture
def device() -> Iterator[Path]:
    """A device in a file system where nobody can replace it: a terminal of our own."""
    ours, theirs = os.openpty()
    yield Path(os.ttyname(theirs))
    os.close(ours)
    os.close(theirs)


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches work in a thread of this process, where processes aren't what a test is about."""

    def threads(count: int) -> Workers:
        return Workers(lambda: ThreadPoolExecutor(count), count)

    monkeypatch.setattr(Workers, "processes", threads)
