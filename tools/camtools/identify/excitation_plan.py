"""Chooses an excitation within the limits of U, or says why there is none, and has it played.

>>> believed = Believed(20_000.0, 742_723, 281_448, 100_000, 0, 10, 1_200_000, 400_000, 250_000)
>>> excitation = plan(believed, Wishes())
>>> excitation.wave.rms_nm, excitation.play.place_nm
(25000.0, -219736)
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.identify.configured_drive import Believed
from camtools.identify.recording import (
    HIGHEST_HZ,
    N_PERIODS,
    TICKS_PER_HIGHEST,
    Grid,
    SettledRecord,
    Wave,
    multisine,
    record_of,
)
from camtools.link.excitation import Unit

_RMS_NM, _COARSE_RMS_NM, _COARSE_NM = 25_000.0, 100_000.0, 500
_CARRIER_NM = 300_000.0
# Of travel, speed and acceleration: shares of the limits that a wave uses, of these its carrier.
_NAMES, _SIDES = (("travel", "mm"), ("speed", "mm/s"), ("acceleration", "mm/s2")), (2, 1, 1)
_OF_LIMITS, _OF_CARRIER = np.array([0.96, 0.8, 0.8]), np.array([0.7, 0.5, 0.5])
LEAST_RMS_NM = 500.0
_FADE_S = 0.1


class Wishes(NamedTuple):
    """What the user asked for; None: chosen."""

    rms_nm: float | None = None
    carrier_nm: float | None = None
    highest_hz: float = HIGHEST_HZ
    n_periods: int = N_PERIODS
    least_ticks: int = TICKS_PER_HIGHEST  # in a period of the highest line


class Play(NamedTuple):
    """A wave, and how U plays it."""

    samples: Ints  # of a period, one per tick
    unit: Unit
    n_periods: int  # at full amplitude
    fade_ticks: int  # over which it rises before the periods, and falls after them
    place_nm: int  # of U about which it is played


class Excitation(NamedTuple):
    """A wave, and how it is played: as far out of the work as the stroke allows."""

    wave: Wave
    play: Play


def _limits(believed: Believed) -> Floats:
    """Return limits of travel to either side, speed and acceleration, as of `WavePeaks`."""
    stroke_mm, speed_mm_s = believed.u_stroke_nm * 1e-6, believed.u_speed_um_per_s * 1e-3
    return np.array([stroke_mm / 2, speed_mm_s, believed.u_acceleration_mm_per_s2])


def _check(wave: Wave, believed: Believed) -> None:
    """Raise when a wave of the user asks for more than U can."""
    rms_um = wave.rms_nm * 1e-3
    rows = [*zip(_NAMES, wave.peaks, _limits(believed), _OF_LIMITS, _SIDES, strict=True)]
    for (name, unit), peak, limit, allowed, sides in rows[::-1]:
        if peak > limit * allowed:
            needed = f"{name} of U {sides * peak:.4g} {unit}"
            found = f"{needed}, {allowed:g} of {sides * limit:.4g} are allowed"
            most = f"{rms_um * limit * _OF_LIMITS[-1] / peak:.3g}"
            remedy = f"give at most --rms-um {most}, or a smaller --carrier-um"
            raise CamtoolsError([f"--rms-um {rms_um:g}: too large: {found}; {remedy}"])


def _fitting(grid: Grid, rms_nm: float, carrier_nm: float, believed: Believed) -> Wave:
    """Return the wave of these amplitudes, reduced to what U can."""
    room, carrier_share = _limits(believed) * _OF_LIMITS, 1.0
    if carrier_nm:
        slow = np.array(multisine(grid, 1.0, carrier_nm).peaks)
        carrier_share = min(1.0, *(_OF_CARRIER * room / slow))
        room = room - carrier_share * slow
    share = min(1.0, *(room / np.array(multisine(grid, rms_nm, 0.0).peaks)))
    return multisine(grid, rms_nm * share, carrier_nm * carrier_share)


def plan(believed: Believed, wishes: Wishes) -> Excitation:
    """Return an excitation that U can play; what is not asked for is chosen within its limits."""
    grid = Grid.of(believed.tick_hz, wishes.highest_hz, wishes.least_ticks)
    coarse = believed.u_scale_nm >= _COARSE_NM
    rms_nm = wishes.rms_nm or (_COARSE_RMS_NM if coarse else _RMS_NM)
    carrier_nm = _CARRIER_NM if wishes.carrier_nm is None else wishes.carrier_nm
    if wishes.rms_nm is None:
        wave = _fitting(grid, rms_nm, carrier_nm, believed)
        least_nm = max(LEAST_RMS_NM, 2.0 * believed.u_scale_nm)
        if wave.rms_nm < least_nm:
            problem = f"its limits leave {wave.rms_nm * 1e-3:.3g} um rms of excitation"
            need = f"a fit needs {least_nm * 1e-3:.3g}"
            remedy = "raise u_acceleration_mm_per_s2 or u_stroke_nm if the drive can, or give a "
            raise CamtoolsError([f"U: {problem}, {need}; {remedy}lower --highest-hz"])
    else:
        wave = multisine(grid, rms_nm, carrier_nm)
        _check(wave, believed)
    room_nm = believed.u_stroke_nm * _OF_LIMITS[0] / 2 - wave.peaks.travel_mm * 1e6
    fade_ticks, place_nm = round(believed.tick_hz * _FADE_S), -int(max(0.0, room_nm))
    fade_ticks = max(16, min(65535, fade_ticks))
    return Excitation(wave, Play(wave.u_nm, "nm", wishes.n_periods, fade_ticks, place_nm))


SIGNALS = ("u_command_nm", "u_actual_nm")


class U(Protocol):
    """U of a simulator or of a machine."""

    def believed(self) -> Believed:
        """Return what matters of the parameters of its controller."""

    def values(self, names: Iterable[str]) -> dict[str, int]:
        """Return parameters of its controller by their names."""

    def played(self, play: Play, signals: Sequence[str]) -> Floats:
        """Let it play a wave; return tick and signals of its periods, a row each."""


def excited(u: U, excitation: Excitation, believed: Believed) -> SettledRecord:
    """Let U play an excitation; return set-points and positions, or refuse a useless record."""
    tick, u_nm, y_nm = u.played(excitation.play, SIGNALS)
    grid = excitation.wave.grid
    return record_of(grid, np.asarray(tick, np.int64), u_nm, y_nm, believed.u_scale_nm)
