"""Lobes and camshafts as a kind of part.

>>> from camtools.lobe.motion import example_lobe
>>> KIND.at_speed(example_lobe(), 30.0).process.spindle_rpm
30.0
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from camtools.base.errors import CamtoolsError
from camtools.base.json_text import Json
from camtools.base.quantities import NM_PER_MM
from camtools.lobe.exact import exact_lobes
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.list_report import smoothing_takes_um
from camtools.lobe.part import MAX_RPM, MIN_RPM, LobePart
from camtools.lobe.report_text import LobeOutcome
from camtools.lobe.summary import emit_lobe_text, make_lobe_summary
from camtools.part.common import SwingLimits
from camtools.pipeline.exact import Exact
from camtools.pipeline.kind import Kind, Rig
from camtools.sim.machine_file import machine_text
from camtools.sim.results import TRACE, Measured, read_swing

if TYPE_CHECKING:
    from camtools.report.kind_report import KindReport


_CAM_MACHINE = """\
[encoder]
counts_per_turn = 1000000
[swing]
speed_deg_per_s = {speed!r}
acceleration_deg_per_s2 = {acceleration!r}
range_deg = {range!r}
"""


def lobe_machine_text(limits: SwingLimits) -> str:
    """Return a machine file for lobes: their lift over the angle needs the encoder of a C axis."""
    return machine_text(limits) + _CAM_MACHINE.format(
        speed=min(limits.swing_speed_deg_s, 1e5),
        acceleration=min(max(limits.swing_acceleration_deg_s2, 10.0), 1e8),
        range=limits.swing_deg,
    )


class LobeKind(Kind[LobePart, GeneratedLobes, LobeOutcome]):
    """Lobes: lift over the angle, turned with a swinging tool or ground with a wheel."""

    name = "cam"
    plural = "cams"
    rank = 1
    commands = ("mktables", "run", "analyse", "mkgcode")
    model = LobePart

    def make(self, part: LobePart, tolerance_nm: float | None = None) -> GeneratedLobes:
        """See `Kind.make`."""
        return generate_lobes(part, tolerance_nm)

    def exact(self, part: LobePart) -> Exact:
        """See `Kind.exact`."""
        return exact_lobes(part)

    def summary(self, made: GeneratedLobes) -> Json:
        """See `Kind.summary`."""
        return make_lobe_summary(made)

    def text(self, summary: Json) -> str:
        """See `Kind.text`."""
        return emit_lobe_text(summary)

    def plots(self, made: GeneratedLobes) -> dict[str, bytes]:
        """See `Kind.plots`."""
        from camtools.lobe.plots import draw_lobes  # matplotlib loads longer than all the rest

        return draw_lobes(made)

    def at_speed(self, part: LobePart, rpm: float | None) -> LobePart:
        """Return the part for another speed on the base circle.

        Raises
        ------
        CamtoolsError
            Out of the range of a part file.
        """
        if rpm is None:
            return part
        if not MIN_RPM <= rpm <= MAX_RPM:
            problem = f"--rpm {rpm:g}: out of range"
            raise CamtoolsError([f"{problem}; give r/min, {MIN_RPM:g} .. {MAX_RPM:g}"])
        process = part.process.model_copy(update={"spindle_rpm": rpm})
        return part.model_copy(update={"process": process})

    def mean_rpm(self, made: GeneratedLobes, rpm: float | None) -> float:
        """Return the mean speed; the table is made for the speed asked for already."""
        return made.mean_rpm

    def speed_words(self, rpm: float | None) -> list[str]:
        """Return nothing: the table carries the speed."""
        return []

    def turns(self, made: GeneratedLobes, feed_mm: float) -> float:
        """See `Kind.turns`; the turns of a plunge cut do not depend on the feed of a part file."""
        if made.plunge is not None:
            return made.plunge.turns(len(made.lobes))
        return (made.table.z_last_nm - made.table.z_first_nm) / NM_PER_MM / feed_mm

    def form_error_um(self, part: LobePart) -> float:
        """See `Kind.form_error_um`."""
        return part.process.form_error_um

    def taken_um(self, made: GeneratedLobes) -> float:
        """See `Kind.taken_um`."""
        return smoothing_takes_um(made.laws)

    def machine(self, part: LobePart) -> str:
        """See `Kind.machine`."""
        wear_um = part.process.wheel_wear_um_per_lobe
        wheel = f"[wheel]\nwear_um_per_lobe = {wear_um!r}\n" if part.process.is_plunge else ""
        return lobe_machine_text(part.machine.limits) + wheel

    def outcome(self, made: GeneratedLobes, measured: Measured, rig: Rig) -> LobeOutcome:
        """Return the cut with the swing of the tool that the trace holds."""
        return LobeOutcome(made, *measured, read_swing(Path(TRACE)))

    def facts(self, made: GeneratedLobes) -> Json:
        """See `Kind.facts`."""
        error = {"u_nm": made.lift.error, "angle_deg": made.angle.error}
        return {"table_error": error | {"tolerance_nm": made.tolerance_nm}}

    def report(self) -> KindReport[LobeOutcome]:
        """See `Kind.report`."""
        from camtools.lobe.report import REPORT  # matplotlib, see above

        return REPORT


KIND = LobeKind()
