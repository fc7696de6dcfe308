"""The skirt as the table plays it: corrected, and continued through the air beyond its ends.

The correction is part of the surface that a nose leaves, MATHS.md (161).

>>> from camtools.cut.correction import N_NODES
>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> drawn = make_geometry(example_part())
>>> waves = {0: np.full(N_NODES, 2e-3 + 0j), 2: np.full(N_NODES, 1e-3 + 0j)}
>>> played = corrected(drawn, Correction(drawn.skirt_mm, waves))
>>> off = drawn.radius_mm(20.0) - played.radius_mm(20.0), played.delta(0.0, 20.0).delta
>>> [f"{float(mm):.4f}" for mm in off], played.surface.log2_repeat
(['0.0020', '0.0010'], 1)
"""

from dataclasses import dataclass, replace

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, FloatsLike, SectionValues
from camtools.cut.correction import Correction
from camtools.skirt.geometry.belt import PLACES, continued
from camtools.skirt.geometry.corrected import CorrectedSurface, minus
from camtools.skirt.geometry.sections import SkirtSurface
from camtools.skirt.geometry.skirt_geometry import Geometry, OvalSurface


def corrected(geometry: Geometry, correction: Correction) -> Geometry:
    """Return what the table of a part without runs plays; the drawing that judges it stays."""
    inner, both = geometry.surface, correction
    if isinstance(inner, CorrectedSurface):  # what is turned of a hot drawing
        both = inner.correction.plus(correction, {}, {})
        inner = inner.inner
    return replace(
        geometry,
        radius=minus(geometry.radius, correction.mean),
        surface=CorrectedSurface(inner, both),
        drawn=geometry.drawing,
        drawn_radius=geometry.radius,
        correction=correction,
    )


@dataclass(frozen=True, eq=False)
class HeldSurface(SkirtSurface):
    """A surface that stays beyond two heights as it is there."""

    inner: SkirtSurface
    first_mm: float
    last_mm: float

    @property
    def log2_repeat(self) -> int:
        """See `SkirtSurface`."""
        return self.inner.log2_repeat

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of the surface has a break, rising."""
        return self.inner.heights_mm()

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `SkirtSurface`."""
        return self.inner.delta(phi_rad, np.clip(z_mm, self.first_mm, self.last_mm))


def with_run(geometry: Geometry, run_in_mm: float, run_out_mm: float) -> Geometry:
    """Return the geometry that the tool follows through run-in and run-out, MATHS.md (102).

    The tool begins and ends so far beyond the skirt [mm]. Raises GeometryError: the continued half
    axis falls to 0.
    """
    if run_in_mm == 0 and run_out_mm == 0:
        return geometry
    if isinstance(geometry.surface, CorrectedSurface):  # which keeps to its own ends
        own = geometry.surface
        found = with_run(replace(geometry, surface=own.inner), run_in_mm, run_out_mm)
        return replace(found, surface=replace(own, inner=found.surface))
    ends, runs = geometry.ends_mm, (run_in_mm, run_out_mm)
    radius = continued(geometry.radius, ends, runs)
    ovality = continued(geometry.ovality, ends, runs, is_ovality=True)
    surface: SkirtSurface = HeldSurface(geometry.surface, *ends)
    if isinstance(geometry.surface, OvalSurface):
        surface = replace(geometry.surface, radius=radius, ovality=ovality)
    found = replace(
        geometry,
        radius=radius,
        ovality=ovality,
        surface=surface,
        z_first_mm=ends[0] - run_in_mm,
        z_last_mm=ends[1] + run_out_mm,
        gauge_mm=ends,
    )
    _check_runs(found, ends, runs)
    return found


def _check_runs(air: Geometry, ends_mm: tuple[float, float], runs_mm: tuple[float, float]) -> None:
    runs = ("run_in_mm", ends_mm[0], -runs_mm[0]), ("run_out_mm", ends_mm[1], runs_mm[1])
    for key, end_mm, run_mm in runs:
        z_mm = np.linspace(end_mm, end_mm + run_mm, PLACES)
        short_mm = air.radius_mm(z_mm) - np.maximum(air.ovality_mm(z_mm), air.deepest_mm(end_mm))
        thinnest = int(np.argmin(short_mm))
        if short_mm[thinnest] <= 0:
            at = f"{short_mm[thinnest]:.6g} mm at height {z_mm[thinnest]:.6g} mm"
            problem = f"the continued half axis is {at}"
            raise GeometryError(f"process.{key}", problem, "give a shorter one")
