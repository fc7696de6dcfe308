"""A camshaft: motion of the tool, wheel and speed, contact, curvature; the paper S4 on cams.

>>> from camtools.lobe.motion import example_lobe
>>> [study] = study_lobes(example_lobe("grinding"), LobeWishes(step_deg=10.0))
>>> i = int(np.flatnonzero(study.theta_deg.round(9) == -40)[0])
>>> f"{study.touch.lift[i]:.7f} {study.path.lift[i]:.7f} {study.n_c_rpm[i]:.6f}"
'2.9430594 1.2972356 38.079473'
>>> found = quantities()
>>> f"{found['right_mm']:.6f} {found['printed_mm']:.6f}"
'32.943059 14.111169'
"""

from __future__ import annotations

from functools import cache
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from camtools.base.quantities import Floats, omega_rad_s
from camtools.base.text import Columns
from camtools.lobe.contact import Contact, Follower
from camtools.lobe.motion import ShaftLobe, make_lobes
from camtools.lobe.part import MAX_RPM, MIN_RPM, LobePart
from camtools.papers.declared import declared, part_of
from camtools.papers.section import check_wishes

_RANGES = {"step_deg": (0.01, 45.0), "rpm": (MIN_RPM, MAX_RPM)}
_FLAT_MM = 1e6  # larger radii of curvature are written as this
_DENSE_DEG = np.linspace(-180, 180, 7201)


class LobeWishes(NamedTuple):
    """Options of the user; None is the part's own."""

    step_deg: float = 3.0
    rpm: float | None = None


class LobeStudy(NamedTuple):
    """A lobe over a turn of the follower's line, from -180 degrees of the law on."""

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
        return np.where(flat, _FLAT_MM, 1 / np.where(flat, 1.0, self.touch.curvature))

    def at(self, theta_deg: Floats) -> LobeStudy:
        """Return the lobe at other directions of the follower's line."""
        touch, path = self.lobe.touch_at(np.radians(theta_deg))
        return self._replace(theta_deg=theta_deg, touch=touch, path=path)

    def dense(self) -> LobeStudy:
        """Return the lobe at every twentieth of a degree."""
        return self.at(_DENSE_DEG)


def study_lobes(part: LobePart, wishes: LobeWishes) -> list[LobeStudy]:
    """Return all lobes of a camshaft.

    Raises CamtoolsError where a wish is out of range, or a lobe is impossible.
    """
    check_wishes(wishes._asdict(), _RANGES)
    rpm = part.process.spindle_rpm if wishes.rpm is None else wishes.rpm
    n = round(360 / wishes.step_deg)
    theta_deg = np.arange(n + 1, dtype=np.float64) * (360.0 / n) - 180
    theta, operation = np.radians(theta_deg), part.process.operation
    return [
        LobeStudy(i, lobe, operation, rpm, theta_deg, *lobe.touch_at(theta))
        for i, lobe in enumerate(make_lobes(part))
    ]


def lobe_columns(study: LobeStudy) -> Columns:
    """Return a lobe as a table: angles from the zero of its law, in the drawing's sense."""
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
    return columns


def lobe_figures(part: LobePart, studies: list[LobeStudy]) -> dict[str, Any]:
    """Return the extremes of every lobe; names carry their units."""
    found = []
    for study in studies:
        all_round = study.dense()
        omega, path, shape = study.omega_rad_s, all_round.path, study.lobe.shape
        hollow_mm = shape.hollow_radius_mm
        facts = {
            "z_mm": list(study.lobe.z_mm),
            "phase_deg": float(np.degrees(study.lobe.phase_rad)),
            "largest_lift_mm": float(all_round.touch.lift.max()),
            "least_convex_radius_mm": shape.least_radius_mm,
            "hollow_radius_mm": hollow_mm if isfinite(hollow_mm) else None,
            "largest_pressure_angle_deg": shape.largest_swing_deg,
            "largest_speed_mm_s": float(np.abs(path.d1).max()) * omega,
            "largest_acceleration_mm_s2": float(np.abs(path.d2).max()) * omega**2,
        }
        if study.operation == "turning":
            per_rad = float(np.degrees(np.abs(path.angle1).max()))
            facts["largest_swing_speed_deg_s"] = per_rad * omega
        else:
            facts["n_c_rpm"] = [float(all_round.n_c_rpm.min()), float(all_round.n_c_rpm.max())]
        found.append(facts)
    name, process = part.part.name, part.process
    return {"part": name, "operation": process.operation, "rpm": studies[0].rpm, "lobes": found}


def lobe_text(figures: dict[str, Any]) -> str:
    """Return the extremes as a few lines for people."""
    lines = [f"{figures['part']}: {figures['operation']} at {figures['rpm']:g} r/min"]
    for i, lobe in enumerate(figures["lobes"]):
        first, last = lobe["z_mm"]
        lines.append(
            f"  lobe {i}, height {first:g} .. {last:g} mm: lift {lobe['largest_lift_mm']:g} mm, "
            f"pressure angle up to {lobe['largest_pressure_angle_deg']:.3f} degrees, sharpest "
            f"radius {lobe['least_convex_radius_mm']:.3f} mm"
        )
        axis = "X" if figures["operation"] == "turning" else "wheel"
        lines.append(
            f"    {axis} up to {lobe['largest_speed_mm_s']:.1f} mm/s and "
            f"{lobe['largest_acceleration_mm_s2']:.0f} mm/s2 at uniform speed"
        )
        if "n_c_rpm" in lobe:
            low, high = lobe["n_c_rpm"]
            lines.append(
                f"    constant surface speed: the cam turns at {low:.2f} .. {high:.2f} r/min, "
                "before any limit of the spindle"
            )
        else:
            lines.append(f"    swing up to {lobe['largest_swing_speed_deg_s']:.1f} degrees/s")
    return "\n".join(lines) + "\n"


KEY = "S4"
_CASE = declared(KEY).case


@cache
def studied(name: str) -> LobeStudy:
    """Return the cam of the paper, turned or ground."""
    [study] = study_lobes(part_of(_CASE[name], LobePart), LobeWishes(step_deg=5.0))
    return study


def index() -> int:
    """Return the place of the direction that the figures show."""
    return int(np.argmin(np.abs(studied("turned").theta_deg - _CASE["at_deg"])))


def quantities() -> dict[str, Any]:
    """Return the quantities of the rows; OO' by the right and by the printed sign in (5)."""
    turned, ground, i = studied("turned"), studied("ground"), index()
    touch, swing = turned.touch, turned.dense()
    radius, alpha = float(touch.radius[i]), float(touch.alpha[i] - touch.theta[i])
    along, root = radius * np.cos(alpha), np.sqrt(touch.roller**2 - (radius * np.sin(alpha)) ** 2)
    most = int(np.argmax(np.abs(swing.touch.gamma)))
    wheel_rpm = ground.dense().n_c_rpm
    return {
        "right_mm": along + root,
        "printed_mm": along - root,
        "x_mm": turned.path.lift[i],
        "swing_deg": np.degrees(touch.gamma[i]),
        "most_deg": np.degrees(np.abs(swing.touch.gamma[most])),
        "most_at_deg": swing.theta_deg[most],
        "s_mm": ground.path.lift[i],
        "phi_deg": np.degrees(ground.path.phi[i]),
        "n_c_rpm": ground.n_c_rpm[i],
        "wheel_rpm": (wheel_rpm.min(), wheel_rpm.max()),
    }


TABLES = {
    "s4_turning.csv": lambda: lobe_columns(studied("turned")),
    "s4_grinding.csv": lambda: lobe_columns(studied("ground")),
}
