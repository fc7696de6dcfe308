"""The open loop at the lines of a record in which it was closed, without a model of the drive.

It is the reading over the whole force, times the response of the controller's parameters.

>>> hz = np.linspace(10.0, 990.0, 99)
>>> response = 100.0 / (1j * hz) * np.exp(-2j * np.pi * hz * 0.5e-3)
>>> print(text_of(OpenLoop(hz, response)))
crossover 100 Hz, phase margin 72.0 degrees, gain margin 14.0 dB at 500 Hz
"""

from collections.abc import Mapping
from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from camtools.identify.recording import Spectra
from camtools.tune.drive import Drive
from camtools.tune.loop_design import (
    Complexes,
    Reals,
    controller_response,
    open_loop,
    response_grid,
)
from camtools.tune.parameters import loop_of, plant_of


class OpenLoop(NamedTuple):
    """An open loop at some frequencies, which rise."""

    hz: Reals
    response: Complexes


class Figures(NamedTuple):
    """Crossover and margins; None: not within the lines."""

    crossover_hz: float | None = None  # the last crossing of 0 dB
    phase_deg: float | None = None
    gain_db: float | None = None  # above the crossover
    gain_hz: float | None = None


def measured_loop(lines: Spectra, values: Mapping[str, int], drive: Drive) -> OpenLoop:
    """Return what lines of force [N] and position [nm] show of the loop in force."""
    hz = lines.frequency_hz
    row = np.array(astuple(loop_of(values, drive)))
    control = controller_response(row, plant_of(values, drive)[0], hz)
    force = lines.u / np.sinc(hz / drive.tick_hz)  # as it was commanded, without its hold
    return OpenLoop(hz, np.asarray(control * 1e-9 * lines.y / force))


def model_loop(values: Mapping[str, int], drive: Drive) -> OpenLoop:
    """Return what a model of the drive shows; arguments of `measured_loop`."""
    plant, mass = plant_of(values, drive)
    hz = response_grid(plant)
    return OpenLoop(hz, open_loop(np.array(astuple(loop_of(values, drive))), plant, hz, mass))


def _at_zeros(values: Reals, *others: Reals) -> list[Reals]:
    """Return others where values cross 0, linear between the lines."""
    i = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    part = values[i] / (values[i] - values[i + 1])
    return [other[i] + part * (other[i + 1] - other[i]) for other in others]


def figures(one: OpenLoop) -> Figures:
    """Return crossover and margins."""
    log_hz, level_db = np.log(one.hz), 20.0 * np.log10(np.abs(one.response))
    angle_deg = np.degrees(np.unwrap(np.angle(-one.response)))
    crossing, angle = _at_zeros(level_db, log_hz, angle_deg)
    if crossing.size == 0:
        return Figures()
    phase_deg = float(np.abs((angle + 180.0) % 360.0 - 180.0).min())
    found = Figures(float(np.exp(crossing[-1])), phase_deg)
    imag, real = one.response.imag, one.response.real
    turned, level, real = _at_zeros(imag, log_hz, level_db, real)
    is_one = (real < 0.0) & (turned > crossing[-1])
    if not is_one.any():
        return found
    least = int(np.argmax(np.where(is_one, level, -np.inf)))
    return found._replace(gain_db=-float(level[least]), gain_hz=float(np.exp(turned[least])))


def text_of(one: OpenLoop) -> str:
    """Return crossover and margins in a line."""
    found = figures(one)
    missing = f"not within the lines of {one.hz[0]:.0f} .. {one.hz[-1]:.0f} Hz"
    if found.crossover_hz is None:
        return f"crossover {missing}"
    text = f"crossover {found.crossover_hz:.0f} Hz, phase margin {found.phase_deg:.1f} degrees"
    if found.gain_db is None:
        return f"{text}, gain margin {missing}"
    return f"{text}, gain margin {found.gain_db:.1f} dB at {found.gain_hz:.0f} Hz"
