"""The exact shape of a skirt and the motion of U along it.

>>> from camtools.skirt.part.part_file import example_part
>>> part = example_part()
>>> slower = part.process.model_copy(update={"spindle_rpm": 500.0})
>>> shape_key(part) == shape_key(part.model_copy(update={"process": slower}))
True
"""

from collections.abc import Hashable

import numpy as np

from camtools.base.cache import file_state, recall
from camtools.base.quantities import NM_PER_MM
from camtools.part.common import Tool
from camtools.pipeline.kind import Exact, ExactTurn, HeightCurve, ProfileOver, even_angles
from camtools.skirt.geometry.profile import smoothed_curves
from camtools.skirt.geometry.run_in import with_run
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.turning import middle_nm


def shape_key(part: SkirtPart) -> Hashable:
    """Return what the geometry of a part follows from; of a refit the speed is part of it."""
    magnify = None if part.magnify is None else part.magnify.model_dump_json()
    section = part.piston.section
    names = [section.csv, *(entry.csv for entry in section.files or [])]
    files = tuple(file_state(name) for name in names if name is not None)
    refit = f"{part.tightest_um!r}" if smoothed_curves(part.piston) else ""
    if section.shape == "ellipse-arc":
        refit = f"{part.process.spindle_rpm!r} {part.tightest_um!r}"
    return part.piston.model_dump_json(), magnify, files, refit


def way_key(part: SkirtPart, tolerance_nm: float | None) -> Hashable:
    """Return what the channels of u and x follow from."""
    process = part.process
    runs = (*process.runs_mm, part.tightest_um, part.bands)
    program = (process.feed_mm, process.depth_mm) if part.bands else None
    return shape_key(part), runs, program, part.tool.nose_radius_mm, tolerance_nm


def law_key(part: SkirtPart, tolerance_nm: float | None) -> Hashable:
    """Return what the law of the spindle's speed follows from."""
    machine = part.machine.limits.model_dump_json()
    return way_key(part, tolerance_nm), part.process.model_dump_json(), machine


def geometry_of(part: SkirtPart) -> Geometry:
    """Return `make_geometry` of a part, recalled where a memory is open."""
    return recall(("skirt geometry", shape_key(part)), lambda: make_geometry(part))


_HEIGHTS = 201


class ExactGeometry(Exact):
    """A shape by reductions of a radius: the drawing, the tool's tip, and what X takes over."""

    def __init__(self, drawn: Geometry, tip: Geometry, middle_mm: float) -> None:
        self.heights_mm = drawn.skirt_mm
        self._drawn, self._tip, self._middle_mm = drawn, tip, middle_mm

    def turn_at(self, z_mm: float, n: int) -> ExactTurn:
        """See `Exact.turn_at`."""
        phi = even_angles(n)
        nominal = float(self._drawn.radius_mm(z_mm))
        drawn, u = self._drawn.drawing.delta(phi, z_mm), self._tip.delta(phi, z_mm)
        played = (u.delta - self._middle_mm, u.d1, u.d2, u.d3)
        return ExactTurn(phi, nominal - drawn.delta, nominal, *played)

    def profile(self) -> ProfileOver:
        """See `Exact.profile`."""
        z_mm = np.linspace(*self.heights_mm, _HEIGHTS)
        radius = self._drawn.radius_mm(z_mm)
        reduction = self._drawn.drawing.delta(even_angles(4), z_mm[:, None]).delta
        at = [radius - reduction[:, k] for k in range(4)]
        curves: list[HeightCurve] = []
        for i, name in enumerate(("long axis", "short axis")):
            if np.allclose(at[i], at[i + 2], rtol=0, atol=1e-6):
                curves.append(HeightCurve(name, at[i]))
            else:
                curves += [HeightCurve(f"{name}, {90 * k}°", at[k]) for k in (i, i + 2)]
        return ProfileOver(z_mm, tuple(curves))


def exact_skirt(part: SkirtPart) -> ExactGeometry:
    """Return the exact shape of a skirt, or refuse numbers or a nose that do not fit.

    With lands the motion is that of a tool with a point: a nose would touch two bands at once.
    """
    geometry, process = geometry_of(part), part.process
    tool = Tool() if part.piston.lands else part.tool
    tip = tip_geometry(with_run(geometry, *process.runs_mm), tool)
    return ExactGeometry(geometry, tip, middle_nm(tip, process.u_zero) / NM_PER_MM)
