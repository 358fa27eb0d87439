"""``kogao-cli landmarks``: export landmarks to files."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from kogao_core.base.language import translated
from kogao_core.cli import common, ending, reading
from kogao_core.projects import interchange


def run(args: SimpleNamespace) -> int:
    """Run the command."""
    photos = reading.input_paths(args.inputs, args.sample, named=True)

    def write(photo: Path) -> None:
        target = args.folder / f"{photo.stem}.{args.form}"
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
