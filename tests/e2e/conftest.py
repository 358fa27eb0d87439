"""The command line, called in this process."""

import pytest

from kogao_core.cli import main


@pytest.fixture
def cli(capsys):
    """Run the program; return its exit code, and what it printed and complained."""

    def run(*arguments):
        with pytest.raises(SystemExit) as ending:
            main([str(argument) for argument in arguments])
        return ending.value.code, *capsys.readouterr()

    return run
