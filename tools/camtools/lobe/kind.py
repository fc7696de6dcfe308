"""Lobes and camshafts as a kind of part, and the exact motion of U along them.

>>> from camtools.lobe.motion import example_lobe
>>> shape = KIND.exact(example_lobe())
>>> f"{shape.turn_at(6.0, 8).radius_mm.max():.3f}", shape.heights_mm
('28.000', (0.0, 12.0))
>>> KIND.at_speed(example_lobe(), 30.0).process.spindle_rpm
30.0
"""

from pathlib import Path

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.base.text import Json
from camtools.lobe.channels import has_patterns, range_of
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.motion import ShaftLobe, lobes_of, profiles_of, smoothing_takes_um
from camtools.lobe.part import MAX_RPM, MIN_RPM, LobePart
from camtools.lobe.summary import LobeOutcome, emit_lobe_text, make_lobe_summary
from camtools.part.common import SwingLimits
from camtools.pipeline.kind import (
    Exact,
    ExactTurn,
    HeightCurve,
    Kind,
    ProfileOver,
    Rig,
    SpeedRatio,
    even_angles,
    ratio_of,
)
from camtools.sim.machine_file import machine_text
from camtools.sim.results import TRACE, Cut, read_swing
from camtools.table.channel import Channel

_STEP_RAD = 1e-4
_EDGE_MM = 1e-6  # a lobe begins and ends within it, for a line over the height


class ExactLobes(Exact):
    """Lobes on their shaft."""

    def __init__(self, lobes: list[ShaftLobe]) -> None:
        self.heights_mm = lobes[0].z_mm[0], lobes[-1].z_mm[1]
        self._lobes = lobes

    def lobe_at(self, z_mm: float) -> ShaftLobe:
        """Return the lobe at a height, between two of them the nearer one."""

        def off_mm(lobe: ShaftLobe) -> float:
            return max(lobe.z_mm[0] - z_mm, z_mm - lobe.z_mm[1], 0.0)

        return min(self._lobes, key=off_mm)

    def nearest_mm(self, z_mm: float) -> float:
        """See `Exact.nearest_mm`: between two lobes there is no section."""
        low, high = self.lobe_at(z_mm).z_mm
        return min(max(z_mm, low), high)

    def turn_at(self, z_mm: float, n: int) -> ExactTurn:
        """See `Exact.turn_at`; the third derivative is a central difference of the second."""
        lobe, phi = self.lobe_at(z_mm), even_angles(n)
        touch, path = lobe.contacts(phi)
        before, behind = lobe.at(phi - _STEP_RAD).d2, lobe.at(phi + _STEP_RAD).d2
        jerk = (behind - before) / (2 * _STEP_RAD)
        around = np.mod(touch.alpha + lobe.phase_rad, 2 * np.pi)
        order = np.argsort(around)
        radius = np.interp(phi, around[order], touch.radius[order], period=2 * np.pi)
        # U counts towards the axis, a lift away from it
        return ExactTurn(phi, radius, lobe.base_mm, -path.lift, -path.d1, -path.d2, -jerk)

    def profile(self) -> ProfileOver:
        """See `Exact.profile`: the highest and the lowest radius of each lobe."""
        z_mm, highest = [], []
        nose_mm = [
            float(lobe.contacts(even_angles(720))[0].radius.max())
            for lobe in profiles_of(self._lobes)
        ]
        for lobe in self._lobes:
            (low, high), nose = lobe.z_mm, nose_mm[lobe.profile]
            z_mm += [low - _EDGE_MM, low, high, high + _EDGE_MM]
            highest += [lobe.base_mm, nose, nose, lobe.base_mm]
        base = np.full(len(z_mm), self._lobes[0].base_mm)
        curves = HeightCurve("noses", np.array(highest)), HeightCurve("base circle", base)
        return ProfileOver(np.array(z_mm), curves)

    def ratio_at(self, speed: Channel, phi_rad: Floats, z_mm: float) -> SpeedRatio:
        """See `Exact.ratio_at`: of the lobe at that height."""
        lobe = self.lobe_at(z_mm)
        if speed.has_patterns and has_patterns(self._lobes):
            return ratio_of(speed, phi_rad - lobe.phase_rad, float(lobe.profile))
        return ratio_of(speed, phi_rad, float(range_of(self._lobes)[0]))


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
    make = staticmethod(generate_lobes)
    summary = staticmethod(make_lobe_summary)
    text = staticmethod(emit_lobe_text)
    reported = "camtools.lobe.report"

    def exact(self, part: LobePart) -> Exact:
        """See `Kind.exact`."""
        return ExactLobes(lobes_of(part))

    def at_speed(self, part: LobePart, rpm: float | None) -> LobePart:
        """Return the part for another speed on the base circle, which a part file must allow."""
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

    def taken_um(self, made: GeneratedLobes) -> float:
        """See `Kind.taken_um`."""
        return smoothing_takes_um(made.laws)

    def machine(self, part: LobePart) -> str:
        """See `Kind.machine`."""
        wear_um = part.process.wheel_wear_um_per_lobe
        wheel = f"[wheel]\nwear_um_per_lobe = {wear_um!r}\n" if part.process.is_plunge else ""
        return lobe_machine_text(part.machine.limits) + wheel

    def outcome(self, cut: Cut[GeneratedLobes], rig: Rig) -> LobeOutcome:
        """Return the cut with the swing of the tool that the trace holds."""
        return LobeOutcome(**vars(cut), swing_deg=read_swing(Path(TRACE)))

    def facts(self, made: GeneratedLobes) -> Json:
        """See `Kind.facts`."""
        error = {"u_nm": made.lift.error, "angle_deg": made.angle.error}
        return {"table_error": error | {"tolerance_nm": made.tolerance_nm}}


KIND = LobeKind()
