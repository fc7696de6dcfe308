# SPDX-License-Identifier: Apache-2.0
"""U excited by its set-point while the controller closes its loop, simulated or over CAN.

Modes up to this frequency are found:

>>> HIGHEST_HZ
2500.0
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT
from camtools.base.quantities import Floats
from camtools.identify.excitation_plan import Wishes, plan
from camtools.identify.excited import U
from camtools.identify.simulated_drive import SimulatedU
from camtools.identify.spectra import Spectra
from camtools.pipeline.load import load
from camtools.pipeline.make_table import make
from camtools.table.image import pack
from camtools.tune.parameters import ranges
from camtools.tune.plant_fit import PlantFit, fit_lines, record_lines

_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_SIGNALS = ("u_set_q6", "u_actual_nm", "u_force_q6")
_LEAST_TICKS = 8  # in a period of the highest line: images of the hold hardly move a mass
_SLOW_MRPM = 100_000  # the limits of a first power-up suffice for this cut
HIGHEST_HZ = 2500.0


class Recorded(NamedTuple):
    """What was recorded while U was excited; one value for each tick."""

    tick_hz: float
    scale_nm: int  # [nm] of a count
    values: dict[str, int]  # parameters of the loop in force
    set_m: Floats  # [m] set-point
    force_n: Floats  # [N]
    actual_m: Floats  # [m] position


class Measured(NamedTuple):
    """What an excitation shows."""

    tick_hz: float
    values: dict[str, int]  # parameters of the loop in force
    lines: Spectra  # of force [N] and position [nm]
    fit: PlantFit


@contextmanager
def simulated_u(machine: bytes, name: str) -> Iterator[SimulatedU]:
    """Give U of a machine file, known to the user by a name."""
    image = pack(replace(make(load(_PART), _PART).table.table, spindle_mrpm=_SLOW_MRPM))
    with tempfile.TemporaryDirectory(prefix="tune.") as folder:
        yield SimulatedU(Path(folder), machine, name, image)


def recorded(u: U, name: str, highest_hz: float = HIGHEST_HZ) -> Recorded:
    """Excite U and record it.

    Parameters
    ----------
    u : U
        takes forces; its loop may be weak
    name : str
        of the machine, for errors
    highest_hz : float
        [Hz] highest line, at least 50

    Raises
    ------
    CamtoolsError
        The machine is wrong, or U takes positions.
    Refused, CutShortError
        The controller refuses, or the excitation was cut short.
    """
    believed, values = u.believed(), u.values(ranges())
    if values["servo_crossover_hz"] == 0:
        problem = "servo_crossover_hz = 0: U takes positions, or its loop is not set"
        remedy = "use tools/identify, or set a weak loop first (hal/RETROFIT.md)"
        raise CamtoolsError([f"{name}: {problem}; {remedy}"])
    outside = plan(believed, Wishes(highest_hz=highest_hz, least_ticks=_LEAST_TICKS))
    excitation = replace(outside, place_nm=outside.place_nm // 2)  # a weak loop overshoots
    _, set_q6, actual_nm, force_q6 = u.played(excitation.play, _SIGNALS)
    if not force_q6.any():
        problem = "no force was recorded, so its U takes positions"
        raise CamtoolsError([f"{name}: {problem}; use tools/identify"])
    signals = (set_q6 / 64e9, force_q6 / 64e3, actual_nm / 1e9)
    return Recorded(believed.tick_hz, believed.u_scale_nm, values, *signals)


def fitted(one: Recorded) -> Measured:
    """Fit the drive to a record; raise CamtoolsError where that is of no use."""
    signals = (one.set_m, one.force_n, one.actual_m)
    lines = record_lines(one.tick_hz, *signals, one.scale_nm)
    return Measured(one.tick_hz, one.values, lines, fit_lines(lines))


def measure(u: U, name: str, highest_hz: float = HIGHEST_HZ) -> Measured:
    """Excite U and fit its drive; arguments and errors of `recorded` and `fitted`."""
    return fitted(recorded(u, name, highest_hz))
