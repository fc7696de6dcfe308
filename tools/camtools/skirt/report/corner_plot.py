"""Picture of a composite section's corner: drawing, refit and cut, and how U moves across it.

>>> import numpy as np
>>> around_joint(np.array([0.13, 0.37, 0.63]), 48.0).round(1).tolist()
[-1.2, -1.2, -1.2]
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import Floats, omega_rad_s
from camtools.plots.panels import stacked
from camtools.plots.style import BLUE, GREY, ORANGE, RED, new_figure
from camtools.sim.results import CUTTING, CutTrace, GaugedSurface
from camtools.skirt.geometry.composite import fold
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.skirt_geometry import Geometry

_ROOM_DEG = 14.0
_N_ANGLES = 1401
_MAX_POINTS = 120
_DERIVATIVE_TICKS = 2
_UM_PER_MM, _MM_PER_M, _NM_PER_MM = 1000.0, 1000.0, 1e6
_DOTS: dict[str, Any] = {"ls": "", "marker": "o", "ms": 3.2, "mfc": "none", "color": RED}


class Lines(NamedTuple):
    """Curves around the joint, each over `deg`."""

    deg: Floats  # angle from the long axis
    drawn_um: Floats  # radius reduction
    refit_um: Floats
    velocity_mm_s: Floats  # of U along the refit
    acceleration_m_s2: Floats


def around_joint(turn: Floats, joint_deg: float) -> Floats:
    """Return the distance from the joint [deg] of angles of all four quadrants."""
    folded, _ = fold(2 * np.pi * turn)
    return np.degrees(folded) - joint_deg


def lines_at(geometry: Geometry, corner: Corner, z_mm: float, spindle_rpm: float) -> Lines:
    """Return drawing, refit and the motion of U around the joint at a height."""
    joint_deg, omega = float(corner.joint_deg(z_mm)), omega_rad_s(spindle_rpm)
    deg = joint_deg + np.linspace(-_ROOM_DEG, _ROOM_DEG, _N_ANGLES)
    u = geometry.delta(np.radians(deg), z_mm)
    drawn = corner.delta(np.radians(deg), z_mm).delta
    return Lines(
        deg, drawn * _UM_PER_MM, u.delta * _UM_PER_MM, u.d1 * omega, u.d2 * omega**2 / _MM_PER_M
    )


def _cut_points(
    geometry: Geometry, corner: Corner, cut: GaugedSurface, z_mm: float
) -> tuple[Floats, Floats]:
    """Return angle [deg] and distance from the drawing [um] of gauged points near a height."""
    joint_deg = float(corner.joint_deg(z_mm))
    off_deg = around_joint(cut.turn, joint_deg)
    half_band_mm = (geometry.z_last_mm - geometry.z_first_mm) / 100
    near = (np.abs(off_deg) < _ROOM_DEG) & (np.abs(cut.z_mm - z_mm) < half_band_mm)
    rows = np.flatnonzero(near)
    rows = rows[np.argsort(off_deg[rows], kind="stable")]
    rows = rows[:: max(1, rows.size // _MAX_POINTS)]
    return joint_deg + off_deg[rows], -cut.error_um[rows]


def _measured(trace: CutTrace, corner: Corner, z_mm: float) -> tuple[Floats, Floats]:
    """Return angle [deg] and velocity of U [mm/s] in the first quadrant's corner near a height."""
    cutting = np.flatnonzero(trace.state == CUTTING)
    if cutting.size < 2 * _DERIVATIVE_TICKS + 1:
        return np.empty(0), np.empty(0)
    nearest = cutting[int(np.argmin(np.abs(trace.z_mm[cutting] - z_mm)))]
    before = trace.sense if z_mm >= trace.z_mm[cutting[-1]] else 0
    whole = np.floor(trace.turn[nearest]) - before
    deg = 360 * (trace.turn - whole)
    joint_deg, k = float(corner.joint_deg(z_mm)), _DERIVATIVE_TICKS
    rows = np.flatnonzero((np.abs(deg - joint_deg) < _ROOM_DEG) & (trace.state == CUTTING))
    rows = rows[(rows >= k) & (rows < trace.t_s.size - k)]
    u_mm = trace.u_act_nm / _NM_PER_MM
    speed = (u_mm[rows + k] - u_mm[rows - k]) / (trace.t_s[rows + k] - trace.t_s[rows - k])
    return deg[rows], speed


def draw_corner(
    cut: GaugedSurface, trace: CutTrace, geometry: Geometry, spindle_rpm: float
) -> Figure:
    """Return contour, deviation from the drawing, velocity and acceleration around the joint.

    Parameters
    ----------
    geometry : Geometry
        With a corner that was refitted.
    """
    corner = geometry.corner
    assert corner is not None
    z_mm = corner.worst_mm
    lines = lines_at(geometry, corner, z_mm, spindle_rpm)
    names = ("reduction of\nthe radius, µm", "error, µm\n(above 0: metal left)")
    figure = new_figure(10, 8.6)
    panels = stacked(figure, (*names, "U velocity,\nmm/s", "U acceleration,\nm/s²"))
    deg, off_um = _cut_points(geometry, corner, cut, z_mm)
    drawn_um = np.interp(deg, lines.deg, lines.drawn_um)
    _contour(panels, lines, deg, drawn_um + off_um)
    panels[2].plot(lines.deg, trace.sense * lines.velocity_mm_s, color=ORANGE, lw=1.6, ls="--")
    panels[2].plot(*_measured(trace, corner, z_mm), **_DOTS, label="measured on U")
    panels[3].plot(lines.deg, lines.acceleration_m_s2, color=ORANGE, lw=1.6, ls="--")
    for axes in panels:
        axes.axvline(float(corner.joint_deg(z_mm)), color=GREY, lw=1, ls=":")
    panels[0].set_title(f"height {z_mm:.1f} mm, {spindle_rpm:g} r/min; dotted: the joint")
    panels[0].legend(frameon=False, loc="lower left", ncols=3)
    panels[-1].set_xlabel("spindle angle from the long axis, degrees (all quadrants folded)")
    panels[-1].set_xlim(lines.deg[0], lines.deg[-1])
    return figure


def _contour(panels: list[Axes], lines: Lines, deg: Floats, cut_um: Floats) -> None:
    """Draw the contour itself and, below, what it is off the drawing."""
    panels[0].plot(lines.deg, lines.drawn_um, color=BLUE, lw=1.4, label="drawing")
    panels[0].plot(lines.deg, lines.refit_um, color=ORANGE, lw=1.6, ls="--", label="refit")
    panels[0].plot(deg, cut_um, **_DOTS, label="cut")
    panels[0].invert_yaxis()
    panels[1].axhline(0, color=BLUE, lw=1.4)
    panels[1].plot(lines.deg, lines.drawn_um - lines.refit_um, color=ORANGE, lw=1.6, ls="--")
    panels[1].plot(deg, np.interp(deg, lines.deg, lines.drawn_um) - cut_um, **_DOTS)
