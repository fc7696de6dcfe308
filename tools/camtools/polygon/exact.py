# SPDX-License-Identifier: Apache-2.0
"""The exact shape of a polygon and the motion of U along it.

>>> from camtools.polygon.part import example_polygon
>>> shape = exact_polygon(example_polygon())
>>> turn = shape.turn_at(10.0, 6)
>>> f"{turn.nominal_mm:.3f} {turn.radius_mm.min():.3f}"
'13.300 11.700'
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camtools.base.quantities import NM_PER_MM
from camtools.pipeline.exact import HeightCurve, ProfileOver
from camtools.polygon.generate import shapes_of
from camtools.polygon.part import PolygonPart
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.tool.exact_shape import ExactGeometry
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.u_zero import middle_nm


class ExactPolygon(ExactGeometry):
    """A prism, or a cone whose sections are alike."""

    def __init__(self, drawn: Geometry, tip: Geometry, middle_mm: float) -> None:
        super().__init__(drawn, tip, middle_mm)
        self._least = 1 - drawn.deepest_mm(drawn.z_first_mm) / float(
            drawn.radius_mm(drawn.z_first_mm)
        )

    def profile(self) -> ProfileOver:
        """See `Exact.profile`: the circles around and inside the sections."""
        z_mm = np.array(self.heights_mm)
        outer = self._drawn.radius_mm(z_mm)
        return ProfileOver(
            z_mm,
            (HeightCurve("outer circle", outer), HeightCurve("inner circle", outer * self._least)),
        )


def exact_polygon(part: PolygonPart) -> ExactPolygon:
    """Return the exact shape of a polygon.

    Raises
    ------
    CamtoolsError
        The numbers make no polygon.
    """
    _, _, geometry, design = shapes_of(part)
    tip = tip_geometry(geometry, part.tool)
    middle_mm = middle_nm(tip, part.process.u_zero) / NM_PER_MM
    return ExactPolygon(replace(geometry, drawn=design), tip, middle_mm)
