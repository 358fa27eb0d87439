"""Where programs lie and what is said of extras, in an environment and in a bundle."""

import json
import shlex
import sys
from importlib import metadata
from unittest.mock import Mock

import pytest

from kogao_core.base import assets, installed
from kogao_core.cli import doctor

ENDING = ".exe" if sys.platform == "win32" else ""


@pytest.fixture
def bundle(monkeypatch, tmp_path):
    """This process as a bundle's would be."""
    for name in ("kogao", "kogao-cli"):
        (tmp_path / (name + ENDING)).touch()
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    monkeypatch.setattr(sys, "executable", str(tmp_path / f"kogao{ENDING}"))
    return tmp_path


def test_a_bundles_programs_lie_beside_each_other(bundle):
    assert installed.program("kogao-cli") == bundle / f"kogao-cli{ENDING}"


def test_what_is_installed_nowhere_is_not_found(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert installed.program("kogao-of-nobody") is None


class Here:
    """What pip notes of an installation."""

    def __init__(self, told):
        self.told = told

    def read_text(self, _):
        return None if self.told is None else json.dumps(self.told)


@pytest.mark.parametrize(
    ("told", "given"),
    [
        ({"url": "file:///HERE/my%20kogao", "dir_info": {"editable": True}}, "-e '/HERE/my kogao'"),
        ({"url": "file:///HERE/my%20kogao", "dir_info": {}}, "'/HERE/my kogao'"),
        (
            {"url": "https://a.example/k.whl", "archive_info": {}},
            "'kogao @ https://a.example/k.whl'",
        ),
        (
            {"url": "https://a.example/k", "vcs_info": {"vcs": "git", "commit_id": "12ab"}},
            "'kogao @ git+https://a.example/k@12ab'",
        ),
        ({"url": "file:///HERE/gone", "dir_info": {}}, None),
        (None, None),
    ],
)
def test_what_is_lacking_comes_from_where_this_was_installed(monkeypatch, tmp_path, told, given):
    (tmp_path / "my kogao").mkdir()
    if told:
        told = {**told, "url": told["url"].replace("file:///HERE", tmp_path.as_uri())}
    monkeypatch.setattr(metadata, "distribution", lambda _: Here(told))
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if given is None:  # nor is an index asked for a name that isn't ours there
        assert "pip" not in installed.again() + installed.adding("heic")
        return
    given = given.replace("'/HERE/my kogao'", shlex.quote(str(tmp_path / "my kogao")))
    assert installed.again("--no-deps") == f"{pip} --force-reinstall --no-deps {given}"
    (asked,) = [word for word in shlex.split(installed.adding("heic")) if "[heic]" in word]
    assert asked.replace("[heic]", "") in shlex.split(given)


def test_an_environment_without_pip_is_served_by_uv(monkeypatch):
    monkeypatch.setattr(installed, "find_spec", lambda _: None)
    monkeypatch.setattr(installed.shutil, "which", lambda name: f"/bin/{name}")
    expected = ["uv", "pip", "uninstall", "--python", sys.executable, "opencv-python"]
    assert shlex.split(installed.without(["opencv-python"])) == expected


@pytest.mark.usefixtures("bundle")
@pytest.mark.parametrize(
    ("module", "name", "error"),
    [
        (metadata, "version", metadata.PackageNotFoundError),
        (assets, "path", assets.AssetMissing("gone")),
    ],
)
def test_nobody_is_told_to_install_something_into_a_bundle(monkeypatch, module, name, error):
    assert installed.adding("heic").startswith("not in this bundle")
    monkeypatch.setattr(module, name, Mock(side_effect=error))
    monkeypatch.setattr(installed, "missing_libraries", dict)
    assert doctor.examine()["mend"] == ["unpack the bundle again"]
