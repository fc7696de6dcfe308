"""A section of a part: areas, equal parts, speed law, forces; tables, figures and notes of them.

>>> from camtools.skirt.part.part_file import example_part
>>> study = make_analysis(example_part(), AnalysisWishes())
>>> study.height_mm, figures(study)["parts"]["largest_depth_change_in_part"]
(20.0, 9)
>>> table_files(study)["depth_and_area.csv"].splitlines()[1]
'0.000000,0.100000000,0.000000000,0.000000000'
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np

from camtools.base.arguments import Option
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, omega_rad_s
from camtools.base.text import Columns, csv_text
from camtools.cut.removal import (
    TURN_RAD,
    ChipForce,
    Parts,
    PartsRange,
    Rates,
    SectionCut,
    SpeedPeaks,
    Steps,
    equal_volume_angles,
    harmonics_mm,
    mean_rpm_for,
    motion_at,
    parts_of,
    parts_range,
    rates_of,
    speed_peaks,
    steps_of,
)
from camtools.papers.declared import notes as declared_notes
from camtools.skirt.geometry.skirt_geometry import Geometry, axes_at, make_geometry, section_cut
from camtools.skirt.part.part_file import SkirtPart

Table = dict[str, tuple[Floats, int]]  # values and decimals by the name of the column
N_HARMONICS = 12
_N_SAMPLES = 4096
_MEAN_RPM = (300.0, 800.0, 1500.0, 2500.0)
_ALPHA_RAD_S2 = (100.0, 500.0, 1000.0, 5000.0)
_PAPERS = (46.0, 46.1, 10.846348637)  # half axis, blank [mm], area of a quarter [mm2]


@dataclass(frozen=True)
class AnalysisWishes:
    """How a section is analysed; None is the part's own."""

    height: Annotated[
        float | None, Option("height of the section in mm (default: of the largest diameter)", "MM")
    ] = None
    step_deg: Annotated[float, Option("step of Table 1 in degrees (default: 3)", "D")] = 3.0
    parts: Annotated[
        int | None, Option("equal parts of a quarter turn (default: the part's)", "N")
    ] = None
    turns: Annotated[int, Option("turns in the tables of axis positions (default: 1)", "N")] = 1
    slice_volume_mm3: Annotated[
        float, Option("largest volume of a slice in mm3 (default: 0.04)", "V")
    ] = 0.04
    cycle_us: Annotated[float, Option("controller cycle in us (default: 50)", "T")] = 50.0
    kc_n_mm2: Annotated[float, Option("specific cutting force in N/mm2 (default: 700)", "K")] = (
        700.0
    )
    kc_exponent: Annotated[float, Option("exponent of its size effect (default: 0, none)", "M")] = (
        0.0
    )
    nose_mm: Annotated[float, Option("nose radius of the tool in mm (default: 0.8)", "R")] = 0.8
    rpm: Annotated[
        float | None, Option("mean spindle speed in r/min (default: the part's)", "N")
    ] = None


_RANGES = {
    "step_deg": (0.01, 45.0),
    "slice_volume_mm3": (1e-9, 1e6),
    "cycle_us": (0.01, 1e6),
    "kc_n_mm2": (0.001, 1e6),
    "kc_exponent": (0.0, 0.9),
    "rpm": (0.001, 60_000.0),
    "parts": (2, 1000),
    "turns": (1, 100),
    "nose_mm": (0.01, 100.0),
}


def check_wishes(wishes: Mapping[str, Any], ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse options out of their ranges, and a step that does not divide 90 degrees.

    Raises CamtoolsError, which names the first of them.
    """
    for name, (low, high) in ranges.items():
        value, option = wishes[name], f"--{name.replace('_', '-')}"
        if value is not None and not low <= value <= high:
            raise CamtoolsError([f"{option} {value}: out of range; give {low:g} .. {high:g}"])
    step = wishes["step_deg"]
    if abs(90 / step - round(90 / step)) > 1e-9:
        problem = f"--step-deg {step}: does not divide 90 degrees"
        raise CamtoolsError([f"{problem}; give 1, 2, 3, 5 ..."])


@dataclass(frozen=True, eq=False)
class Analysis:
    """A section of a part, worked out as the user wishes."""

    name: str
    part: SkirtPart
    wishes: AnalysisWishes
    geometry: Geometry
    height_mm: float
    cut: SectionCut
    rpm: float  # mean speed
    omega_rad_s: float
    feed_mm: float
    force: ChipForce
    steps: Steps
    parts: Parts
    range: PartsRange
    peaks: SpeedPeaks
    rates: Rates
    waves_mm: tuple[Floats, Floats]  # cosine amplitudes of U, uniform and at constant rate
    chip_mm: tuple[float, float]  # least and largest depth
    at_part: int  # in which the depth changes most, from 1 on
    at_part_deg: tuple[float, float]

    def chip_n(self, depth_mm: Floats) -> Floats:
        """Return the force of chips of the feed."""
        return self.force.chip_n(depth_mm, self.feed_mm)


def make_analysis(part: SkirtPart, wishes: AnalysisWishes) -> Analysis:
    """Return the analysis of a part's section.

    Raises CamtoolsError where a wish or the geometry is impossible, or nothing is cut.
    """
    check_wishes(asdict(wishes), _RANGES)
    geometry, profile, process = make_geometry(part), part.piston.profile, part.process
    low, high = float(profile.height_mm[0]), float(profile.height_mm[-1])
    height_mm = wishes.height
    if height_mm is None:
        height_mm = float(profile.height_mm[int(np.argmax(profile.diameter_mm))])
    if not low <= height_mm <= high:
        problem = f"--height {height_mm}: lies outside the part"
        raise CamtoolsError([f"{problem}; give {low:g} .. {high:g} mm"])
    cut = section_cut(geometry, process.depth_mm, height_mm)
    if float(cut.depth_mm(np.linspace(0, TURN_RAD, 721)).min()) <= 0:
        problem = f"nothing is cut somewhere at height {height_mm:g} mm"
        raise CamtoolsError([f"process.depth_mm: {problem}; give a larger depth or other height"])
    rpm = process.spindle_rpm if wishes.rpm is None else wishes.rpm
    steps = steps_of(cut, np.radians(wishes.step_deg))
    parts = parts_of(cut, process.parts if wishes.parts is None else wishes.parts)
    feed, kc, cycle_s = process.feed_mm, wishes.kc_n_mm2, wishes.cycle_us * 1e-6
    at_part, part_deg = int(np.argmax(parts.change_mm)), np.degrees(np.append(0.0, parts.phi_rad))
    u_mm = cut.delta(TURN_RAD * np.arange(_N_SAMPLES) / _N_SAMPLES).delta
    waves_mm = np.real(np.fft.rfft(u_mm)[: N_HARMONICS + 1]) / _N_SAMPLES
    waves_mm[1:] *= 2
    depth_mm = cut.depth_mm(np.linspace(0, cut.pattern_rad, 2001))
    return Analysis(
        *(part.part.name, part, wishes, geometry, height_mm, cut),
        *(rpm, omega_rad_s(rpm), feed, ChipForce(kc, wishes.kc_exponent, wishes.nose_mm)),
        *(steps, parts, parts_range(cut, feed, rpm, wishes.slice_volume_mm3, cycle_s)),
        *(speed_peaks(cut), rates_of(cut, steps, feed, rpm, kc)),
        waves_mm=(waves_mm, harmonics_mm(cut, N_HARMONICS)),
        chip_mm=(float(depth_mm.min()), float(depth_mm.max())),
        at_part=at_part + 1,
        at_part_deg=(float(part_deg[at_part]), float(part_deg[at_part + 1])),
    )


def speed_law(study: Analysis, deg: Floats) -> Table:
    """Return the law of constant removal rate at angles of the spindle."""
    phi, omega = np.radians(deg), study.omega_rad_s
    ratio, product, speed, motion = motion_at(study.cut, phi)
    rate = study.feed_mm * study.cut.area_rate_mm2(phi) * omega
    return {
        "angle_deg": (deg, 1),
        "speed_ratio": (ratio, 9),
        "spindle_rpm": (ratio * study.rpm, 4),
        "spindle_acceleration_rad_s2": (product * omega**2, 4),
        "u_speed_mm_s": (speed * omega, 6),
        "u_acceleration_mm_s2": (motion * omega**2, 4),
        "removal_rate_mm3_s": (rate * ratio, 6),
        "uniform_removal_rate_mm3_s": (rate, 6),
    }


def _axes(study: Analysis, angles: Floats) -> Table:
    t_s = study.wishes.turns * 60 / study.rpm * np.arange(angles.size) / (angles.size - 1)
    axes = axes_at(study.geometry, study.height_mm, study.feed_mm, angles, t_s)
    columns = {"t_s": (axes.t_s, 9), "c_deg": (np.degrees(axes.c_rad), 6), "z_mm": (axes.z_mm, 6)}
    return {**columns, "x_mm": (axes.x_mm, 9), "u_mm": (axes.u_mm, 9)}


def tables(study: Analysis) -> dict[str, Table]:
    """Return all tables; the numbers of the papers' tables are those of S0."""
    cut, steps, parts, peaks = study.cut, study.steps, study.parts, study.peaks
    n, turns, kc = parts.phi_rad.size, study.wishes.turns, study.wishes.kc_n_mm2
    n_all = n * cut.n_patterns * turns
    count = np.arange(1.0, n + 1)
    equal_rad = cut.pattern_rad * count / n
    area_mm2 = np.diff(cut.area_mm2(np.append(0.0, equal_rad)))
    rpm = np.array([*_MEAN_RPM, study.rpm])
    omega = TURN_RAD * rpm / 60
    alpha = np.array([*_ALPHA_RAD_S2, study.part.machine.limits.alpha_rad_s2])
    highest = np.array([mean_rpm_for(peaks, float(limit)) for limit in alpha])
    uniform_mm, even_mm = study.waves_mm
    return {
        "depth_and_area": {  # Table 1
            "angle_deg": (np.degrees(steps.phi_rad), 6),
            "depth_mm": (steps.depth_mm, 9),
            "depth_change_mm": (steps.change_mm, 9),
            "area_mm2": (steps.area_mm2, 9),
        },
        "equal_parts": {  # Table 4
            "part": (count, 0),
            "angle_deg": (np.degrees(parts.phi_rad), 6),
            "width_deg": (np.degrees(parts.width_rad), 6),
            "depth_mm": (parts.depth_mm, 9),
            "depth_change_mm": (parts.change_mm, 9),
            "speed_ratio": (parts.speed_ratio, 6),
        },
        # Table 5: equal angles in uniform turning, equal times at equal volume
        "axes_uniform": _axes(study, TURN_RAD * turns * np.arange(n_all + 1) / n_all),
        "axes_equal_volume": _axes(study, equal_volume_angles(cut, n, turns)),
        "speed_law": speed_law(study, np.arange(0.0, 361.0)),
        "forces": {
            "part": (count, 0),
            "uniform_angle_deg": (np.degrees(equal_rad), 6),
            "uniform_rate_force_n": (kc * area_mm2, 4),
            "uniform_chip_force_n": (study.chip_n(cut.depth_mm(equal_rad)), 4),
            "equal_volume_angle_deg": (np.degrees(parts.phi_rad), 6),
            "equal_volume_rate_force_n": (np.full(n, kc * cut.total_mm2 / n), 4),
            "equal_volume_chip_force_n": (study.chip_n(parts.depth_mm), 4),
        },
        "harmonics": {
            "per_turn": (np.arange(float(even_mm.size)), 0),
            "uniform_mm": (uniform_mm, 6),
            "equal_volume_mm": (even_mm, 6),
        },
        "mean_speeds": {
            "mean_rpm": (rpm, 2),
            "largest_rpm": (rpm * peaks.ratio_max, 2),
            "least_rpm": (rpm * peaks.ratio_min, 2),
            "spindle_acceleration_rad_s2": (peaks.alpha * omega**2, 1),
            "u_speed_mm_s": (peaks.u1_mm * omega, 4),
            "u_acceleration_max_mm_s2": (peaks.u2_max_mm * omega**2, 2),
            "u_acceleration_min_mm_s2": (peaks.u2_min_mm * omega**2, 2),
            "part_ms": (60_000 / (rpm * n * cut.n_patterns), 5),
        },
        "mean_speed_limits": {
            "spindle_acceleration_rad_s2": (alpha, 1),
            "highest_mean_rpm": (highest, 3),
            "highest_rpm": (highest * peaks.ratio_max, 3),
        },
    }


def table_files(study: Analysis) -> dict[str, str]:
    """Return all tables as CSV by file name."""
    return {f"{name}.csv": csv_text(columns) for name, columns in tables(study).items()}


def figures(study: Analysis) -> dict[str, Any]:
    """Return the figures of an analysis; names carry their units."""
    cut, peaks, rates, wishes = study.cut, study.peaks, study.rates, study.wishes
    omega, n = study.omega_rad_s, study.parts.phi_rad.size
    alpha = study.part.machine.limits.alpha_rad_s2
    waves_mm = study.waves_mm[1]
    return {
        "part": study.name,
        "section": {
            "height_mm": study.height_mm,
            "long_half_axis_mm": cut.a_mm,
            "blank_radius_mm": cut.blank_mm,
            "pattern_deg": float(np.degrees(cut.pattern_rad)),
            "area_mm2": cut.total_mm2,
        },
        "parts": {
            "n": n,
            "area_mm2": cut.total_mm2 / n,
            "least": study.range.least,
            "most": study.range.most,
            "largest_depth_change_in_part": study.at_part,
        },
        "speed": {
            "mean_rpm": study.rpm,
            "largest_rpm": study.rpm * peaks.ratio_max,
            "least_rpm": study.rpm * peaks.ratio_min,
            "spindle_acceleration_rad_s2": peaks.alpha * omega**2,
            "spindle_acceleration_at_deg": float(np.degrees(peaks.alpha_rad)),
            "highest_mean_rpm": mean_rpm_for(peaks, alpha),
            "spindle_limit_rad_s2": alpha,
            "u_speed_mm_s": peaks.u1_mm * omega,
            "u_acceleration_max_mm_s2": peaks.u2_max_mm * omega**2,
            "u_acceleration_min_mm_s2": peaks.u2_min_mm * omega**2,
        },
        "removal": {
            "feed_mm": study.feed_mm,
            "kc_n_mm2": wishes.kc_n_mm2,
            "kc_exponent": wishes.kc_exponent,
            "rate_mm3_s": rates.rate_mm3_s,
            "power_w": rates.power_w,
            "uniform_largest_to_least": rates.largest_to_least,
            "uniform_ripple": rates.ripple,
            "uniform_steps_largest_to_least": rates.steps_largest_to_least,
            "uniform_steps_ripple": rates.steps_ripple,
        },
        "u_waves_mm": {f"{i}": float(waves_mm[i]) for i in range(2, waves_mm.size, 2)},
    }


def summary(study: Analysis) -> str:
    """Return the essentials as a few lines for people."""
    cut, rates, speed = study.cut, study.rates, figures(study)["speed"]
    low_n, high_n = study.chip_n(np.array(study.chip_mm))
    return (
        f"{study.name}: section at height {study.height_mm:g} mm, blank radius {cut.blank_mm:.4f} "
        f"mm, {np.degrees(cut.pattern_rad):g} degrees cut {cut.total_mm2:.6f} mm2\n"
        f"  uniform turning: removal rate varies 1 : {rates.largest_to_least:.3f}, ripple "
        f"{100 * rates.ripple:.2f} % of its mean\n"
        f"  {_parts_line(study)}\n"
        f"  equal volume at mean {study.rpm:g} r/min: {speed['least_rpm']:.1f} .. "
        f"{speed['largest_rpm']:.1f} r/min, {speed['spindle_acceleration_rad_s2']:.0f} rad/s2; the "
        f"machine's {speed['spindle_limit_rad_s2']:g} rad/s2 allow "
        f"{speed['highest_mean_rpm']:.1f} r/min\n"
        f"  constant then: {rates.rate_mm3_s:.3f} mm3/s and {rates.power_w:.3f} W; not constant: "
        f"the force of the chip, {low_n:.2f} .. {high_n:.2f} N at any speed law\n"
    )


def _parts_line(study: Analysis) -> str:
    """Return the possible numbers of parts; judged where the part is turned in equal parts."""
    n, (least, most) = study.parts.phi_rad.size, study.range
    bounds = f"{least} (volume of a part) .. {most} (controller's cycle)"
    if study.part.process.mode != "equal-volume" and study.wishes.parts is None:
        return f"the part is turned uniformly; equal volume would need {bounds} equal parts"
    if least > most:
        remedy = "turn more slowly, feed less, or allow --slice-volume-mm3"
        return f"{n} equal parts: no number of parts is possible, {bounds}; {remedy}"
    if least <= n <= most:
        return f"{n} equal parts are possible; the range is {bounds}"
    return f"{n} equal parts are not possible; give {bounds} by --parts or process.parts"


def notes(study: Analysis) -> str:
    """Return the notes for a reader of the papers (Markdown)."""
    ours = study.cut.a_mm, study.cut.blank_mm, study.cut.total_mm2
    is_papers = all(abs(own - printed) < 1e-6 for own, printed in zip(ours, _PAPERS, strict=True))
    ratio = study.chip_mm[1] / study.chip_mm[0]
    return declared_notes("section", vars(study) | {"chip_ratio": ratio}, is_papers=is_papers)


def turn(study: Analysis) -> Columns:
    """Return speed law, motion of U in time, forces and power over a turn."""
    deg, omega, cut = np.linspace(0, 360, 1441), study.omega_rad_s, study.cut
    phi, law = np.radians(deg), speed_law(study, deg)
    ratio, area = law["speed_ratio"][0], cut.area_rate_mm2(phi)
    steps = np.diff(phi) * (1 / ratio[1:] + 1 / ratio[:-1]) / 2
    turned = np.r_[0.0, np.cumsum(steps)]  # of a uniform spindle in the same time
    uniform, depth_mm = cut.delta(turned), cut.depth_mm(phi)
    force = study.wishes.kc_n_mm2 * area * cut.pattern_rad / study.parts.phi_rad.size
    chip_n_mm = study.force.specific_n_mm2(depth_mm, study.feed_mm) * study.feed_mm
    power = chip_n_mm * area * omega / 1000
    more = {
        "mean_rpm": np.full(deg.size, study.rpm),
        "time_ms": 1000 * turned / omega,
        "u_um": 1000 * cut.delta(phi).delta,
        "uniform_u_um": 1000 * uniform.delta,
        "uniform_u_speed_mm_s": uniform.d1 * omega,
        "uniform_u_acceleration_mm_s2": uniform.d2 * omega**2,
        "force_by_rate_n": force * ratio,
        "uniform_force_by_rate_n": force,
        "force_of_the_chip_n": study.chip_n(depth_mm),
        "power_w": power * ratio,
        "uniform_power_w": power,
    }
    return {**law, **{name: (values, 6) for name, values in more.items()}}
