"""Short versions of the long trials in ``tests/benchmarks``, as their own programs."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from few_cases import few_of

TRIALS = Path(__file__).parents[1] / "benchmarks"


def run(name, *options):
    done = subprocess.run(
        [sys.executable, str(TRIALS / f"{name}.py"), *options],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
@pytest.mark.slow
@pytest.mark.usefixtures("portrait")
def test_programs_killed_while_saving_harm_nothing():
    came_to = run("kills", "--kills", "20", "--photos", "6")
    assert came_to["killed while saving"] == 18
    assert came_to["killed in a batch"] == 2
    assert came_to["harmed"] == 0


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits on memory")
@pytest.mark.skipif(
    not all(map(find_spec, ("pi_heif", "pillow_heif", "rawpy"))), reason="needs [heic] and [raw]"
)
@pytest.mark.usefixtures("portrait")
@pytest.mark.parametrize("inputs", few_of([16, 450], 1))
def test_damaged_files_are_processed_or_refused_in_a_sentence(inputs):
    came_to = run("hostile", "--inputs", str(inputs), "--seed", "7")
    assert sum(came_to["sums"].values()) == inputs
    assert came_to["sums"]["done"] >= inputs / 30
    assert came_to["wrong"] == {}
