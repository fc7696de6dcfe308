"""What is worked out about a camshaft: motion of the tool, wheel and speed, contact, curvature.

>>> from camtools.lobe.motion import example_lobe
>>> [study] = study_lobes(example_lobe("grinding"), LobeWishes(step_deg=10.0))
>>> i = int(np.flatnonzero(study.theta_deg.round(9) == -40)[0])
>>> f"{study.touch.lift[i]:.7f} {study.path.lift[i]:.7f} {study.n_c_rpm[i]:.6f}"
'2.9430594 1.2972356 38.079473'
"""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from camtools.base.csv_text import csv_text
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, omega_rad_s
from camtools.lobe.contact import Contact, Follower
from camtools.lobe.motion import ShaftLobe, make_lobes
from camtools.lobe.part import MAX_RPM, MIN_RPM, LobePart

_STEPS_DEG = (0.01, 45.0)
_FLAT_MM = 1e6  # radii beyond it are written as this one
_DENSE = 7201


class LobeWishes(NamedTuple):
    """What the user may choose; None is the part's own."""

    step_deg: float = 3.0
    rpm: float | None = None


class LobeStudy(NamedTuple):
    """One lobe over a turn of the follower's line, from -180 degrees of the law on."""

    number: int
    lobe: ShaftLobe
    operation: str  # turning | grinding
    rpm: float  # uniform speed, or that on the base circle
    theta_deg: Floats  # direction of the follower's line, from the zero of the law
    touch: Contact
    path: Follower  # of the roller itself when turned, of the wheel when ground

    @property
    def omega_rad_s(self) -> float:
        """Return the speed of the spindle."""
        return omega_rad_s(self.rpm)

    @property
    def n_c_rpm(self) -> Floats:
        """Return the cam's speed N_C at which the contact travels as on the base circle."""
        return np.asarray(self.rpm * self.lobe.base_mm / self.path.ds_dphi, dtype=np.float64)

    @property
    def curvature_radius_mm(self) -> Floats:
        """Return the profile's radius of curvature, below 0 where it is hollow."""
        flat = np.abs(self.touch.curvature) < 1 / _FLAT_MM
        safe = np.where(flat, 1.0, self.touch.curvature)
        return np.where(flat, _FLAT_MM, 1 / safe)


def _check(wishes: LobeWishes) -> None:
    low, high = _STEPS_DEG
    if not (isfinite(wishes.step_deg) and low <= wishes.step_deg <= high):
        problem = f"--step-deg {wishes.step_deg}: out of range"
        raise CamtoolsError([f"{problem}; give {low:g} .. {high:g}"])
    if abs(90 / wishes.step_deg - round(90 / wishes.step_deg)) > 1e-9:
        problem = f"--step-deg {wishes.step_deg}: does not divide 90 degrees"
        raise CamtoolsError([f"{problem}; give 1, 2, 3, 5 ..."])
    if wishes.rpm is not None and not MIN_RPM <= wishes.rpm <= MAX_RPM:
        problem = f"--rpm {wishes.rpm}: out of range"
        raise CamtoolsError([f"{problem}; give {MIN_RPM:g} .. {MAX_RPM:g}"])


def study_lobe(
    part: LobePart, number: int, lobe: ShaftLobe, theta_deg: Floats, rpm: float
) -> LobeStudy:
    """Return one lobe at directions of the follower's line [degrees from the zero of the law]."""
    touch, path = lobe.touch_at(np.radians(theta_deg))
    return LobeStudy(number, lobe, part.process.operation, rpm, theta_deg, touch, path)


def study_lobes(part: LobePart, wishes: LobeWishes) -> list[LobeStudy]:
    """Return all lobes of a camshaft.

    Raises
    ------
    CamtoolsError
        A wish is out of range, or a lobe is impossible.
    """
    _check(wishes)
    rpm = part.process.spindle_rpm if wishes.rpm is None else wishes.rpm
    n = round(360 / wishes.step_deg)
    theta_deg = np.arange(n + 1, dtype=np.float64) * (360.0 / n) - 180
    lobes = make_lobes(part)
    return [study_lobe(part, i, lobe, theta_deg, rpm) for i, lobe in enumerate(lobes)]


def lobe_table(study: LobeStudy) -> str:
    """Return one lobe as CSV: angles from the zero of its law, in the drawing's sense."""
    omega, touch, path = study.omega_rad_s, study.touch, study.path
    columns: dict[str, tuple[Floats, int]] = {
        "theta_deg": (study.theta_deg, 6),
        "lift_mm": (touch.lift, 9),
        "contact_radius_mm": (touch.radius, 9),
        "contact_angle_deg": (np.degrees(touch.alpha), 6),
        "pressure_angle_deg": (np.degrees(touch.gamma), 6),
        "curvature_radius_mm": (study.curvature_radius_mm, 6),
        "phi_deg": (np.degrees(path.phi), 6),
    }
    if study.operation == "turning":
        columns |= {
            "t_s": ((path.phi + np.pi) / omega, 9),
            "x_mm": (path.lift, 9),
            "x_speed_mm_s": (path.d1 * omega, 6),
            "x_acceleration_mm_s2": (path.d2 * omega**2, 4),
            "swing_deg": (np.degrees(path.angle), 6),
            "swing_speed_deg_s": (np.degrees(path.angle1) * omega, 4),
            "swing_acceleration_deg_s2": (np.degrees(path.angle2) * omega**2, 2),
        }
    else:
        columns |= {
            "s_mm": (path.lift, 9),
            "s_speed_mm_rad": (path.d1, 6),
            "ds_dphi_mm_rad": (path.ds_dphi, 6),
            "n_c_rpm": (study.n_c_rpm, 6),
        }
    return csv_text(columns)


def lobe_figures(part: LobePart, studies: list[LobeStudy]) -> dict[str, Any]:
    """Return the extremes of every lobe; names carry their units."""
    dense = np.linspace(-180, 180, _DENSE)
    found = []
    for study in studies:
        all_round = study_lobe(part, study.number, study.lobe, dense, study.rpm)
        omega, path, shape = study.omega_rad_s, all_round.path, study.lobe.shape
        facts = {
            "z_mm": list(study.lobe.z_mm),
            "phase_deg": float(np.degrees(study.lobe.phase_rad)),
            "largest_lift_mm": float(all_round.touch.lift.max()),
            "least_convex_radius_mm": shape.least_radius_mm,
            "hollow_radius_mm": shape.hollow_radius_mm
            if isfinite(shape.hollow_radius_mm)
            else None,
            "largest_pressure_angle_deg": shape.largest_swing_deg,
            "largest_speed_mm_s": float(np.abs(path.d1).max()) * omega,
            "largest_acceleration_mm_s2": float(np.abs(path.d2).max()) * omega**2,
        }
        if study.operation == "turning":
            swing = float(np.degrees(np.abs(path.angle1).max()))
            facts["largest_swing_speed_deg_s"] = swing * omega
        else:
            facts["n_c_rpm"] = [float(all_round.n_c_rpm.min()), float(all_round.n_c_rpm.max())]
        found.append(facts)
    name, process = part.part.name, part.process
    return {"part": name, "operation": process.operation, "rpm": studies[0].rpm, "lobes": found}


def lobe_text(figures: dict[str, Any]) -> str:
    """Return the extremes as a few lines for people."""
    lines = [f"{figures['part']}: {figures['operation']} at {figures['rpm']:g} r/min"]
    for i, one in enumerate(figures["lobes"]):
        first, last = one["z_mm"]
        lines.append(
            f"  lobe {i}, height {first:g} .. {last:g} mm: lift {one['largest_lift_mm']:g} mm, "
            f"pressure angle up to {one['largest_pressure_angle_deg']:.3f} degrees, sharpest "
            f"radius {one['least_convex_radius_mm']:.3f} mm"
        )
        axis = "X" if figures["operation"] == "turning" else "wheel"
        lines.append(
            f"    {axis} up to {one['largest_speed_mm_s']:.1f} mm/s and "
            f"{one['largest_acceleration_mm_s2']:.0f} mm/s2 at uniform speed"
        )
        if "n_c_rpm" in one:
            low, high = one["n_c_rpm"]
            lines.append(
                f"    constant surface speed: the cam turns at {low:.2f} .. {high:.2f} r/min, "
                "before any limit of the spindle"
            )
        else:
            lines.append(f"    swing up to {one['largest_swing_speed_deg_s']:.1f} degrees/s")
    return "\n".join(lines) + "\n"
