"""Tables of the analysis of one section, as CSV text.

>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.study.section import AnalysisWishes, make_analysis
>>> depth_and_area(make_analysis(example_part(), AnalysisWishes())).splitlines()[1]
'0.000000,0.100000000,0.000000000,0.000000000'
"""

from __future__ import annotations

import numpy as np

from camtools.base.csv_text import csv_text
from camtools.base.quantities import Floats
from camtools.cut.removal import TURN_RAD, equal_volume_angles, mean_rpm_for, motion_at
from camtools.skirt.geometry.blank import axes_at
from camtools.study.section import Analysis

_MEAN_RPM = (300.0, 800.0, 1500.0, 2500.0)
_ALPHA_RAD_S2 = (100.0, 500.0, 1000.0, 5000.0)


def _count(n: int) -> Floats:
    return np.arange(1.0, n + 1)


def depth_and_area(study: Analysis) -> str:
    """Return Table 1: depth, its change and area in equal steps of angle."""
    steps = study.steps
    return csv_text(
        {
            "angle_deg": (np.degrees(steps.phi_rad), 6),
            "depth_mm": (steps.depth_mm, 9),
            "depth_change_mm": (steps.change_mm, 9),
            "area_mm2": (steps.area_mm2, 9),
        }
    )


def equal_parts(study: Analysis) -> str:
    """Return Table 4: the parts of equal area."""
    parts = study.parts
    return csv_text(
        {
            "part": (_count(parts.phi_rad.size), 0),
            "angle_deg": (np.degrees(parts.phi_rad), 6),
            "width_deg": (np.degrees(parts.width_rad), 6),
            "depth_mm": (parts.depth_mm, 9),
            "depth_change_mm": (parts.change_mm, 9),
            "speed_ratio": (parts.speed_ratio, 6),
        }
    )


def axes_uniform(study: Analysis) -> str:
    """Return Table 5 of uniform turning: as many equal angles as there are parts."""
    n = study.parts.phi_rad.size * study.cut.n_patterns * study.turns
    return _axes(study, TURN_RAD * study.turns * np.arange(n + 1) / n)


def axes_equal_volume(study: Analysis) -> str:
    """Return Table 5 of equal-volume turning: equal times, unequal angles."""
    return _axes(study, equal_volume_angles(study.cut, study.parts.phi_rad.size, study.turns))


def _axes(study: Analysis, angles: Floats) -> str:
    t_s = study.turns * 60 / study.rpm * np.arange(angles.size) / (angles.size - 1)
    axes = axes_at(study.geometry, study.height_mm, study.feed_mm, angles, t_s)
    return csv_text(
        {
            "t_s": (axes.t_s, 9),
            "c_deg": (np.degrees(axes.c_rad), 6),
            "z_mm": (axes.z_mm, 6),
            "x_mm": (axes.x_mm, 9),
            "u_mm": (axes.u_mm, 9),
        }
    )


def speed_law(study: Analysis) -> str:
    """Return the law of constant removal rate at the mean speed, degree by degree."""
    phi = np.radians(np.arange(0.0, 361.0))
    ratio, product, speed, motion = motion_at(study.cut, phi)
    omega = TURN_RAD * study.rpm / 60
    rate = study.feed_mm * study.cut.area_rate_mm2(phi) * omega
    return csv_text(
        {
            "angle_deg": (np.degrees(phi), 1),
            "speed_ratio": (ratio, 9),
            "spindle_rpm": (ratio * study.rpm, 4),
            "spindle_acceleration_rad_s2": (product * omega**2, 4),
            "u_speed_mm_s": (speed * omega, 6),
            "u_acceleration_mm_s2": (motion * omega**2, 4),
            "removal_rate_mm3_s": (rate * ratio, 6),
            "uniform_removal_rate_mm3_s": (rate, 6),
        }
    )


def forces(study: Analysis) -> str:
    """Return the force in each equal angle and each equal part, in both models."""
    parts, kc = study.parts, study.kc_n_mm2
    n = parts.phi_rad.size
    angle = study.cut.pattern_rad * _count(n) / n
    area = np.diff(study.cut.area_mm2(np.append(0.0, angle)))
    return csv_text(
        {
            "part": (_count(n), 0),
            "uniform_angle_deg": (np.degrees(angle), 6),
            "uniform_rate_force_n": (kc * area, 4),
            "uniform_chip_force_n": (study.chip_n(study.cut.depth_mm(angle)), 4),
            "equal_volume_angle_deg": (np.degrees(parts.phi_rad), 6),
            "equal_volume_rate_force_n": (np.full(n, kc * study.cut.total_mm2 / n), 4),
            "equal_volume_chip_force_n": (study.chip_n(parts.depth_mm), 4),
        }
    )


def harmonics(study: Analysis) -> str:
    """Return the cosine amplitudes of U in uniform and equal-volume turning."""
    return csv_text(
        {
            "per_turn": (np.arange(study.waves_mm.size, dtype=np.float64), 0),
            "uniform_mm": (study.uniform_waves_mm, 6),
            "equal_volume_mm": (study.waves_mm, 6),
        }
    )


def mean_speeds(study: Analysis) -> str:
    """Return what constant removal needs at several mean speeds."""
    rpm, peaks = np.array([*_MEAN_RPM, study.rpm]), study.peaks
    omega, n = TURN_RAD * rpm / 60, study.parts.phi_rad.size
    return csv_text(
        {
            "mean_rpm": (rpm, 2),
            "largest_rpm": (rpm * peaks.ratio_max, 2),
            "least_rpm": (rpm * peaks.ratio_min, 2),
            "spindle_acceleration_rad_s2": (peaks.alpha * omega**2, 1),
            "u_speed_mm_s": (peaks.u1_mm * omega, 4),
            "u_acceleration_max_mm_s2": (peaks.u2_max_mm * omega**2, 2),
            "u_acceleration_min_mm_s2": (peaks.u2_min_mm * omega**2, 2),
            "part_ms": (60_000 / (rpm * n * study.cut.n_patterns), 5),
        }
    )


def mean_speed_limits(study: Analysis) -> str:
    """Return the highest mean speed for several spindle accelerations."""
    alpha = np.array([*_ALPHA_RAD_S2, study.alpha_rad_s2])
    rpm = np.array([mean_rpm_for(study.peaks, float(one)) for one in alpha])
    return csv_text(
        {
            "spindle_acceleration_rad_s2": (alpha, 1),
            "highest_mean_rpm": (rpm, 3),
            "highest_rpm": (rpm * study.peaks.ratio_max, 3),
        }
    )


def all_tables(study: Analysis) -> dict[str, str]:
    """Return all tables by file name."""
    return {
        "depth_and_area.csv": depth_and_area(study),
        "equal_parts.csv": equal_parts(study),
        "axes_uniform.csv": axes_uniform(study),
        "axes_equal_volume.csv": axes_equal_volume(study),
        "speed_law.csv": speed_law(study),
        "forces.csv": forces(study),
        "harmonics.csv": harmonics(study),
        "mean_speeds.csv": mean_speeds(study),
        "mean_speed_limits.csv": mean_speed_limits(study),
    }
