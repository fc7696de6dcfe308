"""Polygon shafts as a kind of part.

>>> from camtools.polygon.part import example_polygon
>>> turn = KIND.exact(example_polygon()).turn_at(10.0, 6)
>>> f"{turn.nominal_mm:.3f} {turn.radius_mm.min():.3f}"
'13.300 11.700'
"""

from dataclasses import replace

import numpy as np

from camtools.base.quantities import NM_PER_MM
from camtools.pipeline.kind import Exact, HeightCurve, Kind, ProfileOver
from camtools.polygon.generate import GeneratedPolygon, generate_polygon, shapes_of
from camtools.polygon.part import PolygonPart
from camtools.polygon.summary import PolygonCut, emit_polygon_text, make_polygon_summary
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.report.outcome import section_machine, table_errors
from camtools.skirt.tool.exact_shape import ExactGeometry
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.turning import middle_nm

_ENCODER = "[encoder]\ncounts_per_turn = 1000000 # flanks of 10 mm per rad want it, as lobes do\n"


class ExactPolygon(ExactGeometry):
    """A prism, or a cone whose sections are alike."""

    def __init__(self, drawn: Geometry, tip: Geometry, middle_mm: float) -> None:
        super().__init__(drawn, tip, middle_mm)
        z_mm = drawn.z_first_mm
        self._least = 1 - drawn.deepest_mm(z_mm) / float(drawn.radius_mm(z_mm))

    def profile(self) -> ProfileOver:
        """See `Exact.profile`: the circles around and inside the sections."""
        z_mm = np.array(self.heights_mm)
        outer = self._drawn.radius_mm(z_mm)
        inner = HeightCurve("inner circle", outer * self._least)
        return ProfileOver(z_mm, (HeightCurve("outer circle", outer), inner))


class PolygonKind(Kind[PolygonPart, GeneratedPolygon, PolygonCut]):
    """Shafts whose section is a polygon of the standards, or one with rounded corners."""

    name = "polygon"
    plural = "polygons"
    rank = 2
    commands = ("mktables", "run")
    model = PolygonPart
    make = staticmethod(generate_polygon)
    summary = staticmethod(make_polygon_summary)
    text = staticmethod(emit_polygon_text)
    facts = staticmethod(table_errors)
    reported = "camtools.polygon.report"

    def exact(self, part: PolygonPart) -> Exact:
        """See `Kind.exact`."""
        _, _, geometry, design = shapes_of(part)
        tip = tip_geometry(geometry, part.tool)
        middle_mm = middle_nm(tip, part.process.u_zero) / NM_PER_MM
        return ExactPolygon(replace(geometry, drawn=design), tip, middle_mm)

    def turns(self, made: GeneratedPolygon, feed_mm: float) -> float:
        """See `Kind.turns`."""
        return made.part.height_mm / feed_mm

    def machine(self, part: PolygonPart) -> str:
        """Return the machine with an encoder that is fine enough for steep flanks."""
        return section_machine(part) + _ENCODER


KIND = PolygonKind()
