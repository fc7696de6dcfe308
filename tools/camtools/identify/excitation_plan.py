"""Chooses an excitation within the limits of U, or says why there is none, and has it played.

>>> believed = Believed(20_000.0, 742_723, 281_448, 100_000, 0, 10, 1_200_000, 400_000, 250_000)
>>> excitation = plan(believed, Wishes())
>>> excitation.wave.rms_nm, excitation.place_nm
(25000.0, -219736)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.identify.configured_drive import Believed
from camtools.identify.multisine import (
    HIGHEST_HZ,
    N_PERIODS,
    TICKS_PER_HIGHEST,
    Grid,
    Wave,
    multisine,
)
from camtools.identify.recording import SettledRecord, record_of
from camtools.link.excitation import Unit

_RMS_NM, _COARSE_RMS_NM, _COARSE_NM = 25_000.0, 100_000.0, 500
_CARRIER_NM = 300_000.0
_OF_LIMIT = 0.8  # share of the limits that a wave uses
_OF_STROKE = 0.96
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


@dataclass(frozen=True, eq=False)
class Excitation:
    """A wave, and how it is played."""

    wave: Wave
    place_nm: int  # of U about which it is played: as far out of the work as the stroke allows
    n_periods: int  # at full amplitude
    fade_ticks: int  # over which it rises before the periods, and falls after them

    @property
    def play(self) -> Play:
        """How U plays it."""
        return Play(self.wave.u_nm, "nm", self.n_periods, self.fade_ticks, self.place_nm)


def _refused(option: str, value_um: float, what: str, found: str, remedy: str) -> CamtoolsError:
    return CamtoolsError([f"{option} {value_um:g}: {what}: {found}; {remedy}"])


def _check(wave: Wave, believed: Believed) -> None:
    peaks, rms_um = wave.peaks, wave.rms_nm * 1e-3
    of_axis = (
        ("acceleration", peaks.acceleration_mm_s2, believed.u_acceleration_mm_per_s2, "mm/s2"),
        ("speed", peaks.speed_mm_s, believed.u_speed_um_per_s * 1e-3, "mm/s"),
        ("travel", 2 * peaks.travel_mm, believed.u_stroke_nm * 1e-6, "mm"),
    )
    for name, needed, limit, unit in of_axis:
        if needed > limit * (_OF_STROKE if name == "travel" else _OF_LIMIT):
            found = f"{name} of U {needed:.4g} {unit}, {_OF_LIMIT:g} of {limit:.4g} are allowed"
            if name == "travel":
                found = found.replace(f"{_OF_LIMIT:g}", f"{_OF_STROKE:g}")
            share = limit * _OF_LIMIT / needed
            remedy = f"give at most --rms-um {rms_um * share:.3g}, or a smaller --carrier-um"
            raise _refused("--rms-um", rms_um, "too large", found, remedy)


def _fitting(grid: Grid, rms_nm: float, carrier_nm: float, believed: Believed) -> Wave:
    """Return the wave of these amplitudes, reduced to what U can."""
    alone = multisine(grid, rms_nm, 0.0).peaks
    slow = multisine(grid, 1.0, carrier_nm).peaks if carrier_nm else None
    acceleration = believed.u_acceleration_mm_per_s2 * _OF_LIMIT
    speed = believed.u_speed_um_per_s * 1e-3 * _OF_LIMIT
    travel = believed.u_stroke_nm * 1e-6 * _OF_STROKE / 2
    carrier_share = 1.0
    if slow is not None:  # half of everything at most
        carrier_share = min(
            1.0,
            0.5 * acceleration / slow.acceleration_mm_s2,
            0.5 * speed / slow.speed_mm_s,
            0.7 * travel / slow.travel_mm,
        )
        acceleration -= carrier_share * slow.acceleration_mm_s2
        speed -= carrier_share * slow.speed_mm_s
        travel -= carrier_share * slow.travel_mm
    share = min(
        1.0,
        acceleration / alone.acceleration_mm_s2,
        speed / alone.speed_mm_s,
        travel / alone.travel_mm,
    )
    return multisine(grid, rms_nm * share, carrier_nm * carrier_share)


def plan(believed: Believed, wishes: Wishes) -> Excitation:
    """Return an excitation that U can play.

    What was not asked for is chosen: 25 um rms, 100 um for a scale of 1 um, and a carrier of
    0.3 mm, each less where stroke, speed or acceleration of U ask for it.
    Raises `CamtoolsError`: what was asked for, or the least that a fit can use, is beyond a limit
    of U.
    """
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
    room_nm = believed.u_stroke_nm * _OF_STROKE / 2 - wave.peaks.travel_mm * 1e6
    return Excitation(
        wave=wave,
        place_nm=-int(max(0.0, room_nm)),
        n_periods=wishes.n_periods,
        fade_ticks=max(16, min(65535, round(believed.tick_hz * _FADE_S))),
    )


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
    """Let U play an excitation; return set-points and positions.

    Raises `CamtoolsError`: the record is of no use, or the simulated controller refuses; `Refused`,
    `CutShortError`: the controller refuses, or the excitation was cut short.
    """
    tick, u_nm, y_nm = u.played(excitation.play, SIGNALS)
    grid = excitation.wave.grid
    return record_of(grid, np.asarray(tick, np.int64), u_nm, y_nm, believed.u_scale_nm)
