"""All that is known about the cut of a skirt.

>>> Even._fields[:2]
('summary', 'uniform_summary')
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from camtools.base.json_text import Json
from camtools.sim.results import Cut, GaugedSurface, Removal
from camtools.skirt.table.generate import GeneratedSkirt


class Even(NamedTuple):
    """Equal-volume turning beside uniform turning of the same part at the same mean speed."""

    summary: Json
    uniform_summary: Json
    removal: Removal
    uniform_removal: Removal


@dataclass(frozen=True, eq=False)
class SkirtOutcome(Cut[GeneratedSkirt]):
    """All that is known about the cut of a skirt.

    Attributes
    ----------
    even : Even or None
        Removal rate and forces of a part that is turned with equal volumes.
    control : GaugedSurface or None
        The controller's own errors, where the table plays a refit or a filter of the drawing.
    """

    even: Even | None = None
    control: GaugedSurface | None = None
