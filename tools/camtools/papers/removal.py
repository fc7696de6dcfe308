"""The papers on equal removal, S0 and S1: figures and tables of the Perkins skirt.

>>> [row.item for row in chapter().rows][:3]
['Fig 1, Tables 2, 3', 'Fig 5', 'Table 1']
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.optimize import brentq

from camtools.base.csv_text import csv_text
from camtools.cut.removal import PartsRange, SectionCut, parts_range
from camtools.papers import removal_plots as plots
from camtools.papers.rows import Chapter, Maker, Row, part_of, png, um
from camtools.skirt.geometry.sections import DoubleEllipse
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.study import section_tables
from camtools.study.section import Analysis, AnalysisWishes, make_analysis

HEIGHT_MM = 20.0  # of the papers' section
MEAN_RPM = 1667.27  # 2500 r/min at the long axis
FEED_MM, VOLUME_MM3, CYCLE_S = 0.1, 0.04, 50e-6
_N_DENSE = 2001


@cache
def analysis() -> Analysis:
    """Return the analysis of the papers' section: height 20 mm, 30 parts."""
    return make_analysis(part_of("perkins240", SkirtPart), AnalysisWishes(rpm=MEAN_RPM))


@cache
def geometry_of(name: str) -> Geometry:
    """Return the geometry of a part of the repository."""
    return make_geometry(part_of(name, SkirtPart))


def widest_mm() -> tuple[float, float]:
    """Return height and diameter where the fitted profile is widest."""
    geometry = geometry_of("perkins240")
    z_mm = float(brentq(lambda z: float(geometry.radius_mm(z, 1)), 19.5, 20.5, xtol=1e-13))
    return z_mm, 2 * float(geometry.radius_mm(z_mm))


def possible_parts() -> PartsRange:
    """Return the bounds on the number of parts of the papers' example."""
    return parts_range(analysis().cut, FEED_MM, MEAN_RPM, VOLUME_MM3, CYCLE_S)


def cosine_area_mm2() -> float:
    """Return the area of the quadrant for the cosine form of the same section."""
    cut, g_mm = analysis().cut, float(geometry_of("perkins240").ovality_mm(HEIGHT_MM))
    form = DoubleEllipse(0.0)
    return SectionCut(
        lambda phi: form.evaluate(phi, cut.a_mm, g_mm), cut.a_mm, cut.blank_mm
    ).total_mm2


def chip_ratio() -> float:
    """Return the largest over the least section of the chip, at any law of speed."""
    depth = analysis().cut.depth_mm(np.linspace(0, np.pi / 2, _N_DENSE))
    return float(depth.max() / depth.min())


def _design_csv() -> bytes:
    piston = part_of("perkins240", SkirtPart).piston
    geometry = geometry_of("perkins240")
    heights = np.array(piston.profile.height_mm, dtype=np.float64)
    long_mm, oval_mm = 2 * geometry.radius_mm(heights), geometry.ovality_mm(heights)
    columns = {"height_mm": (heights, 3), "long_axis_mm": (long_mm, 3), "ovality_mm": (oval_mm, 6)}
    return csv_text(columns).encode()


def _axes_csv() -> bytes:
    """Return Table 5: C, X, Z, U of the 30 parts of the first quarter turn."""
    lines = section_tables.axes_equal_volume(analysis()).splitlines()
    return ("\n".join(lines[:32]) + "\n").encode()


def _files() -> dict[str, Maker]:
    def csv(make: str) -> Maker:
        return lambda: str(getattr(section_tables, make)(analysis())).encode()

    skirt, all_30, oval_30 = "perkins240", "perkins240_x30", "perkins240_x30_ovality"
    return {
        "s0_tables_2_3.csv": _design_csv,
        "s0_table_1.csv": csv("depth_and_area"),
        "s0_table_4.csv": csv("equal_parts"),
        "s0_table_5.csv": _axes_csv,
        "s1_fig_6.csv": csv("forces"),
        "s0_fig_1.png": png(lambda: plots.draw_design(part_of(skirt, SkirtPart))),
        "s0_fig_5.png": png(lambda: plots.draw_quadrant(analysis())),
        "s0_figs_6_8.png": png(lambda: plots.draw_steps(analysis())),
        "s0_fig_9.png": png(lambda: plots.draw_profile(geometry_of(skirt), widest_mm()[0])),
        "s0_figs_10_13.png": png(lambda: plots.draw_parts(analysis())),
        "s0_fig_14.png": png(lambda: plots.draw_skirts({"as drawn": geometry_of(skirt)})),
        "s0_fig_15.png": png(
            lambda: plots.draw_skirts(
                {
                    "ovality times 30 (S0)": geometry_of(oval_30),
                    "ovality and profile times 30 (S1)": geometry_of(all_30),
                }
            )
        ),
        "s1_fig_6.png": png(lambda: plots.draw_force(analysis())),
    }


def _steps_rows() -> list[Row]:
    steps = analysis().steps
    widest = int(np.argmax(steps.change_mm))
    file, deg = "s0_figs_6_8.png", np.degrees(steps.phi_rad)
    return [
        Row(
            *("Fig 5", "the first quadrant in steps of 3 degrees", "30 steps"),
            f"{steps.phi_rad.size - 1} steps, {analysis().cut.total_mm2:.9f} mm2 in all",
            f"the area is not printed; whether the paper's section is exact or its cosine form, "
            f"{cosine_area_mm2():.9f} mm2, cannot be told",
            "s0_fig_5.png",
        ),
        Row(
            *("Table 1", "depth, its change, area of each step", "depth and area rise"),
            f"0 .. 3 degrees {steps.area_mm2[1]:.6f} mm2, 87 .. 90 degrees "
            f"{steps.area_mm2[-1]:.6f} mm2",
            "as the text says; the printed table is a picture. Areas need the polar angle: with "
            "(a b / 2) angle all steps would be equal",
            "s0_table_1.csv",
        ),
        Row(
            *("Fig 6", "depth of cut", "rises"),
            f"{steps.depth_mm[0]:.6f} .. {steps.depth_mm[-1]:.6f} mm",
            *("none", file),
        ),
        Row(
            *("Fig 7", "change of depth per step", "largest near 45 degrees"),
            f"{um(float(steps.change_mm[widest]), 4)} from {deg[widest - 1]:.0f} to "
            f"{deg[widest]:.0f} degrees",
            *("none", file),
        ),
        Row(
            *("Fig 8", "area per step", "rises"),
            f"1 : {steps.area_mm2[-1] / steps.area_mm2[1]:.6f}",
            *("none", file),
        ),
    ]


def _parts_rows() -> list[Row]:
    parts, file = analysis().parts, "s0_figs_10_13.png"
    deg, width = np.degrees(parts.phi_rad), np.degrees(parts.width_rad)
    widest = int(np.argmax(parts.change_mm))
    return [
        Row(
            *("Table 4 (S1 Table 3)", "30 parts of equal area", "30 parts"),
            f"{parts.phi_rad.size} parts of {analysis().cut.total_mm2 / 30:.9f} mm2",
            *("the printed table is a picture", "s0_table_4.csv"),
        ),
        Row(
            *("Fig 10 (S1 Fig 5a)", "angle of each part", "falls"),
            *(f"{width[0]:.6f} .. {width[-1]:.6f} degrees", "none", file),
        ),
        Row(
            *("Fig 11", "angle turned", "0 .. 90 degrees"),
            *(f"{deg[0]:.6f} .. {deg[-1]:.6f} degrees", "none", file),
        ),
        Row(
            *("Fig 12 (S1 Fig 5b)", "change of depth per part", 'largest "near 8 degrees"'),
            f"{um(float(parts.change_mm[widest]), 4)} in part {widest + 1}, "
            f"{deg[widest - 1]:.2f} .. {deg[widest]:.2f} degrees",
            f"8 is the number of the part, counted from 0 ({widest} here), not an angle",
            file,
        ),
        Row(
            *("Fig 13 (S1 Fig 5c)", "depth at the end of each part", "rises"),
            f"{parts.depth_mm[0]:.7f} .. {parts.depth_mm[-1]:.7f} mm",
            *("none", file),
        ),
    ]


def _axes_row() -> Row:
    last = _axes_csv().decode().splitlines()[-1].split(",")
    return Row(
        *("Table 5 (S1 Table 4)", "C, X, Z, U of each part at height 20", "equal times"),
        f"after {float(last[0]) * 1000:.4f} ms: C {float(last[1]):.4f} degrees, Z {last[2]}, "
        f"X {last[3]}, U {last[4]} mm",
        "the printed table is a picture; Z follows the angle, with the time it would wobble",
        "s0_table_5.csv",
    )


def _skirt_rows() -> list[Row]:
    z_mm, widest = widest_mm()
    skirt, all_30, oval_30 = (
        geometry_of(name) for name in ("perkins240", "perkins240_x30", "perkins240_x30_ovality")
    )
    top = [2 * float(one.radius_mm(62.0)) for one in (skirt, oval_30, all_30)]
    oval = [float(one.ovality_mm(62.0)) for one in (skirt, oval_30, all_30)]
    first = Row(
        "Fig 1, Tables 2, 3",
        "long axis and ovality against height",
        "92 mm at 20, least 0.263 mm less; ovality 0.20 at 20, at most 0.3 mm",
        f"{2 * float(skirt.radius_mm(20.0)):.3f} mm at 20, {top[0]:.3f} mm at 62; ovality "
        f"{float(skirt.ovality_mm(20.0)):.2f} at 20, {oval[0]:.2f} mm at 62",
        "none; the printed tables are pictures, the other points are invented to fit",
        "s0_tables_2_3.csv` `s0_fig_1.png",
    )
    fitted = Row(
        *("Fig 9 (S1 Fig 4)", "fitted profile", "largest at height 20"),
        f"{widest:.9f} mm at {z_mm:.6f} mm",
        "5 um along Z: the spline's top is not its node; the slopes at the ends are not printed",
        "s0_fig_9.png",
    )
    cut = Row(
        *("Fig 14 (S1 Fig 8)", "the skirt", "a picture"),
        f"{top[0]:.3f} mm and ovality {oval[0]:.2f} mm at 62",
        "none; `tools/run tools/parts/perkins240.toml` cuts it on the simulator",
        "s0_fig_14.png",
    )
    larger = Row(
        *("Fig 15 (S1 Fig 9)", "the same, 30 times", "S0: ovality alone; S1: profile, too"),
        f"at 62: S0 {top[1]:.3f} mm, {oval[1]:.3f} mm; S1 {top[2]:.3f} mm, {oval[2]:.3f} mm",
        "none; both readings are parts (`magnify.of`)",
        "s0_fig_15.png",
    )
    return [first, fitted, cut, larger]


def _text_rows() -> list[Row]:
    allowed, peaks, rates = possible_parts(), analysis().peaks, analysis().rates
    omega = 2 * np.pi * MEAN_RPM / 60
    stroke_mm = float(geometry_of("perkins240").ovality_mm(62.0)) / 2
    return [
        Row(
            *("text", "number of parts for 0.1 mm and 0.04 mm3", "30 chosen"),
            f"{allowed.least} .. {allowed.most}",
            "a part must not be shorter than the controller's cycle (50 us): the paper has no "
            "upper bound",
            "s0_table_4.csv",
        ),
        Row(
            *("text", "highest speed", "2500 r/min"),
            f"mean {MEAN_RPM} r/min: {MEAN_RPM * peaks.ratio_min:.2f} .. "
            f"{MEAN_RPM * peaks.ratio_max:.2f} r/min, {peaks.alpha * omega**2:.1f} rad/s2",
            "the paper does not say what the spindle needs: sixty times what a lathe has. "
            "`perkins240_papers_speed.toml` is turned by a spindle that has it",
            "s0_table_5.csv",
        ),
        Row(
            *("text", "stroke of U (S1)", "depends on the rate of change of the ovality"),
            f"half the ovality: {stroke_mm:.3f} mm at 62",
            "it depends on the ovality itself, as S0 has it",
            "s0_tables_2_3.csv",
        ),
        Row(
            *("text", "feed", "0.001 mm/r"),
            f"62 mm are {62 / 0.001:.0f} turns, {62 / 0.001 / 2500:.1f} min at 2500 r/min; the "
            f"parts here feed 0.1 mm/r, {62 / 0.1 / 2500 * 60:.1f} s",
            "a hundredth of the feed of turning; no figure depends on it but the time, which "
            "the paper does not print",
            "s0_table_5.csv",
        ),
        Row(
            *("text", "the long axis", "along the pin"),
            *("any", "it is square to the pin in real pistons; no formula changes"),
            "s0_fig_1.png",
        ),
        Row(
            *("S1 Fig 6", "force over a turn", "constant at equal volume"),
            f"proportional to the area per time, as the paper has it: 1 : "
            f"{rates.largest_to_least:.6f} uniform, 1 : 1 at equal volume; section of the chip: "
            f"1 : {chip_ratio():.6f} in both",
            "a force is kc x section of the chip, which no speed changes; removal rate and power "
            "become constant",
            "s1_fig_6.png",
        ),
    ]


def chapter() -> Chapter:
    """Return both papers on equal removal."""
    design, fitted, cut, larger = _skirt_rows()
    rows = [design, *_steps_rows(), fitted, *_parts_rows(), _axes_row(), cut, larger]
    title = "equal-volume turning of the Perkins 240 skirt (S1: the same in Chinese, with forces)"
    return Chapter("S0, S1", title, (*rows, *_text_rows()), _files())
