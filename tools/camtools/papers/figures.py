"""The pictures of an analysis by topic, and those of the papers by file.

>>> sorted(PICTURES)
['S0, S1', 'S2', 'S3', 'S4']
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from camtools.papers import corner, helix, lobe, refit, removal, section
from camtools.papers.declared import corner_of, geometry_of
from camtools.papers.drawings import (
    draw_design,
    draw_follower,
    draw_parts,
    draw_points,
    draw_profile,
    draw_records,
    draw_section,
    draw_sketch,
    draw_skirts,
    draw_steps,
    draw_unrolled,
    title_of,
)
from camtools.papers.pictures import draw_table
from camtools.plots.style import Drawers
from camtools.skirt.geometry.corner import Recipe

_ROOM_DEG = 12.0  # beside the joint


def section_drawers(study: section.Analysis) -> Drawers:
    """Return the makers of the pictures of an analysis."""
    rpm = f"mean {study.rpm:g} r/min"
    titles = {
        "area": "what is cut in equal steps of angle",
        "speed": f"spindle at constant removal rate, {rpm}",
        "motion": f"U over one turn in time, {rpm}",
        "forces": f"forces, kc = {study.wishes.kc_n_mm2:g} N/mm²",
        "harmonics": "waves of U in time",
    }
    all_of, turn = section.tables(study), section.turn(study)
    steps = {name: (values[1:], form) for name, (values, form) in all_of["depth_and_area"].items()}
    found = {"area": steps, "harmonics": all_of["harmonics"]}
    named = {
        topic: partial(draw_table, topic, title_of(study, title), {"": found.get(topic, turn)})
        for topic, title in titles.items()
    }
    return {"parts": partial(draw_parts, study), **named}


def refit_drawers(found: refit.Study) -> Drawers:
    """Return the makers of the pictures of the refits of a section."""
    title = f"height {found.height_mm:g} mm, {found.spindle_rpm:g} r/min"
    joint_deg = float(np.degrees(found.joint.joint_rad))
    near = refit.motion(found, refit.VARIANTS, joint_deg - _ROOM_DEG, joint_deg + _ROOM_DEG)
    names = [f"{fit.s1}, {fit.s2}" for fit in found.as_paper]
    candidates = refit.tables(found)["refit_candidates"]
    bars = {**candidates, "points_left_out_on_both_sides": (names, "")}
    return {
        "refit_motion": partial(draw_table, "corner", title, near),
        "refit_deletions": partial(draw_table, "deletions", title, {"": bars}),
    }


def lobe_drawers(name: str, studies: Sequence[lobe.LobeStudy]) -> Drawers:
    """Return the makers of the pictures of a camshaft."""
    is_turned = studies[0].operation == "turning"
    subject = "tool swung about the roller's centre" if is_turned else "wheel and speed of the cam"
    tables = {f"lobe {study.number}": lobe.lobe_columns(study) for study in studies}
    motion, contact = f"{name}: {subject}", f"{name}: where the follower touches"
    return {
        "lobe_motion": partial(draw_table, studies[0].operation, motion, tables),
        "lobe_contact": partial(draw_table, "contact", contact, tables),
    }


def _of_removal() -> Drawers:
    drawers, drawn = section_drawers(removal.analysis()), geometry_of(removal.PART)
    both = {
        "ovality times 30 (S0)": geometry_of(removal.CASE["ovality_x30"]),
        "ovality and profile times 30 (S1)": geometry_of(removal.CASE["all_x30"]),
    }
    return {
        "s0_fig_1.png": partial(draw_design, removal.PART, "design points of the skirt"),
        "s0_fig_5.png": partial(draw_steps, removal.analysis()),
        "s0_figs_6_8.png": drawers["area"],
        "s0_fig_9.png": lambda: draw_profile(drawn, removal.widest_mm()[0]),
        "s0_figs_10_13.png": drawers["parts"],
        "s0_fig_14.png": partial(draw_skirts, {"as drawn": drawn}),
        "s0_fig_15.png": partial(draw_skirts, both),
        "s1_fig_6.png": drawers["forces"],
    }


def _of_corner() -> Drawers:
    theory = corner.theory()

    def motion(topic: str, recipes: dict[str, Recipe]) -> Callable[[], Figure]:
        title = f"first quadrant at {theory.spindle_rpm:g} r/min: {' and '.join(recipes)}"
        return lambda: draw_table(topic, title, refit.motion(theory, recipes, 0, 90))

    cubic, deleted = {"cubic spline": refit.CUBIC}, {"quintic, (3, 3) deleted": refit.DELETED}
    return {
        "s2_fig_1.png": partial(draw_section, theory.joint, "ellipse and eccentric circle"),
        "s2_fig_2.png": motion("quadrant", cubic),
        "s2_fig_3.png": motion("quadrant", {"quintic spline": refit.QUINTIC}),
        "s2_fig_4.png": motion("jerk", corner.BEST),
        "s2_fig_6.png": motion("quadrant", deleted),
        "s2_fig_7.png": motion("quadrant", cubic | deleted),
        "s2_fig_8.png": draw_records,
    }


def _of_helix() -> Drawers:
    few, title = helix.CASE["few_mm"], "reduction of the diameter, mm"
    return {
        "s3_figs_1_2_4_5.png": partial(draw_design, helix.PART, "drawing and splines"),
        "s3_fig_3.png": lambda: draw_section(corner_of(helix.PART).joint(20.0), "section at 20 mm"),
        "s3_fig_6.png": lambda: draw_sketch(helix.point_matrix(few, 4)),
        "s3_fig_7.png": lambda: draw_points(helix.point_matrix(few, 4), is_part=True),
        "s3_fig_8.png": lambda: draw_points(helix.point_matrix(few), is_part=False),
        "s3_fig_9.png": lambda: draw_table("reduction", title, {"": helix.sections()}),
        "s3_fig_10.png": lambda: draw_unrolled(helix.point_matrix(few)),
    }


def _of_cams() -> Drawers:
    turned, ground, i = lobe.studied("turned"), lobe.studied("ground"), lobe.index()
    title = f"tool at {turned.rpm:g} r/min"
    return {
        "s4_fig_1.png": partial(draw_follower, turned, i),
        "s4_fig_2.png": lambda: draw_table("swing", title, {"": lobe.lobe_columns(turned.dense())}),
        "s4_fig_3.png": partial(draw_follower, ground, i),
    }


PICTURES: dict[str, Callable[[], Drawers]] = {
    removal.KEY: _of_removal,
    corner.KEY: _of_corner,
    helix.KEY: _of_helix,
    lobe.KEY: _of_cams,
}
