"""A ring whose outside is a circle off the axis: u = e (1 - cos phi), the same at every height.

All that a kind brings stands in this one file; nothing of camtools names it.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.base.text import Json
from camtools.cut.verdict import check_table
from camtools.part.common import Machine, PartInfo, Process, check_feed
from camtools.part.model import HeightMm, TomlTable, rising
from camtools.pipeline.kind import Kind
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.report.text import error_pair, quantity
from camtools.sim.machine_file import machine_text
from camtools.sim.results import Cut
from camtools.table.channel import KIND_U, KIND_X, segment_coefficients
from camtools.table.header import check_tolerance, quantise, table_of, u_bounds, with_bounds
from camtools.table.image import Table
from camtools.table.summary import about_image

_LOG2_KNOTS = 6
_ERROR_NM = 1.0  # of 64 knots, and more than enough for offsets of a few millimetres


class Ring(TomlTable):
    """[ring]: the outside circle and its heights."""

    radius_mm: Annotated[float, Field(ge=1, le=1000)]
    offset_mm: Annotated[float, Field(gt=0, le=5)]
    z_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)]

    _check_z = field_validator("z_mm")(rising)


class RingProcess(Process):
    """[process]: the keys that every kind has, and the largest form error of a good ring."""

    form_error_um: float = 2.0


class RingPart(TomlTable):
    """The whole part file of a ring."""

    part: PartInfo
    ring: Ring
    process: RingProcess
    machine: Machine = Field(default_factory=Machine)

    @property
    def height_mm(self) -> float:
        """Return the height of the ring [mm]."""
        return self.ring.z_mm[1] - self.ring.z_mm[0]


@dataclass(frozen=True, eq=False)
class MadeRing:
    """A ring and its table."""

    part: RingPart
    table: Table
    tolerance_nm: float


RingCut = Cut[MadeRing]


def _knots_mm(offset_mm: float) -> Floats:
    """Return (u, h u', h^2 u'' / 2) around the ring [mm], shape (64, 3)."""
    h = 2 * np.pi / (1 << _LOG2_KNOTS)
    phi = h * np.arange(1 << _LOG2_KNOTS)
    triple = (1 - np.cos(phi), h * np.sin(phi), h**2 / 2 * np.cos(phi))
    return offset_mm * np.stack(triple, axis=-1)


def _design(ring: Ring) -> Json:
    """Return what the gauge compares with: polynomials around the ring, the same at all heights."""
    pieces = np.zeros((1 << _LOG2_KNOTS, 6, 8))
    pieces[..., 0] = segment_coefficients(_knots_mm(ring.offset_mm), periodic=True)
    surface = {
        "angle": "turn",
        "breaks": np.linspace(0, 1, pieces.shape[0] + 1).tolist(),
        "breaks_mm": ring.z_mm,
        "coefficients": pieces.ravel().tolist(),
    }
    axis = {"breaks_mm": ring.z_mm, "coefficients": [[0, 0, 0, ring.radius_mm + ring.offset_mm]]}
    return {"shape": "surface", "radius_mm": axis, "surface": surface}


class RingKind(Kind[RingPart, MadeRing, RingCut]):
    """Rings with an eccentric outside."""

    name = "ring"
    plural = "rings"
    rank = 9
    commands = ("mktables", "run")
    model = RingPart

    def make(self, part: RingPart, tolerance_nm: float | None = None) -> MadeRing:
        """Return the table: two slices that are alike, 64 knots around."""
        tolerance_nm = _ERROR_NM if tolerance_nm is None else tolerance_nm
        check_tolerance(tolerance_nm)
        check_feed(part)
        ring = part.ring
        first_nm, last_nm = (round(z * NM_PER_MM) for z in ring.z_mm)
        turn = _knots_mm(ring.offset_mm) * NM_PER_MM
        axis = np.array([[(ring.radius_mm + ring.offset_mm) * NM_PER_MM, 0.0, 0.0]])
        span = (first_nm, last_nm)
        u = with_bounds(quantise(KIND_U, np.stack([turn, turn]), 0, span))
        x = with_bounds(quantise(KIND_X, np.stack([axis, axis]), 0, span))
        table = table_of(part, part.process.spindle_rpm, u_bounds(u, _ERROR_NM), (u, x))
        check_table(table, part.machine.limits)
        return MadeRing(part, table, tolerance_nm)

    def summary(self, made: MadeRing) -> Json:
        """See `Kind.summary`."""
        part = {"name": made.part.part.name, "kind": self.name, "source": made.part.part.source}
        own = {"part": part, "design": _design(made.part.ring)}
        return about_image(made.table, made.tolerance_nm) | own

    def text(self, summary: Json) -> str:
        """See `Kind.text`."""
        return f"{summary['part']['name']}: ring, table of {summary['table_bytes']} bytes\n"

    def turns(self, made: MadeRing, feed_mm: float) -> float:
        """See `Kind.turns`."""
        return made.part.height_mm / feed_mm

    def machine(self, part: RingPart) -> str:
        """See `Kind.machine`."""
        return machine_text(part.machine.limits)

    def facts(self, made: MadeRing) -> Json:
        """See `Kind.facts`."""
        return {"table_error": {"tolerance_nm": made.tolerance_nm}}

    def report(self) -> KindReport[RingCut]:
        """Return the report: the form error, and no picture."""
        return KindReport(
            what="ring",
            angle="spindle angle",
            heights_mm=lambda cut: (
                cut.generated.part.ring.z_mm[0],
                cut.generated.part.ring.z_mm[1],
            ),
            rows=(quantity("form error", lambda cut: error_pair(cut.summary["form_error_um"])),),
            views=(),
            subject=lambda _: Subject(is_oval=False, has_radius=True),
        )


KIND = RingKind()
