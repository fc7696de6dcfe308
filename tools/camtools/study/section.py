"""What is worked out about one section of a part: the numbers behind tables and pictures.

>>> from camtools.skirt.part.part_file import example_part
>>> study = make_analysis(example_part(), AnalysisWishes())
>>> study.height_mm, study.steps.area_mm2.size
(20.0, 31)
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cut.removal import (
    TURN_RAD,
    ChipForce,
    Parts,
    PartsRange,
    Rates,
    SectionCut,
    SpeedPeaks,
    Steps,
    harmonics_mm,
    parts_of,
    parts_range,
    rates_of,
    speed_peaks,
    steps_of,
)
from camtools.skirt.geometry.blank import section_cut
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart

N_HARMONICS = 12
MAX_PARTS, MAX_TURNS = 1000, 100


@dataclass(frozen=True)
class AnalysisWishes:
    """What the user may choose; None is the part's own."""

    height_mm: float | None = None
    step_deg: float = 3.0
    parts: int | None = None
    slice_volume_mm3: float = 0.04
    cycle_us: float = 50.0
    kc_n_mm2: float = 700.0
    kc_exponent: float = 0.0
    rpm: float | None = None
    turns: int = 1
    nose_mm: float = 0.8


@dataclass(frozen=True, eq=False)
class Analysis:
    """Everything about one section; see `removal` for the parts."""

    name: str
    part: SkirtPart
    geometry: Geometry
    cut: SectionCut
    height_mm: float
    rpm: float  # mean speed
    feed_mm: float
    force: ChipForce
    turns: int
    alpha_rad_s2: float
    steps: Steps
    parts: Parts
    is_even: bool  # turned at equal volume, or parts were asked for
    range: PartsRange
    peaks: SpeedPeaks
    rates: Rates
    waves_mm: Floats  # cosine amplitudes of U at constant rate, against mean phase
    uniform_waves_mm: Floats

    @property
    def kc_n_mm2(self) -> float:
        """Return the specific cutting force, with a size effect that of a chip of 1 mm."""
        return self.force.kc_n_mm2

    def chip_n(self, depth_mm: Floats) -> Floats:
        """Return the force of chips of the feed."""
        return self.force.chip_n(depth_mm, self.feed_mm)


def _refuse(option: str, value: object, problem: str, remedy: str) -> CamtoolsError:
    return CamtoolsError([f"{option} {value}: {problem}; {remedy}"])


def _check(wishes: AnalysisWishes) -> None:
    numbers = {
        "--step-deg": (wishes.step_deg, 0.01, 45.0),
        "--slice-volume-mm3": (wishes.slice_volume_mm3, 1e-9, 1e6),
        "--cycle-us": (wishes.cycle_us, 0.01, 1e6),
        "--kc-n-mm2": (wishes.kc_n_mm2, 0.001, 1e6),
        "--kc-exponent": (wishes.kc_exponent, 0.0, 0.9),
        "--rpm": (1.0 if wishes.rpm is None else wishes.rpm, 0.001, 60_000.0),
        "--parts": (2 if wishes.parts is None else wishes.parts, 2, MAX_PARTS),
        "--turns": (wishes.turns, 1, MAX_TURNS),
        "--nose-mm": (wishes.nose_mm, 0.01, 100.0),
    }
    for option, (value, low, high) in numbers.items():
        if not (isfinite(value) and low <= value <= high):
            raise _refuse(option, value, "out of range", f"give {low:g} .. {high:g}")
    if abs(90 / wishes.step_deg - round(90 / wishes.step_deg)) > 1e-9:
        problem = "does not divide 90 degrees"
        raise _refuse("--step-deg", wishes.step_deg, problem, "give 1, 2, 3, 5 ...")


def _height_of(part: SkirtPart, wishes: AnalysisWishes) -> float:
    profile = part.piston.profile
    low, high = float(profile.height_mm[0]), float(profile.height_mm[-1])
    if wishes.height_mm is None:
        return float(profile.height_mm[int(np.argmax(profile.diameter_mm))])
    if not low <= wishes.height_mm <= high:
        raise _refuse(
            "--height", wishes.height_mm, "lies outside the part", f"give {low:g} .. {high:g} mm"
        )
    return wishes.height_mm


def make_analysis(part: SkirtPart, wishes: AnalysisWishes) -> Analysis:
    """Return the analysis of a part's section.

    Raises
    ------
    CamtoolsError
        A wish is out of range, the geometry impossible, or nothing is cut somewhere.
    """
    _check(wishes)
    geometry, height_mm = make_geometry(part), _height_of(part, wishes)
    cut = section_cut(geometry, part.process.depth_mm, height_mm)
    if float(cut.depth_mm(np.linspace(0, TURN_RAD, 721)).min()) <= 0:
        problem = f"nothing is cut somewhere at height {height_mm:g} mm"
        raise CamtoolsError([f"process.depth_mm: {problem}; give a larger depth or other height"])
    rpm = part.process.spindle_rpm if wishes.rpm is None else wishes.rpm
    feed, steps = part.process.feed_mm, steps_of(cut, np.radians(wishes.step_deg))
    volume, cycle_s = wishes.slice_volume_mm3, wishes.cycle_us * 1e-6
    samples = 4096
    u_mm = cut.delta(TURN_RAD * np.arange(samples) / samples).delta
    waves = np.real(np.fft.rfft(u_mm)[: N_HARMONICS + 1]) / samples
    return Analysis(
        name=part.part.name,
        part=part,
        geometry=geometry,
        cut=cut,
        height_mm=height_mm,
        rpm=rpm,
        feed_mm=feed,
        force=ChipForce(wishes.kc_n_mm2, wishes.kc_exponent, wishes.nose_mm),
        turns=wishes.turns,
        alpha_rad_s2=part.machine.limits.alpha_rad_s2,
        steps=steps,
        parts=parts_of(cut, part.process.parts if wishes.parts is None else wishes.parts),
        is_even=part.process.mode == "equal-volume" or wishes.parts is not None,
        range=parts_range(cut, feed, rpm, volume, cycle_s),
        peaks=speed_peaks(cut),
        rates=rates_of(cut, steps, feed, rpm, wishes.kc_n_mm2),
        waves_mm=harmonics_mm(cut, N_HARMONICS),
        uniform_waves_mm=np.asarray(
            waves * np.where(np.arange(N_HARMONICS + 1) > 0, 2, 1), dtype=np.float64
        ),
    )
