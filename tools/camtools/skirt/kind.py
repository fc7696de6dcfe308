"""The skirt of a piston as a kind of part.

>>> KIND.speed_words(600.0)
['--rpm', '600.0']
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.base.text import Json
from camtools.cut.correction import Correction, Drawing
from camtools.cut.path import ToolPath
from camtools.pipeline.kind import Exact, Kind, Rig
from camtools.sim.machine_file import machine_text
from camtools.sim.results import Measured, control_of
from camtools.skirt.geometry.profile import smoothing_takes_um
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart, margin_mm, spread
from camtools.skirt.report.outcome import SkirtOutcome, compare_removal
from camtools.skirt.report.summary import make_summary
from camtools.skirt.report.summary_text import emit_text
from camtools.skirt.table.gauge_design import drawing_of
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.skirt.tool.exact_shape import exact_skirt

if TYPE_CHECKING:
    from camtools.report.kind_report import KindReport


class SkirtKind(Kind[SkirtPart, GeneratedSkirt, SkirtOutcome]):
    """Skirts of pistons: ovals over the height."""

    name = "piston"
    plural = "pistons"
    rank = 0
    commands = ("mktables", "run", "mkgcode", "analyse", "trade")
    model = SkirtPart

    def make(self, part: SkirtPart, tolerance_nm: float | None = None) -> GeneratedSkirt:
        """See `Kind.make`."""
        return generate(part, tolerance_nm)

    def exact(self, part: SkirtPart) -> Exact:
        """See `Kind.exact`."""
        return exact_skirt(part)

    def drawing(self, part: SkirtPart) -> Drawing:
        """See `Kind.drawing`."""
        geometry = make_geometry(part)

        def radius_mm(turn: Floats, z_mm: Floats) -> Floats:
            reduction = geometry.drawing.delta(2 * np.pi * turn, z_mm).delta
            return np.asarray(geometry.radius_mm(z_mm) - reduction, dtype=np.float64)

        swing_mm = max(geometry.deepest_mm(float(z)) for z in geometry.breaks_mm())
        return Drawing(geometry.skirt_mm, radius_mm, swing_mm, drawing_of(part, geometry))

    def make_corrected(
        self, part: SkirtPart, tolerance_nm: float | None, correction: Correction
    ) -> GeneratedSkirt:
        """See `Kind.make_corrected`."""
        return generate(part, tolerance_nm, correction)

    def summary(self, made: GeneratedSkirt) -> Json:
        """See `Kind.summary`."""
        return make_summary(made)

    def text(self, summary: Json) -> str:
        """See `Kind.text`."""
        return emit_text(summary)

    def plots(self, made: GeneratedSkirt) -> dict[str, bytes]:
        """See `Kind.plots`."""
        # matplotlib loads longer than all the rest
        from camtools.skirt.report.plots import draw_all

        return draw_all(made)

    def at_speed(self, part: SkirtPart, rpm: float | None) -> SkirtPart:
        """Return the part for another mean speed: only a modulated spindle's law depends on it."""
        if rpm is None or part.process.mode == "uniform":
            return part
        process = part.process.model_copy(update={"spindle_rpm": rpm})
        return part.model_copy(update={"process": process})

    def mean_rpm(self, made: GeneratedSkirt, rpm: float | None) -> float:
        """See `Kind.mean_rpm`."""
        return rpm or made.part.process.spindle_rpm

    def turns(self, made: GeneratedSkirt, feed_mm: float) -> float:
        """See `Kind.turns`."""
        ends = made.table.z_first_nm / NM_PER_MM, made.table.z_last_nm / NM_PER_MM
        return ToolPath(made.part.process.path, *ends, feed_mm).turns

    def sections_mm(self, made: GeneratedSkirt, feed_mm: float) -> list[float]:
        """See `Kind.sections_mm`: at heights that profile and ovality name."""
        named_mm = {float(z) for z in made.geometry.breaks_mm()}
        return spread(sorted(named_mm), made.geometry.skirt_mm, margin_mm(feed_mm))

    def form_error_um(self, part: SkirtPart) -> float:
        """See `Kind.form_error_um`."""
        return part.process.form_error_um

    def taken_um(self, made: GeneratedSkirt) -> float:
        """See `Kind.taken_um`."""
        return smoothing_takes_um(made.part)

    def machine(self, part: SkirtPart) -> str:
        """See `Kind.machine`."""
        return machine_text(part.machine.limits, part.tool.wear_um)

    def outcome(self, made: GeneratedSkirt, measured: Measured, rig: Rig) -> SkirtOutcome:
        """Return the cut; a part with a modulated spindle is cut uniformly for comparison."""
        control = control_of(rig.result.surface)
        return SkirtOutcome(made, *measured, compare_removal(rig, made), control)

    def facts(self, made: GeneratedSkirt) -> Json:
        """See `Kind.facts`."""
        error = {"u": made.accuracy_u.value_nm, "x": made.accuracy_x.value_nm}
        return {"table_error_nm": error | {"tolerance": made.tolerance_nm}}

    def report(self) -> KindReport[SkirtOutcome]:
        """See `Kind.report`."""
        from camtools.skirt.report.report import REPORT  # matplotlib, see above

        return REPORT


KIND = SkirtKind()
