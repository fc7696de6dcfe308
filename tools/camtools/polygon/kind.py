"""Polygon shafts as a kind of part.

>>> KIND.speed_words(600.0)
['--rpm', '600.0']
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.pipeline.exact import Exact
from camtools.pipeline.kind import Kind, Rig
from camtools.polygon.exact import exact_polygon
from camtools.polygon.generate import GeneratedPolygon, generate_polygon
from camtools.polygon.part import PolygonPart
from camtools.polygon.report_text import PolygonCut, polygon_rows
from camtools.polygon.summary import emit_polygon_text, make_polygon_summary
from camtools.report.text import ReportRow
from camtools.sim.camsim import machine_text
from camtools.sim.results import Measured

_ENCODER = "[encoder]\ncounts_per_turn = 1000000 # flanks of 10 mm per rad want it, as lobes do\n"


class PolygonKind(Kind[PolygonPart, GeneratedPolygon, PolygonCut]):
    """Shafts whose section is a polygon of the standards, or one with rounded corners."""

    name = "polygon"
    plural = "polygons"
    rank = 2
    commands = ("mktables", "run")
    model = PolygonPart

    def make(self, part: PolygonPart, tolerance_nm: float | None = None) -> GeneratedPolygon:
        """See `Kind.make`."""
        return generate_polygon(part, tolerance_nm)

    def exact(self, part: PolygonPart) -> Exact:
        """See `Kind.exact`."""
        return exact_polygon(part)

    def summary(self, made: GeneratedPolygon) -> Json:
        """See `Kind.summary`."""
        return make_polygon_summary(made)

    def text(self, summary: Json) -> str:
        """See `Kind.text`."""
        return emit_polygon_text(summary)

    def plots(self, made: GeneratedPolygon) -> dict[str, bytes]:
        """See `Kind.plots`."""
        from camtools.polygon.plots import draw_polygon  # matplotlib loads longer than the rest

        return draw_polygon(made)

    def at_speed(self, part: PolygonPart, rpm: float | None) -> PolygonPart:
        """Return the part: its table is the same at every speed."""
        return part

    def mean_rpm(self, made: GeneratedPolygon, rpm: float | None) -> float:
        """See `Kind.mean_rpm`."""
        return rpm or made.part.process.spindle_rpm

    def speed_words(self, rpm: float | None) -> list[str]:
        """See `Kind.speed_words`."""
        return [] if rpm is None else ["--rpm", repr(rpm)]

    def turns(self, made: GeneratedPolygon, feed_mm: float) -> float:
        """See `Kind.turns`."""
        return made.part.height_mm / feed_mm

    def form_error_um(self, part: PolygonPart) -> float:
        """See `Kind.form_error_um`."""
        return part.process.form_error_um

    def machine(self, part: PolygonPart) -> str:
        """Return the machine with an encoder that is fine enough for steep flanks."""
        return machine_text(part.machine.limits, part.tool.wear_um) + _ENCODER

    def outcome(self, made: GeneratedPolygon, measured: Measured, rig: Rig) -> PolygonCut:
        """See `Kind.outcome`."""
        return PolygonCut(made, *measured)

    def facts(self, made: GeneratedPolygon) -> Json:
        """See `Kind.facts`."""
        error = {"u": made.accuracy_u.value_nm, "x": made.accuracy_x.value_nm}
        return {"table_error_nm": error | {"tolerance": made.tolerance_nm}}

    def rows(self, outcome: PolygonCut) -> list[ReportRow]:
        """See `Kind.rows`."""
        return polygon_rows(outcome)

    def report(self, outcome: PolygonCut) -> dict[str, bytes]:
        """See `Kind.report`."""
        from camtools.polygon.report import make_polygon_report  # matplotlib, see above

        return make_polygon_report(outcome)


KIND = PolygonKind()
