"""``kogao-cli landmarks``: export landmarks to files."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from kogao_core.base.language import Text, translated
from kogao_core.cli import common, ending, reading
from kogao_core.projects import interchange


def run(args: SimpleNamespace) -> int:
    """Run the command."""
    photos = reading.input_paths(args.inputs, args.sample)
    targets = [_target(photo, args.folder, args.form) for photo in photos]
    twice = {target for target in targets if targets.count(target) > 1}
    if twice:
        raise ending.Stop(
            Text(
                "several photos would be written to {twice}; use separate folders",
                twice=min(twice),
            )
        )

    def write(photo: Path) -> None:
        target = _target(photo, args.folder, args.form)
        read = reading.read_photo(photo, args.max_megapixels)
        found = reading.find_faces(read, args.landmarks, args.points)
        faces = reading.selected(found, args.which)
        common.check_free(target, args.force)
        with ending.writing(target):
            args.folder.mkdir(parents=True, exist_ok=True)
            written = interchange.write(faces, target)
        note = f" ({translated(written)})" if written else ""
        ending.print_text(f"{photo}: {target}{note}")

    return common.each(photos, write)


def _target(photo: Path, folder: Path, form: str) -> Path:
    return folder / f"{photo.stem}.{form}"
