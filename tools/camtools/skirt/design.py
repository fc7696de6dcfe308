"""What a gauge compares a cut skirt with, independent of the table: drawing, and refit or filter.

>>> from camtools.skirt.generate import generate
>>> from camtools.skirt.part import example_part
>>> design_of(generate(example_part()))["shape"]
'ellipse'
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.json_text import Json
from camtools.skirt.corner import Corner
from camtools.skirt.generate import GeneratedSkirt
from camtools.skirt.geometry import SkirtSurface
from camtools.skirt.poly_surface import TURN_RAD, PolySurface
from camtools.skirt.run_in import HeldSurface
from camtools.skirt.sides import SidesSurface, TurnedSurface


def _piecewise(spline: PPoly) -> Json:
    return {"breaks_mm": spline.x.tolist(), "coefficients": spline.c.T.tolist()}


def _corner(corner: Corner) -> Json:
    """Return what an ellipse-arc section has beyond an oval (layout: host_sim/part/sim_arc.h)."""
    joint = PPoly(np.radians(corner.joint_deg.c) / TURN_RAD, corner.joint_deg.x)
    return {"trim_mm": _piecewise(corner.trim), "joint_turn": _piecewise(joint)}


def _document(result: GeneratedSkirt, surface: SkirtSurface) -> Json:
    """Return a surface of the skirt with its profile."""
    if isinstance(surface, HeldSurface):  # beyond the ends nothing is gauged
        surface = surface.inner
    section = result.part.piston.section
    radius: Json = {"radius_mm": _piecewise(result.geometry.radius)}
    if isinstance(surface, TurnedSurface):
        radius["phase_rad"] = _piecewise(surface.phase)
        surface = surface.surface
    if isinstance(surface, PolySurface):
        return {"shape": "surface"} | radius | {"surface": surface.document()}
    if isinstance(surface, SidesSurface):
        return {"shape": "sides"} | radius | surface.document()
    oval = radius | {"ovality_mm": _piecewise(result.geometry.ovality)}
    found: Json = {"shape": section.shape, "beta": float(np.asarray(section.beta))} | oval
    if isinstance(surface, Corner):
        found |= {"base": section.base} | _corner(surface)
    return found


def design_of(result: GeneratedSkirt) -> Json:
    """Return the drawing, by which a part is judged: corners and all measured points included."""
    return _document(result, result.geometry.drawing)


def target_of(result: GeneratedSkirt) -> Json:
    """Return {"target": ...} where the table plays a refit or a filter, nothing elsewhere."""
    geometry = result.geometry
    if geometry.drawn is None:
        return {}
    return {"target": _document(result, geometry.surface)}
