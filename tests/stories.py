"""Random stories about photos whose files change while windows are open, with an oracle.

The oracle knows each picture by its pixels and its turn, the newest edit of each picture with the
undo steps that led there, and the bytes of each file. It shares nothing with the identity of the
program.
"""

from __future__ import annotations

import json
import shutil
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from kogao_core.photo import read
from kogao_core.photo.model import Photo
from kogao_core.photo.whereabouts import Gone, Replaced, current, to_save
from kogao_core.projects import sidecar
from kogao_core.projects.edits import Edits, own_place, sidecar_of
from kogao_core.projects.project import Project, Sheet, load
from kogao_core.projects.results import Results
from kogao_core.recipe.recipe import Recipe

DEFAULT = 4.0
TURNS = (1, 3, 6, 8)
Picture = tuple[int, int]  # number of the pixels, EXIF orientation


def write_photo(path: Path, picture: Picture, star: int) -> None:
    """Write a photo; `star` changes the metadata alone."""
    pixels = np.random.default_rng(picture[0]).integers(0, 256, (18, 24, 3), np.uint8)
    exif, text = Image.Exif(), PngInfo()
    exif[0x112] = picture[1]
    text.add_text("Rating", str(star))
    Image.fromarray(pixels).save(path, "PNG", exif=exif, pnginfo=text)


def stamp_of(file: Path) -> tuple[int, int] | None:
    with suppress(OSError):
        state = file.stat()
        return state.st_size, state.st_mtime_ns
    return None


@dataclass
class World:
    """The files, and what the user knows about them."""

    folder: Path
    files: dict[Path, Picture] = field(default_factory=dict)
    away: list[tuple[Picture, Path]] = field(default_factory=list)  # deleted or replaced, and where
    newest: dict[Picture, list[float]] = field(default_factory=dict)  # steps up to the newest edit
    seen: dict[Path, bytes] = field(default_factory=dict)
    stars: int = 0

    def put(self, path: Path, picture: Picture) -> None:
        self.stars += 1
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = path.with_name("fresh.part")
        write_photo(fresh, picture, self.stars)
        fresh.replace(path)
        self.files[path], self.seen[path] = picture, path.read_bytes()

    def percent(self, picture: Picture) -> float:
        return self.newest.get(picture, [DEFAULT])[-1]


class Window:
    """A program with one open photo, as the editor uses identity, edits and whereabouts."""

    def __init__(self, edits: Edits) -> None:
        self.edits = edits
        self.photo: Photo | None = None
        self.steps: list[float] = [DEFAULT]
        self.stamps: dict[Path, tuple[int, int] | None] = {}
        self.warnings: list[str] = []
        self.picture: Picture = (0, 1)  # that the oracle knows to be open
        self.kept_old = False

    def places(self) -> list[Path]:
        return [sidecar_of(self.photo.path), own_place(self.photo.path, self.edits.folder)]

    def open(self, path: Path, carried: list[float] | None = None) -> bool:
        """Open a photo; return whether edits of another picture were mentioned."""
        self.photo, self.kept_old = read(path), False
        self.edits.note(self.photo)
        self.stamps = {place: stamp_of(place) for place in self.places()}
        found, self.steps = self.edits.find(path, self.photo), [DEFAULT]
        if found.edits is not None:
            project = load(found.edits.file)
            known = self.edits.name_in(project, self.photo)
            _, note = sidecar.match(project, self.photo.pixels, known)
            self.warnings += [note] * bool(note)
            percent = project.automatic.recipe.percent
            stored = (json.loads(one) for one in self.edits.steps_of(found.edits, project))
            self.steps = next((one for one in stored if one[-1] == percent), [percent])
        if carried is not None:
            self.steps = carried
        return found.edits is None and found.foreign is not None

    def edit(self, percent: float) -> None:
        self.steps = [*self.steps, percent]

    def keep(self, *, replace: bool = False) -> bool:
        """Save the edits; return False if another window has changed them."""
        photo, path = self.photo, self.photo.path
        beside = self.edits.holds(path, photo)
        place = self.places()[not beside]
        if not replace and stamp_of(place) not in (None, self.stamps.get(place)):
            theirs = load(place)
            if self.edits.name_in(theirs, photo) == theirs.original.sha256:
                return False
        sheet = Sheet(recipe=Recipe(percent=self.steps[-1]))
        project = Project(sidecar.original(photo), "automatic", sheet)
        file = self.edits.keep(project, path, json.dumps(self.steps).encode(), beside=beside)
        self.stamps[file] = stamp_of(file)
        if file == sidecar_of(path) and not path.exists():
            self.warnings.append("saved below a mount point")
        return True


class Story:
    """One story: random steps, each followed by the oracle. `wrong` counts what went wrong."""

    steps = (
        *("edit", "edit", "edit", "undo", "save", "sync", "rename_file", "rename_folder"),
        *("replace", "metadata", "turn", "delete", "bring_back", "swap_folder", "unswap"),
        *("second_window", "kill", "reopen", "reopen", "move_file"),
    )

    def __init__(self, folder: Path, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.world = World(folder / "photos")
        self.edits, self.results = Edits(folder / "data" / "edits"), Results(folder / "data")
        self.windows = [Window(self.edits)]
        self.wrong: Counter[str] = Counter()
        self.log: list[str] = []
        self.swapped: list[tuple[Path, Path, dict[Path, Picture]]] = []
        self.drives: list[dict[Path, bytes]] = []  # bytes of the photos on each
        self.number = self.copies = 0
        self.percents = iter(np.arange(1, 2000) / 100 + 0.001)
        for name in ("a/1.png", "a/2.png", "b/1.png"):
            self.number += 1
            self.world.put(self.world.folder / name, (self.number, 1))
        self.reopen()

    # -- the oracle --------------------------------------------------------------------------------

    def note(self, kind: str) -> None:
        self.wrong[kind] += 1
        self.log.append(f"WRONG: {kind}")

    def run(self, count: int) -> Counter[str]:
        for _ in range(count):
            step = str(self.rng.choice(self.steps))
            self.log.append(step)
            getattr(self, step)()
            for window in self.windows:
                self.watch(window)
            for path in self.world.files:
                if path.read_bytes() != self.world.seen[path]:
                    self.note("original changed")
        for path in list(self.world.files):
            self.shown(Window(self.edits), path)
        return self.wrong

    def shown(self, window: Window, path: Path, carried: list[float] | None = None) -> None:
        """Open a photo, and compare with the newest edit of its picture."""
        self.log.append(f"  open {path.relative_to(self.world.folder)} {self.world.files[path]}")
        window.picture, before = self.world.files[path], len(window.warnings)
        foreign = window.open(path, carried)
        if carried is None and window.steps[-1] != self.world.percent(window.picture):
            self.note(f"edit lost: {window.steps[-1]} is not {self.world.percent(window.picture)}")
        elif carried is None and window.steps != self.world.newest.get(window.picture, [DEFAULT]):
            self.note("undo lost")
        if window.warnings[before:] or (foreign and window.picture in self.world.newest):
            self.note("false warning")

    def watch(self, window: Window) -> None:
        """Compare the open photo with its file, as the window does each second."""
        photo = window.photo
        if photo is None or window.kept_old:
            return
        there = self.world.files.get(photo.path)
        try:
            window.photo = current(photo)
        except Gone:
            if window.picture in self.world.files.values() and there == window.picture:
                self.note("false warning")
        except Replaced:
            if there == window.picture:
                self.note("false warning")
            elif self.rng.random() < 0.5:
                self.shown(window, photo.path, window.steps)
                self.kept(window)
            else:
                window.kept_old = True
        else:
            if self.world.files.get(window.photo.path) != window.picture:
                self.note("wrong picture")
            if window.photo.path != photo.path:
                window.stamps |= {place: stamp_of(place) for place in window.places()}

    def kept(self, window: Window) -> None:
        if not window.keep():
            if self.rng.random() < 0.5:
                window.keep(replace=True)
            else:
                self.log.append("  theirs")
                path, there = window.photo.path, self.world.files.get(window.photo.path)
                if there == window.picture:
                    self.shown(window, path)
                return
        self.world.newest[window.picture] = list(window.steps)

    # -- steps -------------------------------------------------------------------------------------

    def any_window(self) -> Window:
        return self.windows[self.rng.integers(len(self.windows))]

    def any_path(self) -> Path | None:
        paths = sorted(self.world.files)
        return paths[self.rng.integers(len(paths))] if paths else None

    def edit(self) -> None:
        window = self.any_window()
        window.edit(float(next(self.percents)))
        self.log.append(f"  {window.picture}: {window.steps[-1]}")
        self.kept(window)

    def undo(self) -> None:
        window = self.any_window()
        if len(window.steps) > 1:
            window.steps = window.steps[:-1]
            self.kept(window)

    def save(self) -> None:
        """Save a copy: to a new name, or over a photo of the strip, under any name."""
        window, path = self.any_window(), self.any_path()
        self.copies += 1
        free = self.world.folder.parent / f"copy{self.copies}.png"
        target = path if path and self.rng.random() < 0.4 else free
        photos = [*self.world.files]
        try:
            photo = to_save(window.photo, target, photos.__contains__)
        except Replaced:
            return
        if photo is None:
            if target == free:
                self.note("false warning")
            return
        Image.fromarray(photo.pixels).save(target)
        there = self.world.files.get(photo.path)
        stale = there is not None and there != window.picture and not window.kept_old
        if stale:
            self.note("wrong picture")

    def sync(self) -> None:
        path = self.any_path()
        if path is None:
            return
        percent, photo = float(next(self.percents)), read(path)
        found = self.edits.find(path, reads=True).edits
        steps = [DEFAULT]
        if found is not None:
            project = load(found.file)
            now = project.automatic.recipe.percent
            stored = (json.loads(one) for one in self.edits.steps_of(found, project))
            steps = next((one for one in stored if one[-1] == now), [now])
        steps = [*steps, percent]
        project = Project(
            sidecar.original(photo), "automatic", Sheet(recipe=Recipe(percent=percent))
        )
        self.edits.keep(project, path, json.dumps(steps).encode())
        self.world.newest[self.world.files[path]] = steps

    def _move(self, path: Path, to: Path) -> None:
        if not to.exists():
            to.parent.mkdir(exist_ok=True)
            path.rename(to)
            self.world.files[to] = self.world.files.pop(path)
            self.world.seen[to] = self.world.seen.pop(path)
            self.log.append(f"  {path.name} -> {to.relative_to(self.world.folder)}")

    def rename_file(self) -> None:
        if path := self.any_path():
            self._move(path, path.with_name(f"r{self.rng.integers(6)}.png"))

    def move_file(self) -> None:
        if path := self.any_path():
            self._move(path, self.world.folder / f"m{self.rng.integers(3)}" / path.name)

    def _rename_folder(self, folder: Path, to: Path) -> None:
        folder.rename(to)
        for path in [one for one in self.world.files if one.parent == folder]:
            self.world.files[to / path.name] = self.world.files.pop(path)
            self.world.seen[to / path.name] = self.world.seen.pop(path)

    def rename_folder(self) -> None:
        if path := self.any_path():
            to = self.world.folder / f"f{self.rng.integers(6)}"
            if not to.exists():
                self._rename_folder(path.parent, to)

    def swap_folder(self) -> None:
        """Take a folder away and leave an empty one, as an unmounted drive does."""
        if path := self.any_path():
            to = self.world.folder.parent / f"drive{len(self.swapped)}-{self.rng.integers(10**9)}"
            path.parent.rename(to)
            gone = {one: self.world.files.pop(one) for one in list(self.world.files)
                    if one.parent == path.parent}  # fmt: skip
            path.parent.mkdir()
            self.swapped.append((path.parent, to, gone))
            self.drives.append({one: self.world.seen.pop(one) for one in gone})

    def unswap(self) -> None:
        """Bring a drive back, unless another folder has its name now."""
        if not self.swapped:
            return
        (folder, drive, photos), seen = self.swapped.pop(), self.drives.pop()
        there = list(folder.iterdir()) if folder.exists() else []
        if there:
            self.swapped.insert(0, (folder, drive, photos))
            self.drives.insert(0, seen)
            return
        if folder.exists():
            folder.rmdir()
        drive.rename(folder)
        self.world.files |= photos
        self.world.seen |= seen

    def replace(self) -> None:
        if path := self.any_path():
            self.world.away.append((self.world.files[path], path))
            self.number += 1
            self.world.put(path, (self.number, 1))

    def metadata(self) -> None:
        if path := self.any_path():
            self.world.put(path, self.world.files[path])

    def turn(self) -> None:
        if path := self.any_path():
            pixels, turn = self.world.files[path]
            turn = TURNS[(TURNS.index(turn) + 1) % len(TURNS)]
            self.world.put(path, (pixels, turn))

    def delete(self) -> None:
        path = self.any_path()
        if path and len(self.world.files) > 1:
            self.world.away.append((self.world.files.pop(path), path))
            path.unlink()

    def bring_back(self) -> None:
        if self.world.away:
            picture, path = self.world.away[self.rng.integers(len(self.world.away))]
            away = [one for *_, photos in self.swapped for one in photos.items()]
            pixels = {one[0] for one in self.world.files.values()} | {one[0] for _, one in away}
            if not path.exists() and picture[0] not in pixels:
                self.world.away.remove((picture, path))
                self.world.put(path, picture)

    def second_window(self) -> None:
        if len(self.windows) == 1 and (path := self.any_path()):
            self.windows.append(Window(self.edits))
            self.shown(self.windows[1], path)

    def kill(self) -> None:
        if path := self.any_path():
            self.windows = [Window(self.edits)]
            self.shown(self.windows[0], path)

    def reopen(self) -> None:
        if path := self.any_path():
            self.shown(self.any_window(), path)


def tell(folder: Path, seed: int, steps: int = 30) -> tuple[Counter[str], list[str]]:
    """Run a story in a folder, which is deleted; return what went wrong, and its steps."""
    folder.mkdir()
    story = Story(folder, seed)
    try:
        return story.run(steps), story.log
    finally:
        shutil.rmtree(folder)
