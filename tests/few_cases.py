"""Cases by the number: a few in the default run, all where slow tests run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

import pytest

_Case = TypeVar("_Case")


def few_of(cases: Iterable[_Case], few: int) -> list:
    """Return cases for ``parametrize``, of which all but the first `few` are marked slow.

    A tuple holds a value for each of several parameters.
    """
    return [
        case
        if number < few
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
        for number, case in enumerate(cases)
    ]
