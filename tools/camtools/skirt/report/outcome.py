"""All that is known about the cut of a skirt, and uniform turning where volumes are equal.

>>> limited_turns(620.0), limited_turns(62_000.0)
([], ['--turns-limit', '2000'])
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from camtools.base.json_text import Json
from camtools.pipeline.kind import Rig
from camtools.pipeline.part_cut import made_cut
from camtools.sim.results import Cut, GaugedSurface, Removal, removal_of
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.table.summary import table_files

REMOVAL, REMOVAL_UNIFORM = "removal.csv", "removal_uniform.csv"
_TWIN = "uniform"
_MAX_TURNS = 2000  # 120 rows each


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


def limited_turns(turns: float) -> list[str]:
    """Return camsim's words that keep the table of slices small."""
    return [] if turns <= _MAX_TURNS else ["--turns-limit", str(_MAX_TURNS)]


def uniform_twin(generated: GeneratedSkirt) -> GeneratedSkirt:
    """Return the table of the same part at a constant spindle speed."""
    part = generated.part
    process = part.process.model_copy(update={"mode": "uniform"})
    return generate(part.model_copy(update={"process": process}))


def compare_removal(rig: Rig, generated: GeneratedSkirt) -> Even | None:
    """Return removal rate and forces beside those of uniform turning; none of uniform parts.

    Leaves removal.csv and removal_uniform.csv in the working folder.
    """
    if generated.speed is None:
        return None
    twin = Path(_TWIN)
    twin.mkdir()
    twin_table = uniform_twin(generated)
    for name, data in table_files(twin_table.table, make_summary(twin_table)).items():
        (twin / name).write_bytes(data)
    words = [*rig.words, *limited_turns(rig.turns)]
    even, uniform = (
        made_cut(table, words, tables=["removal"], files={file: "removal"})
        for table, file in ((rig.table, REMOVAL), (str(twin / rig.table), REMOVAL_UNIFORM))
    )
    return Even(
        *(even.summary, uniform.summary), removal_of(even.removal), removal_of(uniform.removal)
    )
