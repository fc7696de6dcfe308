# SPDX-License-Identifier: Apache-2.0
"""What the outside sees otherwise than before, on purpose: which facts, how, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tests.outside.facts import Fact


@dataclass(frozen=True)
class Improved:
    """Facts that changed on purpose.

    Attributes
    ----------
    facts : str
        names of the facts, with * and ?; a [ stands for itself
    reason : str
        why, in a sentence
    at_most : float
        what a figure is now at most; it must be below the recorded one
    old, new : str
        what is replaced in the recorded text, whose lines are joined by line breaks
    is_now : list of str, str, number
        the whole fact as it is now
    presence : str
        "new" or "gone": facts that were not there, or are not there any more
    """

    facts: str
    reason: str
    at_most: float | None = None
    old: str = ""
    new: str = ""
    is_now: Fact = None
    presence: Literal["", "new", "gone"] = ""


improved: tuple[Improved, ...] = (
    Improved(
        "test --help",
        "Steps run side by side, with progress and a table of the slowest; slow tests are marked.",
        old='4 minutes). Ends with the line "N passed, N failed"; exits 1 if any failed.\n',
        new="4 minutes).\n"
        "> \n"
        "> Independent steps run side by side, one per core; what judges the clock runs by itself. "
        "A line tells\n"
        "> which step begins or has ended, and after how long. What a step says stands in "
        "build/steps; all of\n"
        '> it is shown of a step that fails. Ends with a table of the slowest steps and the line "'
        "N passed,\n"
        '> N failed[, N skipped]"; exits 1 if any failed, 130 or 143 when it is stopped (no '
        "process goes on).\n",
    ),
    Improved(
        "test --help",
        "As above.",
        old="tools and scenarios only",
        new="tools and scenarios only, without those marked slow",
    ),
    Improved(
        "uml --help",
        "The words of a kernel that cannot boot are shown, and a command prints where it lies.",
        old="uml build\n",
        new="uml build | path\n",
    ),
    Improved(
        "uml --help",
        "As above.",
        old="the kernel broke down.",
        new="the kernel broke down, its own words\n"
        ">        are shown and the last line repeats what counts in them "
        "(the panic and its cause).",
    ),
    Improved(
        "uml --help",
        "As above.",
        old="exit status 2.\n",
        new="exit status 2.\n"
        "> path   prints where the kernel lies or would lie, and builds nothing.\n",
    ),
    Improved("uml*", "As above.", old="run or build (", new="run, build or path ("),
    Improved(
        "table cam-345*: source in *",
        "The equations that a part cites are in the repository.",
        old="maths.md 9.5, golden B",
        new="MATHS.md (37)",
    ),
    Improved(
        "table cam-disc: source in *",
        "As above.",
        old="maths.md 9.5, golden A",
        new="MATHS.md (38)",
    ),
    Improved(
        "table camshaft: source in *", "As above.", old="maths.md 9.5", new="MATHS.md (37), (38)"
    ),
    Improved(
        "cut perkins240_equal_volume: removal.rate_ripple.max",
        "One plan every 400 us leads the spindle from ratio to ratio.",
        at_most=0.05,
    ),
)
