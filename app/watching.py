"""Values whose parts can be watched."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Set as AbstractSet


class Watched:
    """Base class of a value that calls functions after changes of its parts."""

    _watchers: list[tuple[frozenset[str], Callable[[], object]]]

    def watch(
        self,
        show: Callable[[], object],
        *names: str,
        value: Callable[[], object] | None = None,
    ) -> None:
        """Call `show` now, and after each change of a named part; without names, of any part.

        With `value`, call `show` only if the value differs, too. Watchers are called in the order
        of registration.
        """
        if value is not None:
            show = _if_changed(value, show)
        self._watchers.append((frozenset(names), show))
        show()

    def _call_watchers(self, changed: AbstractSet[str]) -> None:
        for names, show in tuple(self._watchers):
            if not names or names & changed:
                show()


def _if_changed(value: Callable[[], object], show: Callable[[], object]) -> Callable[[], None]:
    """Return a function that calls `show` if `value` differs from the last call."""
    last: list[object] = [object()]

    def follow() -> None:
        now = value()
        if now != last[0]:
            last[0] = now
            show()

    return follow
