"""What renderings of the open photo hold of its background."""

from __future__ import annotations

import dataclasses

from kogao_core.background import Background, BackgroundFinder
from kogao_core.geometry import Image
from kogao_core.holding import NOTHING_HELD, Held

from ..document import State


class Holding:
    """Looks once for each state of the faces; a gesture's previews go by the last look.

    Parameters
    ----------
    photo : array of shape (H, W) or (H, W, C)
        The photo as it was read: the command line looks at the same pixels.
    finder : BackgroundFinder
        What looks.
    """

    def __init__(self, photo: Image, finder: BackgroundFinder) -> None:
        self._photo, self._finder = photo, finder
        self._last: Background | None = None

    @property
    def background(self) -> Background | None:
        """What was last seen of the background, if anyone looked."""
        return self._last

    def whole(self, state: State) -> Held:
        """Return what the whole photo's rendering holds, px of the photo."""
        done = state.done
        if done.faces and done.recipe.hold_background:
            self._last = self._finder.find(self._photo, done.faces, done.others)
        return self.preview(state)

    def preview(self, state: State) -> Held:
        """Return the same as far as it is known."""
        if self._last is None or not state.recipe.hold_background:
            return NOTHING_HELD
        held = self._last.held(state.loose)
        if len(held.neighbours) != len(state.active):
            held = dataclasses.replace(held, neighbours=())
        return held
