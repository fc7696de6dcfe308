"""Plants that judge loops and fits: not the simulator's, not the fit's; plants.c moves them.

A position drive: exact flow of the linear part over short steps, Coulomb friction as a set-valued
force between them (Strang's splitting, so sticking is exact), dead time in steps, a mode between
scale and slide, a scale that rounds. A force drive: mass, dry friction with rest, amplifier, delay
and hold, a mode that moves the scale, in steps of 2.5 us. An oscillator, by Runge and Kutta.
"""

import ctypes
import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from camtools.base.quantities import Floats
from camtools.identify.recording import Wave
from camtools.tune.loop_design import Plant as ForcePlant
from camtools.tune.loop_design import best
from tests.tools.cases.camsim_cases import BUILD

STEP_S = 12.5e-6  # at most; dead times are whole multiples
FADE_PERIODS = 0.25
SUB_S = 2.5e-6  # of a force drive
_MOST_DELAY = 256
designed = cache(best)  # the search gives the same each time
_DOUBLE, _INT = ctypes.c_double, ctypes.c_int32
_ARRAY = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")


@cache
def library() -> ctypes.CDLL:
    """Load the plants and the position loop of the firmware."""
    loaded = ctypes.CDLL(str(BUILD / "tests" / "libplants.so"))
    loaded.servo_open.restype = ctypes.c_bool
    loaded.force_drive_move.argtypes = [ctypes.c_void_p, _DOUBLE, _DOUBLE, _INT]
    loaded.position_drive_play.argtypes = [ctypes.c_void_p, _ARRAY, _INT, _ARRAY]
    loaded.oscillator_play.argtypes = [ctypes.c_void_p, _ARRAY, _INT, _DOUBLE, _ARRAY]
    loaded.limited_drive_play.argtypes = [_DOUBLE, _DOUBLE, _ARRAY, _INT, _DOUBLE, _ARRAY]
    return loaded


class Drive(ctypes.Structure):
    """A force drive, at rest at 0."""

    _fields_ = [
        *((name, _DOUBLE) for name in ("mass_kg", "friction_n", "lag")),
        *((name, _DOUBLE) for name in ("mode_rad_per_s", "mode_damping", "mode_share")),
        *((name, _DOUBLE) for name in ("pos_m", "vel_m_per_s", "force_n")),
        *((name, _DOUBLE) for name in ("mode_m", "mode_m_per_s")),
        ("delay", _INT),
        ("i", _INT),
        ("commands_n", _DOUBLE * _MOST_DELAY),
    ]
    pos_m: float
    mode_m: float

    def __init__(self, plant: ForcePlant, friction_n: float = 5.0) -> None:
        lag = 1.0 - math.exp(-2.0 * math.pi * plant.amplifier_hz * SUB_S)
        mode = (2.0 * math.pi * plant.mode_hz, plant.mode_damping, plant.mode_share)
        delay = round(plant.delay_s / SUB_S) + 1
        assert delay < _MOST_DELAY
        super().__init__(plant.mass_kg, friction_n, lag, *mode, delay=delay)
        self._subs = round(1.0 / plant.step_hz / SUB_S)

    def move(self, command_n: float, outer_n: float) -> None:
        """Move over one step of the loop."""
        library().force_drive_move(ctypes.byref(self), command_n, outer_n, self._subs)

    def scale_m(self) -> float:
        """Return the reading of the scale."""
        return self.pos_m + self.mode_m


class _Oscillator(ctypes.Structure):
    _fields_ = [(name, _DOUBLE) for name in ("mass_kg", "viscous", "stiffness", "cubic")]


def oscillator_m(force_n: Floats, h_s: float, *constants: float) -> Floats:
    """Return positions: mass [kg], damping [N s/m], stiffness [N/m], cubic stiffness [N/m3]."""
    found = np.empty(force_n.size)
    one = _Oscillator(*constants)
    force_n = np.ascontiguousarray(force_n)
    library().oscillator_play(ctypes.byref(one), force_n, force_n.size, h_s, found)
    return found


def limited_m(u_m: Floats, rate_hz: float, most_m_s2: float) -> Floats:
    """Return positions of a drive of 300 Hz and 0.7 that accelerates at most so much."""
    found, w = np.empty(u_m.size), 2 * np.pi * 300.0
    library().limited_drive_play(w, most_m_s2, u_m, u_m.size, 1 / rate_hz / 20, found)
    return found


@dataclass(frozen=True)
class Plant:
    """One drive: natural frequency, damping, dead time, friction, quantum, mode."""

    hz: float = 300.0
    damping: float = 0.7
    delay_us: float = 75.0
    friction_m_s2: float = 0.0
    quantum_nm: float = 10.0
    mode_hz: float = 0.0
    mode_damping: float = 0.03
    mode_share: float = 0.0
    gain: float = 1.0

    @property
    def k1_s(self) -> float:
        """Return the velocity term of its inverse."""
        return 2 * self.damping / (2 * np.pi * self.hz)

    @property
    def k2_s2(self) -> float:
        """Return the acceleration term of its inverse."""
        return 1 / (2 * np.pi * self.hz) ** 2

    def lead_s(self, tick_hz: float) -> float:
        """Return its dead time with half a tick of hold."""
        return self.delay_us * 1e-6 + 0.5 / tick_hz


class _PositionDrive(ctypes.Structure):
    _fields_ = [
        ("flow", _DOUBLE * 16),
        ("given", _DOUBLE * 4),
        *((name, _DOUBLE) for name in ("kick", "friction", "stiffness", "gain")),
        *((name, _DOUBLE) for name in ("mode_share", "quantum_nm")),
        ("delay", _INT),
        ("n_steps", _INT),
    ]


def _flow(plant: Plant, dt_s: float) -> NDArray[np.float64]:
    """Return state and input matrices of a step; states y, v of slide and of the mode."""
    w, d = 2 * np.pi * plant.hz, plant.damping
    a = np.zeros((5, 5))
    a[0, 1] = 1
    a[1] = [-w * w, -2 * d * w, 0, 0, w * w * plant.gain]
    if plant.mode_hz > 0:
        wm = 2 * np.pi * plant.mode_hz
        a[2, 3] = 1
        a[3] = -plant.mode_share * a[1]
        a[3, 2] -= wm * wm
        a[3, 3] -= 2 * plant.mode_damping * wm
    return np.asarray(expm(a * dt_s))


def faded(wave: Wave, n_periods: int) -> Floats:
    """Return set-points: the wave again and again, faded in."""
    u = np.tile(wave.u_nm, n_periods).astype(np.float64)
    n = int(FADE_PERIODS * wave.grid.n_ticks)
    x = np.arange(n) / n
    u[:n] *= x**3 * (10 - 15 * x + 6 * x * x)
    return u


def played(plants: list[Plant], u_nm: Floats, tick_hz: float) -> Floats:
    """Return the measured positions at the ticks, shape (plants, ticks)."""
    n_steps = int(np.ceil(1 / tick_hz / STEP_S - 1e-9))
    dt_s = 1 / tick_hz / n_steps
    u_nm = np.ascontiguousarray(u_nm, dtype=np.float64)
    measured = np.empty((len(plants), u_nm.size))
    for plant, row in zip(plants, measured, strict=True):
        flow, friction = _flow(plant, dt_s), plant.friction_m_s2 * 1e9
        drive = _PositionDrive(
            (_DOUBLE * 16)(*flow[:4, :4].ravel()), (_DOUBLE * 4)(*flow[:4, 4]),
            friction * dt_s / 2, friction, (2 * np.pi * plant.hz) ** 2, plant.gain,
            plant.mode_share, max(plant.quantum_nm, 1e-9),
            round(plant.delay_us * 1e-6 / dt_s), n_steps,
        )  # fmt: skip
        library().position_drive_play(ctypes.byref(drive), u_nm, u_nm.size, row)
    return measured
