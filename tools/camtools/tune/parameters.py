r"""A drive file, which has what is known of a force drive and its task, and parameters of its loop.

>>> keys = {"mass_kg": 1.5, "amplifier_hz": 1500.0, "delay_us": 75.0, "tick_hz": 20000.0}
>>> task = {"travel_mm": 1.0, "spindle_rpm": 3000.0, "lobes": 2}
>>> drive = drive_of(keys | {"task": task}, "a.toml")
>>> [f"{newton:.0f}" for newton in drive.needed_n()]
['296', '209']
>>> values = parameters_of(Loop(395.3, 60.21, 3976.8, 48.36, 1252.0, 0.066, 0.102), drive)
>>> values["servo_crossover_hz"], values["servo_force_delay_ns"], loop_of(values, drive).pole_hz
(395, 206103, 3976)
"""

import math
from collections.abc import Mapping
from dataclasses import astuple, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, ValidationError, field_validator

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import read_limited, utf8_text
from camtools.link.kept_values import INFOS
from camtools.part.model import TomlTable, describe_all, wrong
from camtools.sim.machine_file import read_machine
from camtools.tune.loop_design import Loop, Plant, word_shares

_MOST_BYTES = 100_000
_STICTION_M_S = 1e-4  # friction counts in full from this speed on


def _between(least: float, most: float) -> Any:  # noqa: ANN401 - pydantic's FieldInfo is untyped
    return Field(ge=least, le=most)


class Task(TomlTable):
    """A sinusoidal motion of U."""

    travel_mm: Annotated[float, _between(0.001, 100.0)]  # peak to peak
    spindle_rpm: Annotated[float, _between(1.0, 60_000.0)]
    lobes: Annotated[int, _between(1, 100)]  # periods per turn


class Drive(TomlTable):
    """A force drive; what is not known is left out.

    The ranges are those of CAM_SERVO_PARAMS in firmware/feasible/cam_feasible_inner.h.
    """

    mass_kg: Annotated[float, _between(0.01, 100.0)]
    amplifier_hz: Annotated[float, _between(10.0, 100_000.0)]
    delay_us: Annotated[float, _between(0.0, 400.0)]  # latch of the scale to force, without hold
    tick_hz: Annotated[float, _between(1000.0, 200_000.0)]
    drag_n_s_per_m: Annotated[float, _between(0.0, 10_000.0)] = 0.0
    friction_n: Annotated[float, _between(0.0, 200.0)] = 0.0
    stiffness_n_per_m: Annotated[float, _between(0.0, 1e8)] = 0.0
    mode_hz: Annotated[float, _between(0.0, 50_000.0)] = 0.0  # 0: none; else at least 1
    mode_damping: Annotated[float, _between(0.0001, 1.0)] = 0.03
    mode_share: Annotated[float, _between(-10.0, 10.0)] = 0.0
    scale_quantum_nm: Annotated[float, _between(0.0, 10_000.0)] = 0.0  # 0: not known
    force_limit_n: Annotated[float, _between(0.2, 4000.0)] | None = None
    continuous_n: Annotated[float, _between(0.2, 4000.0)] | None = None
    thermal_s: Annotated[float, _between(0.1, 200.0)] | None = None
    force_rate_n_per_ms: Annotated[float, _between(1.0, 1e6)] | None = None
    task: Task | None = None

    @field_validator("mode_hz")
    @classmethod
    def _check_mode(cls, hz: float) -> float:
        if 0.0 < hz < 1.0:
            raise wrong("mode", "must be at least 1", "give hertz, or 0 without a mode")
        return hz

    @property
    def plant(self) -> Plant:
        """The drive as the design of loops takes it."""
        return Plant(
            self.mass_kg, self.amplifier_hz, self.delay_us * 1e-6, self.tick_hz, self.mode_hz,
            self.mode_damping, self.mode_share, self.drag_n_s_per_m, self.stiffness_n_per_m,
        )  # fmt: skip

    def needed_n(self) -> tuple[float, float]:
        """Return peak and rms of the force that the task takes, without cutting force [N]."""
        assert self.task is not None
        omega = 2.0 * np.pi * self.task.lobes * self.task.spindle_rpm / 60.0
        turn = np.exp(2j * np.pi * np.arange(3600) / 3600)
        position = 0.5e-3 * self.task.travel_mm * turn.imag
        speed, acc = 0.5e-3 * self.task.travel_mm * omega * turn.real, -(omega**2) * position
        force = self.mass_kg * acc + self.drag_n_s_per_m * speed + self.stiffness_n_per_m * position
        force += self.friction_n * np.clip(speed / _STICTION_M_S, -1.0, 1.0)
        return float(np.abs(force).max()), float(np.sqrt(np.mean(force**2)))


def read_tree(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file, or refuse what cannot be read or is no TOML."""
    try:
        data = read_limited(path, _MOST_BYTES)
    except OSError as error:
        problem = f"cannot be read: {error.strerror}"
        raise InputError(str(path), "", None, problem, "give a TOML file") from error
    return read_machine(utf8_text(data, str(path)), str(path))


def drive_of(tree: dict[str, Any], file: str) -> Drive:
    """Return the drive of some keys, or refuse wrong ones, a line each."""
    try:
        return Drive.model_validate(tree)
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error


PREFIX = "servo_"
# The firmware's loop has no lag of a position drive.
_NO_LAG = {"k1_ns": 0, "k2_us2": 0, "u_friction_nm": 0}
_OF_LOOP = ("mass_g", "crossover_hz", "lead_percent", "pole_hz", "integral_mHz")
_OF_NOTCH = ("notch_hz", "notch_zero_permille", "notch_pole_permille")
_NO_NOTCH = {"notch_zero_permille": 1000, "notch_pole_permille": 1000}
_OF_GAIN = ("servo_integral_mHz", "servo_lead_percent")
_MOST_MASS_RATE = 2**16 * 1e9  # [g/s2] of the feed-forward
_MOST_STEPS = 16  # of the delay of the force
_MOST_OVERLOAD = 15


def ranges() -> dict[str, tuple[int, int]]:
    """Return least and most of each parameter of the loop."""
    return {name: (info.low, info.high) for name, info in INFOS.items() if name.startswith(PREFIX)}


def _loop_values(loop: Loop) -> dict[str, float]:
    return {
        "crossover_hz": loop.crossover_hz,
        "lead_percent": loop.lead_ratio * 100.0,
        "pole_hz": math.floor(loop.pole_hz),  # its bound is a fifth of the rate
        "integral_mHz": min(loop.integral_hz, math.floor(loop.crossover_hz)) * 1e3,
        "notch_hz": loop.notch_hz,
        "notch_zero_permille": loop.notch_zero * 1e3,
        "notch_pole_permille": loop.notch_pole * 1e3,
    }


def _drive_values(drive: Drive) -> dict[str, float]:
    lag_us = 1e6 * (0.5 / drive.tick_hz + 0.5 / math.pi / drive.amplifier_hz)
    limits = {
        "force_limit_mn": (drive.force_limit_n, 1e3),
        "force_rate_n_per_ms": (drive.force_rate_n_per_ms, 1.0),
        "continuous_mn": (drive.continuous_n, 1e3),
        "thermal_ms": (drive.thermal_s, 1e3),
    }
    return {
        "mass_g": drive.mass_kg * 1e3,
        "force_delay_ns": (drive.delay_us + lag_us) * 1e3,
        "drag_mn_s_per_m": drive.drag_n_s_per_m * 1e3,
        "friction_mn": drive.friction_n * 1e3,
        "stiffness_n_per_m": drive.stiffness_n_per_m,
    } | {name: value * factor for name, (value, factor) in limits.items() if value is not None}


def parameters_of(loop: Loop, drive: Drive) -> dict[str, int]:
    """Return the parameters of a loop by name, in the firmware's order; limits only if given."""
    found = {PREFIX + k: round(v) for k, v in (_loop_values(loop) | _drive_values(drive)).items()}
    values = {name: found[name] for name in ranges() if name in found}
    check(values, drive, "proposed loop")
    return values


def _bounds(at: Mapping[str, int], tick_hz: float) -> dict[str, tuple[float, float]]:
    """Return bounds of parameters by others, as cam_servo_design.c has them."""
    found: dict[str, tuple[float, float]] = {
        "crossover_hz": (1, at["pole_hz"]),
        "pole_hz": (10, tick_hz / 5),
        "integral_mHz": (0, 1000 * at["crossover_hz"]),
        "force_delay_ns": (0, 1e9 * _MOST_STEPS / tick_hz),
    }
    if at.get("notch_hz"):
        found["notch_hz"] = (tick_hz / 1000, tick_hz / 4)
        found["notch_zero_permille"] = (0, at["notch_pole_permille"])
    if "force_limit_mn" in at:
        limit = at["force_limit_mn"]
        found["continuous_mn"] = (limit / _MOST_OVERLOAD, math.inf)
    return found


def check(values: Mapping[str, int], drive: Drive, file: str) -> None:
    """Refuse parameters out of their ranges, or of bounds by others."""
    by_others = _bounds({name.removeprefix(PREFIX): v for name, v in values.items()}, drive.tick_hz)
    for name, value in values.items():
        low, high = ranges()[name]
        low_2, high_2 = by_others.get(name.removeprefix(PREFIX), (low, high))
        if not max(low, low_2) <= value <= min(high, high_2):
            between = f"{max(low, low_2):.9g} .. {min(high, high_2):.9g}"
            problem = f"out of range {between} at {drive.tick_hz:g} Hz"
            raise InputError(file, name, value, problem, "change it, or what it follows from")
    _check_words(values, drive, file)


def _check_words(values: Mapping[str, int], drive: Drive, file: str) -> None:
    plant, _ = plant_of(values, drive)
    row = np.array(astuple(loop_of(values, drive)))
    shares = dict(zip(_OF_GAIN, word_shares(row, plant), strict=True))
    shares["servo_mass_g"] = values["servo_mass_g"] * drive.tick_hz**2 / _MOST_MASS_RATE
    for name, share in shares.items():
        if share > 1.0:
            problem = f"{share:.3g} times what the firmware holds at this mass and rate"
            raise InputError(file, name, values[name], problem, "lower it, crossover or rate")


def read_loop(path: Path, drive: Drive) -> dict[str, int]:
    """Return the parameters of a file of `text_of` or `camctl params save`, checked."""
    flat: dict[str, Any] = {}
    for key, value in read_tree(path).items():
        flat |= value if isinstance(value, dict) else {key: value}
    values = {name: flat[name] for name in ranges() if name in flat}
    for name, value in values.items():
        if type(value) is not int:
            raise InputError(str(path), name, value, "no whole number", "give a whole number")
    needed = _OF_LOOP + (_OF_NOTCH if values.get("servo_notch_hz") else ())
    for name in (PREFIX + key for key in needed if PREFIX + key not in values):
        raise InputError(str(path), name, None, "is missing", "add it")
    check(values, drive, str(path))
    return values


def loop_of(values: Mapping[str, int], drive: Drive) -> Loop:
    """Return the loop of parameters, for their mass."""
    at = {name.removeprefix(PREFIX): value for name, value in values.items()}
    if not at.get("notch_hz"):
        at |= _NO_NOTCH | {"notch_hz": int(drive.tick_hz / 8)}
    return Loop(
        at["crossover_hz"], at["lead_percent"] / 100, at["pole_hz"], at["integral_mHz"] / 1000,
        at["notch_hz"], at["notch_zero_permille"] / 1000, at["notch_pole_permille"] / 1000,
    )  # fmt: skip


def plant_of(values: Mapping[str, int], drive: Drive) -> tuple[Plant, float]:
    """Return the drive with the mass that parameters are for, and its real mass over that."""
    mass_kg = values["servo_mass_g"] / 1000
    return replace(drive.plant, mass_kg=mass_kg), drive.mass_kg / mass_kg


def settings_of(values: Mapping[str, int], drive: Drive, is_measured: bool) -> dict[str, int]:
    """Return all that is to be set for parameters of the loop: themselves, no lag, the lead.

    `is_measured`: the constants of the drive are not those of data sheets alone.
    """
    settings, own_ns = dict(values), round(_drive_values(drive)["force_delay_ns"])
    lead_ns = round(1e9 / drive.tick_hz) + settings.setdefault("servo_force_delay_ns", own_ns)
    return settings | _NO_LAG | {"lead_ns": lead_ns, "servo_measured": int(is_measured)}


def text_of(settings: Mapping[str, int], origin: str) -> str:
    """Return `settings_of` as a file that `camctl params load` takes."""
    lines = [f"# Position loop of U, {origin}.", "[axis_u]"]
    lines += [f"{name} = {value}" for name, value in settings.items()]
    return "\n".join(lines) + "\n"
