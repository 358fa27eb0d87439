"""Where programs lie and what is said of extras, in an environment and in a bundle."""

import sys

import pytest

from kogao_core.base import installed
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


@pytest.mark.usefixtures("bundle")
def test_nobody_is_told_to_install_something_into_a_bundle():
    assert installed.adding("cluster").startswith("not in this bundle")
    wrong = {"numpy": {"version": "1", "state": "doesn't load"}}
    assert list(doctor._mend(wrong, {}, {})) == ["unpack the bundle anew"]
    assert list(doctor._mend({}, {"a.tflite": "missing"}, {})) == ["unpack the bundle anew"]
