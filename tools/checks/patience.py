"""How long a test waits for an event: until it comes, at most for longer on a slower machine.

>>> until(lambda: 3, "a three")
3
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import cache
from typing import TypeVar

T = TypeVar("T")

SLOWNESS = "CAMTURN_SLOWNESS"  # environment: tools/run_steps.py measures once for all steps
_REFERENCE_S = 0.4  # that measure() takes on an idle core of a 2020 server
_N_STEPS = 5_600_000
_MOST = 20.0
_LIMIT_S = 300.0  # on such a core: long, since other programs may begin during the tests


def measure() -> float:
    """Return how many times slower than an idle reference machine this one is, 1 to 20."""
    begin_s, x = time.perf_counter(), 1
    for _ in range(_N_STEPS):
        x = x * 69069 & 0xFFFFFFFF
    return min(max(1.0, (time.perf_counter() - begin_s) / _REFERENCE_S), _MOST)


@cache
def slowness() -> float:
    """Return the slowness of this run of the tests: the environment's, else measured now."""
    given = os.environ.get(SLOWNESS)
    return float(given) if given else measure()


def limit_s(seconds: float = _LIMIT_S) -> float:
    """Return a limit [s] for this machine from the one for an idle reference machine."""
    return seconds * slowness()


def until(
    condition: Callable[[], T],
    what: str = "the condition in the traceback",
    seconds: float = _LIMIT_S,
) -> T:
    """Wait until a condition holds; return its value. An assertion names what did not come."""
    end_s = time.monotonic() + limit_s(seconds)
    while not (found := condition()):
        assert time.monotonic() < end_s, f"{what}: not within {limit_s(seconds):.0f} s"
        time.sleep(0.01)
    return found
