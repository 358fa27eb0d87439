"""Random operations on photos changed in place, with an oracle of what each file once held."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

from kogao_core.base.atomic import atomic_write
from kogao_core.photo.originals import ChangedSince, NoOriginal, Originals, StoreFull


def write_in_place(place: Originals, path: Path, result: bytes) -> int:
    """Overwrite a file as `photo.write_in_place` does; return how many originals were evicted."""
    evicted = place.keep(path, [result])
    atomic_write(result, path)
    place.note_written(path)
    return evicted


class Trial:
    """Photos in two folders and a small store; results are equal for photos of the same kind.

    `histories` holds for each file all bytes that it, or the file it was copied from, once held.
    """

    def __init__(self, folder: Path, chance: random.Random) -> None:
        self.chance, self.restores, self.wrong = chance, 0, list[str]()
        self.folders = [folder / "a", folder / "b"]
        self.store = folder / "store"
        self.histories: dict[Path, list[bytes]] = {}
        for one in self.folders:
            one.mkdir()
        for n in range(6):
            whole = b"kind %d, photo %d " % (n % 2, n) + chance.randbytes(40)
            self.put(self.folders[n % 2] / f"{n // 2}.jpg", whole, [])

    def put(self, path: Path, data: bytes, history: list[bytes]) -> None:
        path.write_bytes(data)
        self.histories[path] = [*history, data]

    def run(self, steps: int) -> list[str]:
        """Do random operations; return descriptions of restores that brought wrong bytes."""
        operations = (self.edit, self.edit, self.restore, self.restore, self.move, self.copy,
                      self.change, self.delete)  # fmt: skip
        for _ in range(steps):
            path = self.chance.choice(sorted(self.histories))
            self.chance.choice(operations)(path)
        for path in sorted(self.histories):
            self.restore(path)
        return self.wrong

    def originals(self) -> Originals:
        return Originals(self.store, self.chance.choice((250, 10**6)), self.chance.random() < 0.5)

    def edit(self, path: Path) -> None:
        # The result depends on the kind alone: what told the photos apart is left out.
        result = path.read_bytes()[:6] + b" result %d" % self.chance.randrange(3)
        try:
            write_in_place(self.originals(), path, result)
        except StoreFull:
            return
        self.histories[path].append(result)

    def restore(self, path: Path) -> None:
        try:
            self.originals().restore(path)
        except (NoOriginal, ChangedSince):
            return
        self.restores += 1
        if path.read_bytes() not in self.histories[path]:
            self.wrong.append(f"{path.name}: {path.read_bytes()!r}, was {self.histories[path]}")

    def move(self, path: Path) -> None:
        to = self.chance.choice(self.folders) / f"{self.chance.randrange(6)}.jpg"
        if to != path:
            path.replace(to)
            self.histories[to] = self.histories.pop(path)

    def copy(self, path: Path) -> None:
        to = self.chance.choice(self.folders) / f"{self.chance.randrange(6)}.jpg"
        if to not in self.histories:
            self.chance.choice((shutil.copy, shutil.copy2))(path, to)
            self.histories[to] = list(self.histories[path])

    def change(self, path: Path) -> None:
        self.put(path, b"kind %d, theirs " % self.chance.randrange(2) + self.chance.randbytes(9),
                 self.histories[path])  # fmt: skip

    def delete(self, path: Path) -> None:
        if len(self.histories) > 3:
            path.unlink()
            del self.histories[path]
