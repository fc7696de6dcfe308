r"""A drive file: what is known about a force drive, and the task that it must do.

>>> keys = {"mass_kg": 1.5, "amplifier_hz": 1500.0, "delay_us": 75.0, "tick_hz": 20000.0}
>>> task = {"travel_mm": 1.0, "spindle_rpm": 3000.0, "lobes": 2}
>>> drive = drive_of(keys | {"task": task}, "a.toml")
>>> [f"{newton:.0f}" for newton in drive.needed()]
['296', '209']
"""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, ValidationError

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import read_limited
from camtools.base.text import toml_tree
from camtools.part.model import TomlTable, describe_all
from camtools.tune.loop_design import Plant

_MOST_BYTES = 100_000
_STICTION_M_S = 1e-4  # friction counts in full from this speed on


def _between(least: float, most: float) -> Any:  # noqa: ANN401 - pydantic's FieldInfo is untyped
    return Field(ge=least, le=most)


class Task(TomlTable):
    """A sinusoidal motion of U."""

    travel_mm: Annotated[float, _between(0.001, 100.0)]  # peak to peak
    spindle_rpm: Annotated[float, _between(1.0, 60_000.0)]
    lobes: Annotated[int, _between(1, 100)]  # periods per turn


class Needed(NamedTuple):
    """Force of a task."""

    peak_n: float
    rms_n: float


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
    mode_hz: Annotated[float, _between(0.0, 50_000.0)] = 0.0  # 0: none
    mode_damping: Annotated[float, _between(0.0001, 1.0)] = 0.03
    mode_share: Annotated[float, _between(-10.0, 10.0)] = 0.0
    scale_quantum_nm: Annotated[float, _between(0.0, 10_000.0)] = 0.0  # 0: not known
    force_limit_n: Annotated[float, _between(0.2, 4000.0)] | None = None
    continuous_n: Annotated[float, _between(0.2, 4000.0)] | None = None
    thermal_s: Annotated[float, _between(0.1, 200.0)] | None = None
    force_rate_n_per_ms: Annotated[float, _between(1.0, 1e6)] | None = None
    task: Task | None = None

    @property
    def plant(self) -> Plant:
        """The drive as the design of loops takes it."""
        return Plant(
            self.mass_kg, self.amplifier_hz, self.delay_us * 1e-6, self.tick_hz, self.mode_hz,
            self.mode_damping, self.mode_share, self.drag_n_s_per_m, self.stiffness_n_per_m,
        )  # fmt: skip

    def needed(self) -> Needed:
        """Return the force that the task takes, without cutting force; ValueError without one."""
        if self.task is None:
            raise ValueError("the drive has no task")
        omega = 2.0 * np.pi * self.task.lobes * self.task.spindle_rpm / 60.0
        turn = np.exp(2j * np.pi * np.arange(3600) / 3600)
        position = 0.5e-3 * self.task.travel_mm * turn.imag
        speed, acc = 0.5e-3 * self.task.travel_mm * omega * turn.real, -(omega**2) * position
        force = self.mass_kg * acc + self.drag_n_s_per_m * speed + self.stiffness_n_per_m * position
        force += self.friction_n * np.clip(speed / _STICTION_M_S, -1.0, 1.0)
        return Needed(float(np.abs(force).max()), float(np.sqrt(np.mean(force**2))))


def read_tree(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file, or refuse what cannot be read or is no TOML."""
    try:
        return toml_tree(read_limited(path, _MOST_BYTES).decode("utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        problem = f"cannot be read: {getattr(error, 'strerror', None) or 'not UTF-8 text'}"
        raise InputError(str(path), "", None, problem, "give a TOML file") from error
    except ValueError as error:
        raise InputError(str(path), "", None, f"not TOML: {error}", "correct it") from error


def drive_of(tree: dict[str, Any], file: str) -> Drive:
    """Return the drive of some keys, or refuse wrong ones, a line each."""
    try:
        return Drive.model_validate(tree)
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error
