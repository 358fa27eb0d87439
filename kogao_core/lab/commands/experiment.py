"""``kogao-cli experiment``: the paper's tables and figures, one command each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

import click

from kogao_core.base.assets import AssetMissing
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import tr
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.cli.common import ProgressLine
from kogao_core.cli.declarations import experiment
from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.lab.commands import outputs, study
from kogao_core.lab.experiments import EXPERIMENTS, paper
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.subjects import Subject
from kogao_core.photo.profiles import for_search
from kogao_core.recipe.recipe import PAPER

_takes_photos = words.together(
    options.takes_photos,
    options.chooses_as_the_paper,
    outputs.writes_files,
    words.option(
        "-o", "--output", "folder", type=common.FOLDER, metavar="DIR",
        help="Folder for all three files and pictures; created if missing.",
    ),
)  # fmt: skip


class _Run:
    """One experiment on the command line, from its arguments to its files."""

    def __init__(self, experiment: Experiment, given: Mapping[str, Any]) -> None:
        self._experiment, self._given = experiment, given
        percent = {"percent": given.get("percent")}
        self._recipe = options.recipe_of(given["recipe_file"], percent, PAPER)
        self._paths = reading.input_paths(given["inputs"], given["sample"])
        files, folder = outputs.asked_for(given), given["folder"]
        if folder is not None:
            named = {kind: folder / f"{experiment.name}.{kind}" for kind in outputs.KINDS}
            files = named | files
        self._outputs = outputs.Outputs(files, folder, given["force"])
        self._left_out: list[str] = []
        self._progress = ProgressLine()
        self._code = 0

    def deliver(self) -> int:
        """Run the experiment, print the tables, write the requested files; return the exit code."""
        source = cache(partial(landmark_source, self._given["landmarks"]))
        work = Work(
            self._subjects(source),
            self._recipe,
            source,
            {one.key: self._value(one) for one in self._experiment.options},
            self._progress.step,
            self._leave_out,
            self._outputs.keep,
        )
        self._outputs.write(self._experiment.run(work), self._left_out)
        return self._code

    def _value(self, option: ExperimentOption) -> Any:
        value = self._given[option.key]
        return value if option.read is None else [x for file in value for x in _read(option, file)]

    def _subjects(self, source: Callable[[], LandmarkSource]) -> Iterator[Subject]:
        """Yield the photos that have a face; others are named on stderr and in the report.

        Raises Stop.
        """
        finder = source()
        reading.mention_fallback(self._given["landmarks"])
        stop: ending.Stop | None = None
        found = 0
        for number, path in enumerate(self._paths, start=1):
            try:
                subject = self._subject(path, finder)
            except ending.Stop as problem:
                if problem.code == ending.BROKEN:
                    raise
                stop = problem
                if len(self._paths) > 1:
                    self._leave_out(problem.message)
                continue
            self._progress.begin(
                tr("{number} of {total}: {path}", number=number, total=len(self._paths), path=path)
            )
            found += 1
            yield subject
        if not found and stop is not None:
            raise stop
        self._progress.end()

    def _leave_out(self, sentence: str) -> None:
        """Note a problem on stderr and in the report, and set the exit code."""
        self._code = ending.SOME_FAILED
        self._left_out.append(sentence)
        ending.print_message(sentence)

    def _subject(self, path: Path, source: LandmarkSource) -> Subject:
        photo = reading.read_photo(path, self._given["max_megapixels"])
        known = reading.points_of(photo, self._given["points"])
        with ending.stopping((AssetMissing, ModelRefused), ending.BROKEN):
            faces = known or source.find(for_search(photo))
        if not faces:
            raise ending.Stop(
                "no face in {path}; remove the photo or crop closer", ending.NO_FACE, path=path
            )
        chosen = reading.selected(faces, self._given["which"])
        namesakes = [other for other in self._paths if other.name == path.name]
        name = path.name if len(namesakes) == 1 else str(path)
        return Subject(name, photo.pixels, tuple(chosen), file=path)


def _read(option: ExperimentOption, file: Path) -> list[Any]:
    assert option.read is not None
    with (
        ending.refusing("{file} can't be read ({reason})", file=file),
        ending.stopping(BadFile, ending.USAGE),
    ):
        return list(option.read(file))


def _option(one: ExperimentOption) -> Any:
    given: dict[str, Any] = {"default": one.default, "show_default": True}
    if one.read is not None:
        given = {"multiple": True, "type": click.Path(path_type=Path), "metavar": "FILE"}
    elif one.names:
        given["type"] = click.Choice(one.names)
    else:
        given["type"] = common.Whole(one.least)
    return words.option(f"--{one.name}", one.key, help=one.help, **given)


def _command_of(experiment: Experiment) -> click.Command:
    def run(**given: Any) -> int:
        return _Run(experiment, given).deliver()

    run.__doc__ = experiment.help
    percent = (options.chooses_percent,) if experiment.takes_percent else ()
    takes = words.together(_takes_photos, *percent, *map(_option, experiment.options))
    return words.command(experiment.name)(takes(run))


for one in (*map(_command_of, (*EXPERIMENTS, paper.EXPERIMENT)), study.command):
    experiment.add_command(one)
