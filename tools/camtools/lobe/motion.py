"""Lobes at their angles of the shaft, and what follows them.

>>> [lobe] = make_lobes(example_lobe())
>>> f"{lobe.at(np.zeros(1)).lift[0]:.1f}"
'8.0'
"""

from collections.abc import Hashable
from dataclasses import dataclass, replace

import numpy as np

from camtools.base.cache import file_state, recall
from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.base.text import Json
from camtools.lobe.contact import (
    Contact,
    Follower,
    Shape,
    all_round,
    check_follower,
    check_wheel,
    follow,
    follow_flat,
    shape_of,
    solved_at,
    touch_of,
)
from camtools.lobe.lift import (
    LiftLaw,
    Listed,
    Smoothing,
    band_for,
    bands_of,
    make_lift,
    peaks_of,
    points_of,
)
from camtools.lobe.part import Camshaft, Lobe, LobePart, LobeProcess
from camtools.part.common import PartInfo
from camtools.part.smoothing import (
    PeakChange,
    band_words,
    check_share,
    form_error_for,
    noise_text,
    residuals,
    smoothed_texts,
)

_OPEN_MM = 0.1
_LEAST_MM = 1e-3  # a least lift above it is no base circle
_LEAST_SHOWN_UM = 1e-3  # less is rounding
_PER_DEG = 20  # angles at which a law is looked at


def extent_of(law: LiftLaw) -> Json:
    """Return least and largest lift and open angle of a list; {} for other laws."""
    if not isinstance(law, Listed):
        return {}
    lift_mm = law.evaluate(np.linspace(0, 2 * np.pi, 360 * _PER_DEG, endpoint=False)).lift
    return {
        "list": {
            "least_lift_mm": float(np.round(max(0.0, lift_mm.min()), 6)),
            "largest_lift_mm": float(np.round(lift_mm.max(), 6)),
            "open_deg": float(np.count_nonzero(lift_mm > _OPEN_MM)) / _PER_DEG,
            "below_zero_um": law.below_um,
        }
    }


def extent_texts(found: Json) -> list[str]:
    """Return what `extent_of` found as lines for people, none where it found nothing."""
    if "list" not in found:
        return []
    facts = found["list"]
    least_mm = facts["least_lift_mm"]
    lines = [
        f"list of lifts of {least_mm:g} .. {facts['largest_lift_mm']:g} mm, above {_OPEN_MM:g} mm "
        f"over {facts['open_deg']:g} degrees of the cam"
    ]
    if facts["below_zero_um"] >= _LEAST_SHOWN_UM:
        lines.append(f"lifts down to -{facts['below_zero_um']:g} um are taken as 0")
    if least_mm > _LEAST_MM:
        lines.append(
            f"caution: the lift is never below {least_mm:g} mm, so the cam is larger than "
            "base_radius_mm all round; subtract what is constant, if the list has radii"
        )
    return lines


def _facts(smoothing: Smoothing) -> Json:
    before, after = peaks_of(smoothing.before), peaks_of(smoothing.after)
    at_deg, off_um = smoothing.angle_deg, smoothing.off_um
    return residuals(smoothing.band_um, off_um, at_deg, "largest_at_deg") | {
        "acceleration_mm_per_rad2": {"before": before.acceleration, "after": after.acceleration},
        "jerk_mm_per_rad3": {"before": before.jerk, "after": after.jerk},
    }


def smoothing_of(law: LiftLaw) -> Json:
    """Return the residuals and peaks of a smoothed list, or of one that should be smoothed."""
    if not isinstance(law, Listed):
        return {}
    found = {"smoothing": law.smoothing, "noise": law.needed}
    return {name: _facts(smoothing) for name, smoothing in found.items() if smoothing is not None}


def smoothing_takes_um(laws: list[LiftLaw]) -> float:
    """Return how far smoothing moves the lift of any lobe at most."""
    smoothings = (law.smoothing for law in laws if isinstance(law, Listed))
    return max((found.largest_um for found in smoothings if found is not None), default=0.0)


def noise_hint(laws: list[LiftLaw], form_error_um: float) -> str:
    """Return what noise of lists may have to do with a refusal; nothing without any."""
    for i, law in enumerate(laws):
        if not isinstance(law, Listed) or law.points is None:
            continue
        needed = law.needed or band_for(law.points, of_jerk=True)
        if needed is not None:
            words = band_words(needed.band_um, needed.largest_um, form_error_um)
            return f"; the list is noisy: cam.lobe.{i}.{words} smooths it"
    return ""


def smoothing_texts(found: Json, form_error_um: float) -> list[str]:
    """Return what `smoothing_of` found as lines for people, none where it found nothing."""
    lines = []
    if "smoothing" in found:
        facts = found["smoothing"]
        place = f"{facts['largest_at_deg']:g} degrees"
        lines += smoothed_texts("list", facts, place, _changes(facts))
    if "noise" in found:
        facts = found["noise"]
        words = band_words(facts["smooth_um"], facts["largest_um"], form_error_um)
        lines.append(noise_text("list", words, _changes(facts)))
    return lines


def _changes(facts: Json) -> list[PeakChange]:
    acceleration, jerk = facts["acceleration_mm_per_rad2"], facts["jerk_mm_per_rad3"]
    return [
        PeakChange("acceleration", acceleration["before"], acceleration["after"], "mm/rad2"),
        PeakChange("jerk", jerk["before"], jerk["after"], "mm/rad3"),
    ]


@dataclass(frozen=True, eq=False)
class ShaftLobe:
    """One lobe on its shaft, with what follows it."""

    law: LiftLaw  # of the lobe itself
    base_mm: float  # radius of the base circle
    roller_mm: float  # of the roller that defines the lift
    follower_mm: float  # of what touches the cam
    phase_rad: float  # spindle angle at which the lobe's own angle is 0
    z_mm: tuple[float, float]  # where the lobe begins and ends
    shape: Shape  # its extremes
    profile: int = 0  # the same for lobes of the same law: 0 .. in the order of appearance
    is_flat: bool = False  # the lift is that of a flat face, not of a roller

    def contacts(self, phi_rad: Floats) -> tuple[Contact, Follower]:
        """Return contacts and follower at spindle angles [rad], in the frame of the lobe."""
        turned = np.mod(phi_rad - self.phase_rad + np.pi, 2 * np.pi) - np.pi
        return solved_at(self.touch_at, turned)

    def touch_at(self, theta_rad: Floats) -> tuple[Contact, Follower]:
        """Return contacts and follower at directions of the lobe's own follower."""
        touch = touch_of(self.law, self.base_mm, self.roller_mm, theta_rad, is_flat=self.is_flat)
        if self.is_flat:
            return touch, follow_flat(self.law, touch, self.follower_mm)
        return touch, follow(touch, self.follower_mm)

    def at(self, phi_rad: Floats) -> Follower:
        """Return the follower at spindle angles [rad]."""
        return self.contacts(phi_rad)[1]


def make_lobes(part: LobePart) -> list[ShaftLobe]:
    """Return the lobes of a camshaft, upwards; refuse what cannot be made, see `_shaped`."""
    lobes: list[ShaftLobe] = []
    profiles: dict[str, ShaftLobe] = {}
    for i, lobe in enumerate(part.cam.lobe):
        field = f"cam.lobe.{i}"
        z_mm, phase_rad = (lobe.z_mm[0], lobe.z_mm[1]), float(np.radians(lobe.phase_deg))
        alike = lobe.model_dump_json(exclude={"z_mm", "phase_deg"})
        if alike not in profiles:
            try:
                profiles[alike] = replace(_shaped(part, lobe, field), profile=len(profiles))
            except GeometryError as error:
                raise _with_band(error, part, lobe, field) from None
        lobes.append(replace(profiles[alike], z_mm=z_mm, phase_rad=phase_rad))
    return lobes


def _shaped(part: LobePart, lobe: Lobe, field: str) -> ShaftLobe:
    """Return one lobe that its follower can have and its wheel can grind."""
    base_mm, roller_mm = part.cam.base_radius_mm, part.cam.roller_radius_mm
    is_flat = part.cam.follower == "flat"
    law = make_lift(part.cam, lobe, field)
    check_share(f"{field}.smooth_um", smoothing_takes_um([law]), part.process.form_error_um)
    touch = all_round(law, base_mm, roller_mm, is_flat=is_flat)
    check_follower(touch, field, is_flat=is_flat)
    if part.process.operation != "turning" and not is_flat:
        check_wheel(touch, part.follower_radius_mm, field)
    return ShaftLobe(
        law,
        base_mm,
        roller_mm,
        part.follower_radius_mm,
        float(np.radians(lobe.phase_deg)),
        (lobe.z_mm[0], lobe.z_mm[1]),
        shape_of(law, base_mm, roller_mm, is_flat=is_flat),
        is_flat=is_flat,
    )


def _with_band(error: GeometryError, part: LobePart, lobe: Lobe, field: str) -> GeometryError:
    if lobe.law != "list":
        return error
    form_error_um = part.process.form_error_um
    bands = bands_of(points_of(lobe, field), of_jerk=True)
    wider = (band for band in bands if band > (lobe.smooth_um or 0))
    for band_um in wider:
        allowed_um = form_error_for(band_um, form_error_um)
        process = part.process.model_copy(update={"form_error_um": allowed_um})
        allowing = part.model_copy(update={"process": process})
        try:
            _shaped(allowing, lobe.model_copy(update={"smooth_um": band_um}), field)
        except GeometryError:
            continue
        problem, _, remedy = error.lines[0].removeprefix(f"{error.field}: ").rpartition("; ")
        words = band_words(band_um, band_um, form_error_um)
        remedy += f"; or smooth the noise of the list: {field}.{words}"
        return GeometryError(error.field, problem, remedy)
    return error


def profiles_of(lobes: list[ShaftLobe]) -> list[ShaftLobe]:
    """Return one lobe of each profile, in its own frame: its phase is 0."""
    firsts = {lobe.profile: lobe for lobe in reversed(lobes)}
    return [replace(firsts[i], phase_rad=0.0) for i in sorted(firsts)]


def example_lobe(operation: str = "turning") -> LobePart:
    """Return the 3-4-5 lobe of the worked numbers, MATHS.md (37), for examples."""
    lobe = Lobe(z_mm=[0, 12], law="poly345", lift_mm=8, half_angle_deg=70)
    return LobePart(
        part=PartInfo(name="example", kind="cam", source="MATHS.md (37)"),
        cam=Camshaft(base_radius_mm=20, roller_radius_mm=10, wheel_radius_mm=200, lobe=[lobe]),
        process=LobeProcess.model_validate({"operation": operation, "spindle_rpm": 60}),
    )


def lobes_key(part: LobePart) -> Hashable:
    """Return what the lobes of a part follow from."""
    files = tuple(file_state(lobe.csv) for lobe in part.cam.lobe if lobe.csv is not None)
    process, is_smoothed = part.process, any(lobe.smooth_um for lobe in part.cam.lobe)
    allowed_um = process.form_error_um if is_smoothed else None  # it limits smoothing
    return part.cam.model_dump_json(), process.operation, part.follower_radius_mm, files, allowed_um


def channels_key(part: LobePart, tolerance_nm: float) -> Hashable:
    """Return what the channels over the angle follow from; a plunge cut has its plan in them."""
    process = part.model_dump_json() if part.process.is_plunge else ""
    return lobes_key(part), process, tolerance_nm


def lobes_of(part: LobePart) -> list[ShaftLobe]:
    """Return `make_lobes` of a part, recalled where a memory is open."""
    return recall(("lobes", lobes_key(part)), lambda: make_lobes(part))
