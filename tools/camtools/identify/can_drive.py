# SPDX-License-Identifier: Apache-2.0
"""U of a controller at the other end of a CAN bus: its parameters, excitation, settings.

>>> not_ready("cutting")
'the state is cutting, U is excited in ready only; stop and wait for ready'
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from camtools.base.output import signals_held
from camtools.identify.configured_drive import PARAMETERS, Believed
from camtools.identify.excitation_plan import Excitation
from camtools.identify.recording import SettledRecord, record_of
from camtools.link.controller import Link
from camtools.link.excitation import excite
from camtools.link.messages import NUMBERS, Refused

_OFF_S = 10.0
_ORDERS = {
    "off": "enable and home",
    "homing": "wait for ready",
    "fault": "see status, then reset, enable and home",
}


def not_ready(state: str) -> str:
    """Return why U cannot be excited in a state, and what to do."""
    remedy = _ORDERS.get(state, "stop and wait for ready")
    return f"the state is {state}, U is excited in ready only; {remedy}"


class ConnectedU:
    """U of a controller."""

    def __init__(self, link: Link) -> None:
        self.link = link

    def _get(self, name: str) -> int:
        answer = self.link.ask("get_parameter", parameter=NUMBERS["parameter"][name])
        if answer.result != "done":
            raise Refused(f"{self.link.where}: {name}: {answer.result.replace('_', ' ')}")
        return int(answer.value)

    def believed(self) -> Believed:
        """Return what the controller is configured with.

        Raises
        ------
        Refused
            There is none, or its state is not ready.
        """
        status = self.link.listen()
        if status.state != "ready":
            raise Refused(f"{self.link.where}: {not_ready(status.state)}")
        values = {name: self._get(name) for name in PARAMETERS}
        return Believed.of(status.signals["tick_rate"], values)

    def excited(self, excitation: Excitation, believed: Believed) -> SettledRecord:
        """Let U play an excitation; return what was recorded.

        The controller itself sees to the state, to the clearance of the tool and to the limits of
        U. However this ends, U comes to rest.

        Raises
        ------
        Refused
            It refuses, or the excitation was cut short.
        CamtoolsError
            The record is of no use.
        """
        wave = excitation.wave
        recording = excite(
            self.link,
            wave.u_nm,
            excitation.n_periods,
            fade_ticks=excitation.fade_ticks,
            place_nm=excitation.place_nm,
            signals=("u_command_nm", "u_actual_nm"),
        )
        self.link.rights.release()  # what follows takes longer than command lasts without a word
        if not recording.is_whole:
            raise Refused(f"{self.link.where}: the record has a gap; excite again")
        played = recording.played()
        rows = slice(-excitation.n_periods * wave.grid.n_ticks, None)
        u_nm, y_nm = (
            played[name][rows].astype(np.float64) for name in ("u_command_nm", "u_actual_nm")
        )
        quantum_nm = believed.u_scale_nm
        return record_of(wave.grid, played.tick[rows], u_nm, y_nm, quantum_nm)

    def _set(self, settings: Mapping[str, int]) -> str | None:
        """Set parameters and read them back; return what went wrong."""
        for name, value in settings.items():
            number = NUMBERS["parameter"][name]
            answer = self.link.ask("set_parameter", parameter=number, value=value)
            if answer.result != "done":
                limits = answer.limits
                within = f", {limits[0]:.0f} .. {limits[1]:.0f}" if limits else ""
                return f"{name} = {value}: {answer.result.replace('_', ' ')}{within}"
            if (found := self._get(name)) != value:
                return f"{name} = {value}: reads {found}"
        return None

    def apply(self, settings: Mapping[str, int]) -> None:
        """Disable the drives, set parameters, read them back: all of them or none.

        Raises
        ------
        Refused
            The controller does not go off, or refuses one; those before have their old values.
        """
        before = {name: self._get(name) for name in settings}
        answer = self.link.ask("disable")
        if answer.result != "done":
            raise Refused(f"{self.link.where}: disable: {answer.result.replace('_', ' ')}")
        self.link.wait(lambda: False, 0.05)  # the state of before is in the status until then
        if not self.link.wait(lambda: self.link.status.state == "off", _OFF_S):
            state = self.link.status.state
            raise Refused(f"{self.link.where}: still {state}, nothing is set; try again")
        with signals_held():
            problem = self._set(settings)
            again = self._set(before) if problem else None
        if problem:
            end = f"; and then {again}" if again else "; nothing is set"
            raise Refused(f"{self.link.where}: {problem}{end}")
