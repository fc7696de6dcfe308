# SPDX-License-Identifier: Apache-2.0
"""How often the loops of an interrupt run: a table next to the instruction budget.

>>> bounds = parse_bounds("loops.toml", '''
... [[loop]]
... function = "copy_axes"
... rounds = 3
... why = "one per axis"
... ''')
>>> bounds["copy_axes"].rounds
3
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from camtools.base.errors import InputError
from checks.elf_flow import Flow
from checks.elf_image import Image, Place
from checks.elf_longest import Loop

_MAX_ROUNDS = 10000


class Bound(NamedTuple):
    """Most rounds that any loop of a source function makes each time it is entered."""

    rounds: int
    why: str


Bounds = Mapping[str, Bound]


def parse_bounds(file: str, text: str) -> Bounds:
    """Return the bounds of a table by source function.

    Raises
    ------
    InputError
        It is no such table.
    """
    remedy = "give function, rounds (1 .. 10000) and why for each [[loop]]"
    try:
        loops = tomllib.loads(text).get("loop", [])
    except tomllib.TOMLDecodeError as error:
        raise InputError(file, "", None, str(error), remedy) from error
    if not isinstance(loops, list) or not all(isinstance(loop, dict) for loop in loops):
        raise InputError(file, "loop", loops, "is no list of tables", remedy)
    bounds: dict[str, Bound] = {}
    for loop in loops:
        name, rounds, why = (loop.get(key) for key in ("function", "rounds", "why"))
        is_sane = isinstance(name, str) and isinstance(why, str) and type(rounds) is int
        if not is_sane or len(loop) != 3 or not 1 <= rounds <= _MAX_ROUNDS or not why.strip():
            raise InputError(file, "loop", loop, "is not understood", remedy)
        if name in bounds:
            raise InputError(file, "function", name, "stands there twice", "give the larger one")
        bounds[name] = Bound(rounds, why)
    return bounds


def load_bounds(path: Path) -> Bounds:
    """Return the bounds of a file; see `parse_bounds`."""
    try:
        return parse_bounds(str(path), path.read_text("utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), "", None, "cannot be read", "give a TOML file") from error


def places_of(image: Image, loop: Loop) -> list[Place]:
    """Return where the source has the ends of a loop: its latches first, then its head."""
    found = image.places([*loop.latches, loop.head])
    return [stack[0] for stack in found.values() if stack]


def tests_at_top(flow: Flow, loop: Loop) -> bool:
    """Return whether the head runs once more than the body: it decides before the body begins."""
    at = loop.head
    while len(flow.successors[at]) == 1 and flow.successors[at][0] in loop.nodes:
        at = flow.successors[at][0]
        if at == loop.head:
            return False
    leaves = any(after not in loop.nodes for after in flow.successors[at])
    return leaves and at not in loop.latches


def head_runs(flow: Flow, loop: Loop, places: list[Place], bounds: Bounds) -> int | None:
    """Return how often the head of a loop runs at most per entry; None: no bound is given."""
    # What the compiler makes of a function for some of its callers has a name behind a full stop.
    names = {place.function.partition(".")[0] for place in places}
    given = [bounds[name].rounds for name in names if name in bounds]
    return max(given) + tests_at_top(flow, loop) if given else None
