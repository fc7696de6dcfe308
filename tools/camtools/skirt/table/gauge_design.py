"""What a gauge compares a cut skirt with, independent of the table: drawing, and refit or filter.

>>> from camtools.skirt.table.generate import generate
>>> from camtools.skirt.part.part_file import example_part
>>> design_of(generate(example_part()))["shape"]
'ellipse'
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.text import Json
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.poly_surface import TURN_RAD, PolySurface, piecewise
from camtools.skirt.geometry.run_in import CorrectedSurface, HeldSurface
from camtools.skirt.geometry.sections import SkirtSurface
from camtools.skirt.geometry.sides import SidesSurface, TurnedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import GeneratedSkirt


def _document(part: SkirtPart, geometry: Geometry, radius_mm: PPoly, surface: SkirtSurface) -> Json:
    """Return a surface of the skirt with its profile."""
    if isinstance(surface, HeldSurface):  # beyond the ends nothing is gauged
        surface = surface.inner
    if isinstance(surface, CorrectedSurface):
        more = {"correction": surface.correction.for_gauge()}
        return _document(part, geometry, radius_mm, surface.inner) | more
    section = part.piston.section
    radius: Json = {"radius_mm": piecewise(radius_mm)}
    if isinstance(surface, TurnedSurface):
        radius["phase_rad"] = piecewise(surface.phase)
        surface = surface.surface
    if isinstance(surface, PolySurface):
        return {"shape": "surface"} | radius | {"surface": surface.document()}
    if isinstance(surface, SidesSurface):
        return {"shape": "sides"} | radius | surface.document()
    oval = radius | {"ovality_mm": piecewise(geometry.ovality)}
    found: Json = {"shape": section.shape, "beta": float(np.asarray(section.beta))} | oval
    if isinstance(surface, Corner):
        # What it has beyond an oval; layout: host_sim/part/sim_design.h.
        joint = PPoly(np.radians(surface.joint_deg.c) / TURN_RAD, surface.joint_deg.x)
        corner = {"trim_mm": piecewise(surface.trim), "joint_turn": piecewise(joint)}
        found |= {"base": section.base} | corner
    return found


def drawing_of(part: SkirtPart, geometry: Geometry) -> Json:
    """Return the drawing of a geometry that may play something else."""
    radius = geometry.drawn_radius or geometry.radius
    return _document(part, geometry, radius, geometry.drawing)


def design_of(result: GeneratedSkirt) -> Json:
    """Return the drawing, by which a part is judged: corners and all measured points included."""
    return drawing_of(result.part, result.geometry)


def target_of(result: GeneratedSkirt) -> Json:
    """Return {"target": ...} where the table plays a refit, a filter or a correction, else {}."""
    geometry = result.geometry
    if geometry.drawn is None:
        return {}
    target = _document(result.part, geometry, geometry.radius, geometry.surface)
    return {"target": target}
