"""The papers on equal removal, S0 and S1: the Perkins skirt.

>>> z_mm, diameter_mm = widest_mm()
>>> f"{diameter_mm:.9f} mm at {z_mm:.6f} mm"
'92.000000004 mm at 20.005220 mm'
"""

from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from camtools.base.text import Columns
from camtools.cut.removal import SectionCut
from camtools.papers import section
from camtools.papers.declared import declared, geometry_of, part_of
from camtools.papers.section import Analysis, AnalysisWishes, make_analysis
from camtools.skirt.geometry.sections import double_ellipse
from camtools.skirt.part.part_file import SkirtPart

KEY = "S0, S1"
CASE = declared(KEY).case
PART: str = CASE["part"]
_N_ROWS = 31  # of Table 5, the first quarter turn


@cache
def analysis() -> Analysis:
    """Return the analysis of the papers' section: height 20 mm, 30 parts."""
    return make_analysis(part_of(PART, SkirtPart), AnalysisWishes(rpm=CASE["rpm"]))


def widest_mm() -> tuple[float, float]:
    """Return height and diameter where the fitted profile is widest."""
    geometry = geometry_of(PART)
    z_mm = float(brentq(lambda z: float(geometry.radius_mm(z, 1)), 19.5, 20.5, xtol=1e-13))
    return z_mm, 2 * float(geometry.radius_mm(z_mm))


def _table(name: str, n_rows: int | None = None) -> section.Table:
    """Return a table of the analysis, or its first rows."""
    columns = section.tables(analysis())[name]
    return {key: (values[:n_rows], form) for key, (values, form) in columns.items()}


def quantities() -> dict[str, Any]:
    """Return the quantities of the rows."""
    found, height_mm, top_mm = analysis(), CASE["height_mm"], CASE["top_mm"]
    cut, steps, parts, peaks = found.cut, found.steps, found.parts, found.peaks
    skirts = [geometry_of(CASE[name]) for name in ("part", "ovality_x30", "all_x30")]
    tops = [float(skirt.radius_mm(top_mm)) for skirt in skirts]
    ovals = [float(skirt.ovality_mm(top_mm)) for skirt in skirts]
    long_mm = 2 * float(skirts[0].radius_mm(height_mm))
    ovality_mm = float(skirts[0].ovality_mm(height_mm))
    cosine = SectionCut(
        lambda phi: double_ellipse(phi, cut.a_mm, ovality_mm), cut.a_mm, cut.blank_mm
    )
    widest, step_deg = int(np.argmax(steps.change_mm)), np.degrees(steps.phi_rad)
    widest_z_mm, diameter_mm = widest_mm()
    axes = {name: values[-1] for name, (values, _) in _table("axes_equal_volume", _N_ROWS).items()}
    return {
        "long_mm": long_mm,
        "top_mm": [2 * top for top in tops],
        "least_mm": long_mm - 2 * tops[0],
        "ovality_mm": ovality_mm,
        "top_ovality_mm": ovals,
        "largest_ovality_mm": ovals[0],
        "stroke_mm": ovals[0] / 2,
        "n_steps": steps.phi_rad.size - 1,
        "area_mm2": cut.total_mm2,
        "cosine_area_mm2": cosine.total_mm2,
        "step_mm2": (steps.area_mm2[1], steps.area_mm2[-1]),
        "step_ratio": steps.area_mm2[-1] / steps.area_mm2[1],
        "depth_mm": (steps.depth_mm[0], steps.depth_mm[-1]),
        "change_um": 1000 * steps.change_mm[widest],
        "change_deg": (step_deg[widest - 1], step_deg[widest]),
        "largest_change_deg": step_deg[widest],
        "widest_mm": diameter_mm,
        "widest_z_mm": widest_z_mm,
        "n_parts": parts.phi_rad.size,
        "part_mm2": cut.total_mm2 / parts.phi_rad.size,
        "width_deg": np.degrees((parts.width_rad[0], parts.width_rad[-1])),
        "part_deg": np.degrees((parts.phi_rad[0], parts.phi_rad[-1])),
        "part_um": 1000 * parts.change_mm.max(),
        "at_part": found.at_part,
        "at_part_0": found.at_part - 1,
        "at_part_deg": found.at_part_deg,
        "part_depth_mm": (parts.depth_mm[0], parts.depth_mm[-1]),
        "last": axes | {"t_ms": 1000 * axes["t_s"]},
        "range": found.range,
        "least_rpm": found.rpm * peaks.ratio_min,
        "largest_rpm": found.rpm * peaks.ratio_max,
        "alpha_rad_s2": peaks.alpha * found.omega_rad_s**2,
        "papers_turns": top_mm / 0.001,
        "papers_min": top_mm / 0.001 / 2500,
        "feed_mm": found.feed_mm,
        "time_s": top_mm / found.feed_mm / 2500 * 60,
        "rate_ratio": found.rates.largest_to_least,
        "chip_ratio": found.chip_mm[1] / found.chip_mm[0],
    }


def _design() -> Columns:
    skirt = geometry_of(PART)
    z = np.array(part_of(PART, SkirtPart).piston.profile.height_mm, dtype=np.float64)
    columns = {"height_mm": (z, 3), "long_axis_mm": (2 * skirt.radius_mm(z), 3)}
    return {**columns, "ovality_mm": (skirt.ovality_mm(z), 6)}


TABLES = {
    "s0_tables_2_3.csv": _design,
    "s0_table_1.csv": partial(_table, "depth_and_area"),
    "s0_table_4.csv": partial(_table, "equal_parts"),
    "s0_table_5.csv": partial(_table, "axes_equal_volume", _N_ROWS),
    "s1_fig_6.csv": partial(_table, "forces"),
}
