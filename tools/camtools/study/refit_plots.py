"""Pictures of the refit study: contour, velocity, acceleration and jerk, all deletions.

>>> from camtools.plots.style import BLUE
>>> _COLOURS[0] == BLUE
True
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import omega_rad_s
from camtools.plots.panels import pictures, stacked
from camtools.plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, new_figure
from camtools.skirt.geometry.refit import PAPER_JERK_LIMIT_MM_S3, ellipse_steps, refit
from camtools.study.refit import PAPER_JERK_MM_S3, Study

_COLOURS = (BLUE, ORANGE, RED, PURPLE)
_ROOM_DEG, _N_ANGLES = 12.0, 2401
_UM_PER_MM, _MM_PER_M, _MM_PER_KM = 1000.0, 1000.0, 1e6


def draw_motion(found: Study) -> Figure:
    """Return deviation from the drawing, velocity, acceleration and jerk of the variants."""
    joint, omega = found.joint, omega_rad_s(found.spindle_rpm)
    joint_deg = float(np.degrees(joint.joint_rad))
    deg = joint_deg + np.linspace(-_ROOM_DEG, _ROOM_DEG, _N_ANGLES)
    phi = np.radians(deg)
    figure = new_figure(9, 11)
    names = ["deeper than\nthe drawing, µm", "U velocity, mm/s", "U acceleration, m/s²"]
    panels = stacked(figure, [*names, "U jerk, km/s³"])
    drawn = joint.reduction(phi)
    panels[1].plot(deg, drawn.d1 * omega, color=GREEN, ls="--", lw=1.2, label="drawing")
    for one, colour in zip(found.variants, _COLOURS, strict=True):
        curve = refit(joint, one.recipe, ellipse_steps(float(joint.joint_rad)))
        style: dict[str, Any] = {"color": colour, "lw": 1.4, "label": one.name}
        panels[0].plot(deg, (curve(phi) - drawn.delta) * _UM_PER_MM, **style)
        panels[1].plot(deg, curve(phi, 1) * omega, **style)
        panels[2].plot(deg, curve(phi, 2) * omega**2 / _MM_PER_M, **style)
        panels[3].plot(deg, curve(phi, 3) * omega**3 / _MM_PER_KM, **style)
    for axes in panels:
        axes.axvline(joint_deg, color=GREY, lw=1, ls=":")
    panels[0].set_title(f"height {found.height_mm:g} mm, {found.spindle_rpm:g} r/min")
    panels[1].legend(frameon=False, fontsize=9)
    panels[-1].set_xlabel("angle from the long axis, degrees; dotted: the joint")
    panels[-1].set_xlim(deg[0], deg[-1])
    return figure


def draw_deletions(found: Study) -> Figure:
    """Return jerk behind the corner, peak acceleration and deviation of all 16 deletions."""
    figure = new_figure(10, 8.4)
    names = ("largest jerk behind\nthe corner, mm/s³", "peak acceleration,\nm/s²", "deviation, µm")
    panels = stacked(figure, names)
    x = np.arange(len(found.as_paper))
    jerks = [one.tail_jerk_mm_s3 for one in found.as_paper]
    panels[0].bar(x - 0.2, jerks, color=BLUE, width=0.38, label="ours")
    if found.is_papers:
        panels[0].bar(x + 0.2, PAPER_JERK_MM_S3, color=ORANGE, width=0.38, label="paper, Table 1")
    panels[0].axhline(PAPER_JERK_LIMIT_MM_S3, color=RED, lw=1.2, ls="--", label="the paper's limit")
    panels[0].set_yscale("log")
    panels[0].legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    for shift, colour, name, found_here in (
        (-0.2, BLUE, "the paper's construction", found.as_paper),
        (0.2, PURPLE, "mirror ends (production)", found.mirror),
    ):
        peaks = [one.acceleration_mm_s2 / _MM_PER_M for one in found_here]
        panels[1].bar(x + shift, peaks, color=colour, width=0.38, label=name)
        off = [one.deviation_um for one in found_here]
        panels[2].bar(x + shift, off, color=colour, width=0.38)
    panels[1].legend(frameon=False)
    for axes in panels:
        axes.grid(visible=False, axis="x")
    panels[-1].set_xticks(x, [f"{one.s1}, {one.s2}" for one in found.as_paper])
    panels[-1].set_xlabel("points left out on the ellipse's side, on the circle's side")
    return figure


def draw_all(found: Study) -> dict[str, bytes]:
    """Return all pictures as PNG by topic."""
    return pictures(
        {
            "refit_motion": lambda: draw_motion(found),
            "refit_deletions": lambda: draw_deletions(found),
        }
    )
