"""Where the project is found is written by one command, and again for the next release."""

import runpy
import shutil
import subprocess
import tomllib
from datetime import date
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = ("pyproject.toml", "resources/desktop/org.kogao.Kogao.metainfo.xml")


@pytest.fixture
def copies(tmp_path):
    for name in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_one_command_tells_where_the_project_is_found(copies):
    write = runpy.run_path(str(ROOT / "resources" / "addresses.py"))["write"]
    write(copies, "https://old.example/k", "https://old.example", date(2026, 12, 1))
    write(copies, "https://forge.example/kogao/", "https://kogao.example/", date(2027, 1, 2))
    project, metadata = ((copies / name).read_text(encoding="utf-8") for name in FILES)
    assert "old.example" not in project + metadata
    was = tomllib.loads((ROOT / FILES[0]).read_text(encoding="utf-8"))
    now = tomllib.loads(project)
    urls = now["project"].pop("urls")
    was["project"].pop("urls", None)
    assert now == was
    assert urls["Issues"] == "https://forge.example/kogao/issues"
    assert metadata.count("<screenshot") == 4
    assert metadata.count('date="2027-01-02"') == 1


@pytest.mark.skipif(not shutil.which("appstreamcli"), reason="needs appstreamcli")
def test_shops_of_programs_take_what_is_written(copies):
    write = runpy.run_path(str(ROOT / "resources" / "addresses.py"))["write"]
    write(copies, "https://forge.example/kogao", "https://kogao.example", date(2026, 12, 1))
    checked = ["appstreamcli", "validate", "--no-net", "--pedantic", str(copies / FILES[1])]
    done = subprocess.run(checked, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "screenshot" not in done.stdout
