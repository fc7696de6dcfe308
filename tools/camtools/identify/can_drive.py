# SPDX-License-Identifier: Apache-2.0
"""U of a controller at the other end of a CAN bus: its parameters, excitation, settings.

>>> not_ready("cutting")
'the state is cutting, U is excited in ready only; stop and wait for ready'
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from camtools.base.output import signals_held
from camtools.base.quantities import Floats
from camtools.identify.configured_drive import PARAMETERS, Believed
from camtools.identify.excitation_plan import Play
from camtools.link.controller import Link
from camtools.link.excitation import excite
from camtools.link.messages import NUMBERS, Refused
from camtools.link.parameters import set_all

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
    """U of a controller.

    Parameters
    ----------
    keeps_command : bool
        whether the link's owner sends heartbeats on, so that command is not given back
    progress : callable, optional
        that of `excite`
    """

    def __init__(
        self,
        link: Link,
        *,
        keeps_command: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        self.link, self._keeps_command, self._progress = link, keeps_command, progress

    def _give_back(self) -> None:
        """Give command back: what follows takes longer than command lasts unheard."""
        if not self._keeps_command:
            self.link.rights.release()

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
        return Believed.of(status.signals["tick_rate"], self.values(PARAMETERS))

    def values(self, names: Iterable[str]) -> dict[str, int]:
        """Return parameters in force.

        Raises
        ------
        Refused
            The controller does not know one.
        """
        return {name: self._get(name) for name in names}

    def played(self, play: Play, signals: Sequence[str]) -> Floats:
        """Let U play a wave; return tick and signals of its periods, a row each.

        The controller itself sees to the state, to the clearance of the tool and to the limits of
        U. However this ends, U comes to rest.

        Parameters
        ----------
        play : Play
        signals : sequence of str
            of the recorder, in the order of firmware/recorder/cam_recorder.h

        Raises
        ------
        Refused
            It refuses, the excitation was cut short, or the record has a gap.
        """
        try:
            recording = excite(
                self.link,
                play.samples,
                play.n_periods,
                unit=play.unit,
                fade_ticks=play.fade_ticks,
                place_nm=play.place_nm,
                signals=signals,
                progress=self._progress,
            )
        except Refused as refused:
            faults = ", ".join(self.link.listen().faults)
            raise Refused(
                f"{refused}: {faults}; {_ORDERS['fault']}" if faults else str(refused)
            ) from refused
        finally:
            self._give_back()
        if not recording.is_whole:
            raise Refused(f"{self.link.where}: the record has a gap; excite again")
        played = recording.played()
        rows = slice(-play.n_periods * play.samples.size, None)
        columns = [played.tick, *(played[name] for name in signals)]
        return np.array([column[rows] for column in columns], np.float64)

    def apply(self, settings: Mapping[str, int]) -> None:
        """Disable the drives, set parameters, all of them or none, and read them back.

        Raises
        ------
        Refused
            The controller does not go off, refuses one, or reads another value.
        """
        answer = self.link.ask("disable")
        if answer.result != "done":
            raise Refused(f"{self.link.where}: disable: {answer.result.replace('_', ' ')}")
        self.link.wait(lambda: False, 0.05)  # the state of before is in the status until then
        if not self.link.wait(lambda: self.link.status.state == "off", _OFF_S):
            state = self.link.status.state
            raise Refused(f"{self.link.where}: still {state}, nothing is set; try again")
        with signals_held():
            try:
                set_all(self.link, settings)
            except Refused as refused:
                raise Refused(f"{self.link.where}: nothing is set: {refused}") from refused
            finally:
                self._give_back()
            found = self.values(settings)
        for name in (name for name, value in settings.items() if found[name] != value):
            problem = f"{name} = {settings[name]}: reads {found[name]}"
            raise Refused(f"{self.link.where}: {problem}; somebody else sets it; apply again")
