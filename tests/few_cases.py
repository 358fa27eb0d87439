"""Cases by the number: a few in the default run, all where slow tests run."""

import pytest


def few_of(cases, few):
    """Return cases for ``parametrize``, of which all but the first `few` are marked slow.

    A tuple holds a value for each of several parameters.
    """
    cases = list(cases)
    slow = (case if isinstance(case, tuple) else (case,) for case in cases[few:])
    return [*cases[:few], *(pytest.param(*case, marks=pytest.mark.slow) for case in slow)]
