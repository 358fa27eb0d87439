"""The choice of landmark sources."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from kogao_core.cli.commands import program
from kogao_core.faces.landmarks import CHOICES, MeshSource, source, sources
from kogao_core.faces.landmarks.aam.source import AamSource


def test_names_give_their_sources():
    assert isinstance(source("mesh"), MeshSource)
    assert isinstance(source("aam"), AamSource)
    measured = [choice.measured for choice in CHOICES if choice.measured is not None]
    assert all(0.0 < one.studio_jaw < one.wild_jaw < 10.0 for one in measured)


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.name)
def test_help_and_the_document_name_every_source(choice):
    said = CliRunner().invoke(program, ["detect", "--help"]).output
    assert choice.name in said[said.index("--landmarks [") :].split("]")[0]
    measured = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    assert choice.measured is None or f"\n| {choice.name} | " in measured


def test_without_networks_the_aam_is_the_default(monkeypatch):
    monkeypatch.setattr(sources, "networks_are_here", lambda: False)
    assert isinstance(source(), AamSource)
    monkeypatch.setattr(sources, "networks_are_here", lambda: True)
    assert isinstance(source(), MeshSource)


def test_an_unknown_source_is_refused():
    with pytest.raises(ValueError, match="use one of mesh, aam, chin"):
        source("model.yaml")
