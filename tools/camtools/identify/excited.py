# SPDX-License-Identifier: Apache-2.0
"""What the simulator and a controller over CAN have in common: a U that plays excitations.

>>> SIGNALS
('u_command_nm', 'u_actual_nm')
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np

from camtools.base.quantities import Floats
from camtools.identify.configured_drive import Believed
from camtools.identify.excitation_plan import Excitation, Play
from camtools.identify.recording import SettledRecord, record_of

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

    Raises
    ------
    CamtoolsError
        The record is of no use, or the simulated controller refuses.
    Refused, CutShortError
        The controller refuses, or the excitation was cut short.
    """
    tick, u_nm, y_nm = u.played(excitation.play, SIGNALS)
    grid = excitation.wave.grid
    return record_of(grid, np.asarray(tick, np.int64), u_nm, y_nm, believed.u_scale_nm)
