"""What the experiments share: their photos and recipe, and the files they write."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kogao_core.cli import common, options, outputs, words
from kogao_core.cli.progress import ProgressLine
from kogao_core.language import Text, tr

if TYPE_CHECKING:
    from kogao_core.experiments.report import Report
    from kogao_core.experiments.subjects import Subject
    from kogao_core.face import LandmarkSource

# The arguments of every experiment; the command hands them to `Work`.
takes_photos = words.together(
    common.takes_photos,
    options.chooses_as_the_paper,
    outputs.writes_files,
    words.option(
        "-o", "--output", "folder", type=common.FOLDER, metavar="DIR",
        help="Write all of these, and pictures, into a folder; made if need be.",
    ),
)  # fmt: skip


class Work:
    """One experiment on the command line, from its arguments to its files.

    Parameters
    ----------
    name : str
        Of the experiment, and of its files in a folder.
    given : mapping
        What `takes_photos` has added to the command's arguments.
    """

    def __init__(self, name: str, given: Mapping[str, Any]) -> None:
        self._given = given
        self.recipe = options.paper_recipe_of(given["recipe_file"], given.get("percent"))
        self._paths = common.input_paths(given["inputs"], given["sample"])
        self.outputs = outputs.Outputs(_files(name, given), given["folder"], given["force"])
        self._left_out: list[str] = []
        self.progress = ProgressLine()
        self._code = 0

    @cached_property
    def source(self) -> LandmarkSource:
        """What finds the faces."""
        return common.landmark_source(self._given["landmarks"])

    def subjects(self) -> Iterator[Subject]:
        """Yield the photos that have a face; others are named on stderr and in the report.

        Raises
        ------
        Stop
            If there is none at all.
        """
        source = self.source
        common.mention_fallback(self._given["landmarks"])
        stop: common.Stop | None = None
        found = 0
        for number, path in enumerate(self._paths, start=1):
            try:
                subject = self._subject(path, source)
            except common.Stop as problem:
                if problem.code == common.BROKEN:
                    raise
                stop = problem
                if len(self._paths) > 1:
                    self.leave_out(problem.message)
                continue
            self.progress.begin(
                tr("{number} of {total}: {path}", number=number, total=len(self._paths), path=path)
            )
            found += 1
            yield subject
        if not found and stop is not None:
            raise stop
        self.progress.end()

    def name_absent(self, sentence: str) -> None:
        """Note what is missing here, on stderr and in the report."""
        self._left_out.append(sentence)
        common.print_message(sentence)

    def leave_out(self, sentence: str) -> None:
        """Note a photo that can't be used, and set the exit code; the others go on."""
        self._code = common.SOME_FAILED
        self.name_absent(sentence)

    def _subject(self, path: Path, source: LandmarkSource) -> Subject:
        from kogao_core.assets import AssetMissing
        from kogao_core.experiments.subjects import Subject
        from kogao_core.landmarks import ModelRefused

        photo = common.read_photo(path, self._given["max_megapixels"])
        with common.stopping((AssetMissing, ModelRefused), common.BROKEN):
            faces = source.find(photo.pixels)
        if not faces:
            raise common.Stop(
                Text("no face in {path}; leave it out or crop closer", path=path), common.NO_FACE
            )
        chosen = common.selected(faces, self._given["which"])
        namesakes = [other for other in self._paths if other.name == path.name]
        return Subject(path.name if len(namesakes) == 1 else str(path), photo.pixels, tuple(chosen))

    def deliver(self, report: Report) -> int:
        """Print the tables, write the files that were asked for, and return the exit code."""
        self.outputs.write(report, self._left_out)
        return self._code


def _files(name: str, given: Mapping[str, Any]) -> dict[str, Path]:
    folder: Path | None = given["folder"]
    files = outputs.asked_for(given)
    if folder is None:
        return files
    return {kind: files.get(kind, folder / f"{name}.{kind}") for kind in outputs.KINDS}
