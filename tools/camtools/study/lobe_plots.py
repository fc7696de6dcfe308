"""Pictures of the study of a camshaft: motion, wheel and speed, contact and curvature.

>>> from camtools.lobe.motion import example_lobe
>>> from camtools.study.lobe import LobeWishes, study_lobes
>>> sorted(draw_all("example", study_lobes(example_lobe(), LobeWishes())))
['lobe_contact', 'lobe_motion']
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.plots.panels import legend_below, pictures, stacked
from camtools.plots.style import new_figure
from camtools.study.lobe import LobeStudy

_SHOWN_MM = 1000.0  # radii of curvature up to this one are drawn
_MM_PER_M = 1000.0

Curves = dict[str, Floats]
"""What is drawn, by the name of its axis."""


def _name(study: LobeStudy) -> str:
    return f"lobe {study.number}, {study.lobe.z_mm[0]:g} .. {study.lobe.z_mm[1]:g} mm"


def _draw(title: str, below: str, curves: list[tuple[str, Floats, Curves]]) -> Figure:
    names = list(curves[0][2])
    figure = new_figure(9, 1 + 1.9 * len(names))
    figure.suptitle(title)
    panels = stacked(figure, names)
    for name, degrees, values in curves:
        for axes, one in zip(panels, values.values(), strict=True):
            axes.plot(degrees, one, lw=1.3, label=name)
    panels[-1].set_xticks(range(-180, 181, 30))
    panels[-1].set_xlabel(below)
    if len(curves) > 1:
        legend_below(figure, panels[0], 3)
    return figure


def draw_motion(name: str, studies: list[LobeStudy]) -> Figure:
    """Return x(t), its speed and acceleration and the swing, or S(phi) and the speed N_C."""
    is_turned = studies[0].operation == "turning"
    found: list[tuple[str, Floats, Curves]] = []
    for one in studies:
        omega, path = one.omega_rad_s, one.path
        curves: Curves = {"lift S, mm": path.lift}
        if is_turned:
            curves = {
                "lift x, mm": path.lift,
                "speed of X, mm/s": path.d1 * omega,
                "acceleration\nof X, m/s²": path.d2 * omega**2 / _MM_PER_M,
                "swing, degrees": np.degrees(path.angle),
                "speed of the\nswing, degrees/s": np.degrees(path.angle1) * omega,
            }
        else:
            curves["dS/dφ, mm/rad"] = path.d1
            curves["contact's travel\nds/dφ, mm/rad"] = path.ds_dphi
            curves["cam's speed\nN_C, r/min"] = one.n_c_rpm
        found.append((_name(one), np.degrees(path.phi), curves))
    what = "tool swung about the roller's centre" if is_turned else "wheel and speed of the cam"
    return _draw(f"{name}: {what}", "cam angle φ from the zero of the law, degrees", found)


def draw_contact(name: str, studies: list[LobeStudy]) -> Figure:
    """Return radius and angle of the contact, pressure angle and radius of curvature."""
    found: list[tuple[str, Floats, Curves]] = []
    for one in studies:
        touch, radius = one.touch, one.curvature_radius_mm
        shown = np.where(np.abs(radius) <= _SHOWN_MM, radius, np.nan)
        curves: Curves = {
            "radius of the\ncontact, mm": touch.radius,
            "its angle over\nθ, degrees": np.degrees(touch.alpha) - one.theta_deg,
            "pressure angle,\ndegrees": np.degrees(touch.gamma),
            "radius of\ncurvature, mm": shown,
        }
        found.append((_name(one), one.theta_deg, curves))
    below = "direction of the follower θ from the zero of the law, degrees"
    figure = _draw(f"{name}: where the follower touches", below, found)
    if all(one.touch.curvature.min() >= 0 for one in studies):
        figure.axes[-1].set_yscale("log")
    return figure


def draw_all(name: str, studies: list[LobeStudy]) -> dict[str, bytes]:
    """Return all pictures as PNG by topic."""
    return pictures(
        {
            "lobe_motion": lambda: draw_motion(name, studies),
            "lobe_contact": lambda: draw_contact(name, studies),
        }
    )
