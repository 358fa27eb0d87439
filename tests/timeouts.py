"""How long a test waits for what must come; where it comes at once, nothing is lost."""

import threading

LONGEST_S = 60.0


def held_back(work):
    """Return a gate, and what does some work once that is open."""
    gate = threading.Event()

    def late(*given, **named):
        assert gate.wait(LONGEST_S)
        return work(*given, **named)

    return gate, late
