"""The paper on ellipse and eccentric circle, S2: the refit, calculated, and cut and gauged.

>>> [f"{um:.2f}" for um in radius_um(curve_of(measured(), DELETED))]
['-5.28', '-20.47', '-43.75', '-72.31', '-99.61']
>>> fold_deg(np.array([0.1, 0.3, 0.6, 0.9])).round(6).tolist()
[36.0, 72.0, 36.0, 36.0]
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import UM_PER_MM, Floats
from camtools.base.text import Columns
from camtools.papers import refit
from camtools.papers.declared import corner_of, declared, part_of, printed
from camtools.papers.refit import CUBIC, DELETED, curve_of
from camtools.sim.machine_file import Machine, machine_text
from camtools.sim.simulate import simulate
from camtools.skirt.geometry.corner import Recipe, deviation_mm
from camtools.skirt.geometry.sections import Joint
from camtools.skirt.part.keys import Refit
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import generate
from camtools.table.summary import table_files

KEY = "S2"
_CASE = declared(KEY).case
RECORDS = {  # of Fig 8
    "before: cubic spline": CUBIC,
    "by hand: quintic, (1, 1) deleted": Recipe("quintic", 1, 1, "as-paper"),
    "after: quintic, (3, 3) deleted": DELETED,
}
BEST = {  # of Table 1, least jerk first
    f"({s1}, {s2})": Recipe("quintic", s1, s2, "as-paper") for s1, s2 in ((3, 3), (2, 2), (3, 2))
}
_TABLE_2_DEG = (10.0, 20.0, 30.0, 40.0, 48.0)
_N_BINS = 900  # of a quarter turn; some hold no point of the map of the surface


@cache
def theory() -> refit.Study:
    """Return the study of the section of the paper's theory part."""
    height_mm = _CASE["height_mm"]
    return refit.study(corner_of(_CASE["theory"]).joint(height_mm), height_mm, _CASE["theory_rpm"])


@cache
def measured() -> Joint:
    """Return the section that reproduces the paper's measurements."""
    return corner_of(_CASE["measured"]).joint(10.0)


def radius_um(reduction_mm: Callable[[Floats], Floats]) -> Floats:
    """Return the radius over the long half axis at the angles of Table 2."""
    return np.asarray(-UM_PER_MM * reduction_mm(np.radians(_TABLE_2_DEG)), dtype=np.float64)


def drawn_um() -> Floats:
    """Return the radius as drawn over the long half axis at the angles of Table 2."""
    return radius_um(lambda phi: measured().reduction(phi).delta)


class Record(NamedTuple):
    """A section as the simulated gauge draws it, averaged over the skirt and its quadrants."""

    name: str
    deg: Floats  # shape (n,), rising
    reduction_um: Floats  # of the radius from the long half axis
    off_um: Floats  # deeper than the drawing
    spline_um: Floats  # the same of the calculated spline
    control_um: float  # largest distance of the gauged points from the spline that was played


def fold_deg(turn: Floats) -> Floats:
    """Return the angle of the first quadrant that has the same radius [degrees]."""
    half = np.mod(360 * turn, 180)
    return np.asarray(np.minimum(half, 180 - half), dtype=np.float64)


def cut_record(name: str, recipe: Recipe, mode_hz: float = 0.0) -> Record:
    """Cut the measured skirt with a refit; return its record.

    The tool swings on its slide at 10 .. 20000 Hz, or is rigid at 0. Raises CamtoolsError where no
    table can be made, or the cut did not come to its end.
    """
    part = part_of(_CASE["measured"], SkirtPart)
    tree = {"spline": recipe.spline, "delete": [recipe.s1, recipe.s2], "ends": recipe.ends}
    section = part.piston.section.model_copy(update={"refit": Refit.model_validate(tree)})
    piston = part.piston.model_copy(update={"section": section})
    made = generate(part.model_copy(update={"piston": piston}))
    machine = machine_text(part.machine.limits).replace("[u]\n", f"[u]\nmode_hz = {mode_hz!r}\n")
    with TemporaryDirectory(prefix="camturn-papers.") as folder:
        for file, data in table_files(made.table, make_summary(made)).items():
            Path(folder, file).write_bytes(data)
        table = Path(folder, f"{made.table.part_name}.camtab")
        options = ["--tolerance-um", "1000"]
        result = simulate(table, Machine("machine", machine), options=options)
    if result.status != 0:
        problem = f"{name}: the simulator did not cut it: {result.message}"
        raise CamtoolsError([f"{problem}; run tools/run tools/parts/{_CASE['measured']}.toml"])
    surface, corner = result.surface, made.geometry.corner
    assert corner is not None
    phi, z_mm = 2 * np.pi * surface["turn"], surface["z_mm"]
    reduction = made.geometry.radius_mm(z_mm) - surface["radius_mm"]
    off = reduction - corner.delta(phi, z_mm).delta
    played = reduction - made.geometry.delta(phi, z_mm).delta
    # Means in the bins that hold points, joined at the middles of all bins.
    fold = fold_deg(surface["turn"])
    _, place = np.unique((fold * _N_BINS / 90).astype(np.int64), return_inverse=True)
    at, *means = (
        np.bincount(place, values) / np.bincount(place) for values in (fold, reduction, off)
    )
    deg = (np.arange(_N_BINS, dtype=np.float64) + 0.5) * 90 / _N_BINS
    reduction_um, off_um = (UM_PER_MM * np.interp(deg, at, mean) for mean in means)
    rad = np.radians(deg)
    spline = curve_of(measured(), recipe)(rad) - measured().reduction(rad).delta
    control_um = float(np.abs(played).max()) * UM_PER_MM
    return Record(name, deg, reduction_um, off_um, UM_PER_MM * spline, control_um)


@cache
def records(mode_hz: float = 0.0) -> list[Record]:
    """Return the records of Fig 8; `mode_hz` as above."""
    return [cut_record(name, recipe, mode_hz) for name, recipe in RECORDS.items()]


def _before_um() -> Floats:
    record = records(_CASE["stiff_hz"])[0]
    return -np.interp(_TABLE_2_DEG, record.deg, record.reduction_um)


def quantities() -> dict[str, Any]:
    """Return the quantities of the rows."""
    joint, curves = theory().joint, [curve_of(measured(), recipe) for recipe in RECORDS.values()]
    rigid_um = [
        UM_PER_MM * float(np.abs(deviation_mm(measured(), curve)[1]).max()) for curve in curves
    ]
    soft_um, stiff_um = (
        [float(np.abs(record.off_um).max()) for record in records(_CASE[name])]
        for name in ("soft_hz", "stiff_hz")
    )
    jerks = theory().tail_jerk_mm_s3
    return refit.quantities(theory()) | {
        "e_mm": float(joint.arc().eccentricity_mm),
        "r_mm": float(joint.arc().radius_mm),
        "diameter_mm": 2 * float(joint.a_mm),
        "best_mm_s3": [jerks[4 * recipe.s2 + recipe.s1] for recipe in BEST.values()],
        "drawn_um": drawn_um(),
        "measured_um": radius_um(curves[2]),
        "before_um": _before_um(),
        "rigid_um": rigid_um,
        "after_um": rigid_um[2],
        "soft_um": soft_um,
        "stiff_um": stiff_um,
        "process": part_of(_CASE["measured"], SkirtPart).process,
    }


def _table_1() -> Columns:
    fits, jerks, table = theory().as_paper, theory().tail_jerk_mm_s3, printed(KEY, "table_1_mm_s3")
    return {
        "s1": ([fit.s1 for fit in fits], "d"),
        "s2": ([fit.s2 for fit in fits], "d"),
        "jerk_mm_s3": (jerks, ".4g"),
        "paper_mm_s3": (table, ".4g"),
        "ratio": (jerks / table, ".3f"),
        "peak_acceleration_mm_s2": ([fit.acceleration_mm_s2 for fit in fits], ".0f"),
        "peak_deg": ([fit.peak_deg for fit in fits], ".2f"),
        "deviation_um": ([fit.deviation_um for fit in fits], ".3f"),
    }


def _table_2() -> Columns:
    measured_um, paper_um = radius_um(curve_of(measured(), DELETED)), printed(KEY, "measured_um")
    return {
        "angle_deg": (_TABLE_2_DEG, "g"),
        "drawn_um": (drawn_um(), ".2f"),
        "paper_drawn_um": (printed(KEY, "drawn_um"), "g"),
        "before_um": (_before_um(), ".2f"),
        "refit_um": (measured_um, ".2f"),
        "paper_measured_um": (paper_um, "g"),
        "difference_um": (measured_um - paper_um, 2),
    }


def fig_8() -> Columns:
    """Return the records beside the splines that were played."""
    deg = records()[0].deg
    drawn = UM_PER_MM * measured().reduction(np.radians(deg)).delta
    columns = {"angle_deg": (deg, 3), "drawn_reduction_um": (drawn, 3)}
    for name, record in zip(("before", "by_hand", "after"), records(), strict=True):
        columns[f"{name}_spline_um"] = (record.spline_um, 3)
        columns[f"{name}_cut_um"] = (record.off_um, 3)
    return columns


TABLES = {"s2_table_1.csv": _table_1, "s2_table_2.csv": _table_2, "s2_fig_8.csv": fig_8}
