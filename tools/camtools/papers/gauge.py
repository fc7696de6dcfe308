"""The virtual gauge behind Fig 8 of S2: sections cut on the simulator, beside the drawing.

>>> fold_deg(np.array([0.1, 0.3, 0.6, 0.9])).round(6).tolist()
[36.0, 72.0, 36.0, 36.0]
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.papers.rows import part_of
from camtools.sim.camsim import SURFACE, Simulator, machine_text
from camtools.sim.results import read_surface
from camtools.skirt.geometry.refit import Recipe
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.part.section_keys import Refit
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import generate
from camtools.table.summary import table_files

PART = "weichai3a_measured"
_N_BINS = 900  # of a quarter turn; some hold no point of the map of the surface
_UM_PER_MM = 1000.0


class Record(NamedTuple):
    """A section as the simulated gauge draws it, averaged over the skirt and its quadrants."""

    name: str
    deg: Floats  # shape (n,), rising
    reduction_um: Floats  # of the radius from the long half axis
    off_um: Floats  # deeper than the drawing
    control_um: float  # largest distance of the gauged points from the spline that was played


def fold_deg(turn: Floats) -> Floats:
    """Return the angle of the first quadrant that has the same radius [degrees]."""
    half = np.mod(360 * turn, 180)
    return np.asarray(np.minimum(half, 180 - half), dtype=np.float64)


def with_recipe(part: SkirtPart, recipe: Recipe) -> SkirtPart:
    """Return the part with another refit of its corner."""
    tree = {"spline": recipe.spline, "delete": [recipe.s1, recipe.s2], "ends": recipe.ends}
    section = part.piston.section.model_copy(update={"refit": Refit.model_validate(tree)})
    piston = part.piston.model_copy(update={"section": section})
    return part.model_copy(update={"piston": piston})


def cut_record(name: str, recipe: Recipe, mode_hz: float = 0.0) -> Record:
    """Cut the measured skirt with a refit; return its record.

    Parameters
    ----------
    mode_hz : float, optional
        frequency at which the tool swings on its slide, 10 .. 20000; by default it is rigid

    Raises
    ------
    CamtoolsError
        No table can be made, or the cut did not come to its end.
    """
    part = with_recipe(part_of(PART, SkirtPart), recipe)
    made = generate(part)
    with tempfile.TemporaryDirectory(prefix="camturn-papers.") as place:
        folder = Path(place)
        for file, data in table_files(made.table, make_summary(made)).items():
            (folder / file).write_bytes(data)
        machine = machine_text(part.machine.limits)
        machine = machine.replace("[u]\n", f"[u]\nmode_hz = {mode_hz!r}\n")
        (folder / "machine.toml").write_text(machine, encoding="ascii")
        simulator = Simulator(folder, f"{made.table.part_name}.camtab")
        words = ["--machine", "machine.toml", "--tolerance-um", "1000", "--surface", SURFACE]
        if simulator.run(words).status != 0:
            problem = f"{name}: the simulator did not cut it; the line above says why"
            raise CamtoolsError([f"{problem}; run tools/run tools/parts/{PART}.toml"])
        surface = read_surface(folder / SURFACE)
    corner = made.geometry.corner
    assert corner is not None
    long_mm = made.geometry.radius_mm(surface.z_mm)
    drawn = corner.delta(2 * np.pi * surface.turn, surface.z_mm).delta
    reduction = long_mm - surface.radius_mm
    columns = [one * _UM_PER_MM for one in (reduction, reduction - drawn)]
    played = made.geometry.delta(2 * np.pi * surface.turn, surface.z_mm).delta
    control_um = float(np.abs(reduction - played).max()) * _UM_PER_MM
    deg, *means = _over_quadrant(fold_deg(surface.turn), columns)
    return Record(name, deg, means[0], means[1], control_um)


def _over_quadrant(deg: Floats, columns: Sequence[Floats]) -> list[Floats]:
    """Return the middles of all bins, and the means in the bins that hold points, joined there."""
    _, place = np.unique((deg * _N_BINS / 90).astype(np.int64), return_inverse=True)
    counts = np.bincount(place)
    at, *found = (np.bincount(place, one) / counts for one in (deg, *columns))
    middles = (np.arange(_N_BINS, dtype=np.float64) + 0.5) * 90 / _N_BINS
    return [middles, *(np.interp(middles, at, one) for one in found)]


def cut_records(recipes: Sequence[tuple[str, Recipe]], mode_hz: float = 0.0) -> list[Record]:
    """Return the records of the measured skirt, one for each refit; `mode_hz` as above."""
    return [cut_record(name, recipe, mode_hz) for name, recipe in recipes]
