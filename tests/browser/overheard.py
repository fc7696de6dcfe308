# SPDX-License-Identifier: Apache-2.0
"""What the controller itself says on its bus, heard by a thread of the test.

A page is compared with it: what stands here has not passed the panel. The samples of single ticks
are decoded by the DBC alone, not by the code that the panel uses.
"""

import threading
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import can

from camtools.link.controller import Link, Status
from camtools.link.messages import COMMAND, DATABASE, NUMBERS
from tests.tools.cases.background import PATIENCE_S

Point = tuple[float, float]
_JOG = NUMBERS["command"]["jog"]
_STROBE = DATABASE.get_message_by_name("Strobe")
_LOOK_S = 0.1


@dataclass
class _Heard:
    status: Status = field(default_factory=Status)
    points: set[Point] = field(default_factory=set)
    n_lost: int = 0
    number: int | None = None
    jog_row: int = 0
    rest_row: int = 0


class _Ear(Link):
    """A link that hears the commands of others, too."""

    on_jog: Callable[[], None]

    def _take(self, frame: can.Message) -> None:
        if frame.arbitration_id == COMMAND.frame_id and frame.data[0] == _JOG:
            self.on_jog()
        super()._take(frame)


class Overheard:
    """A listener on the bus that sends nothing.

    Parameters
    ----------
    bus : can.BusABC
        open; it is shut down by close()
    """

    def __init__(self, bus: can.BusABC, where: str, node: int) -> None:
        self._bus = bus
        self._link = _Ear(bus, where, node)
        self._link.on_jog = self._take_jog
        self._link.on_row = self._take_row
        self._link.on_strobe = self._take_strobe
        self._heard = _Heard()
        self._news = threading.Condition()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while not self._is_over.is_set():
            self._link.pump(_LOOK_S)

    def _take_row(self, status: Status) -> None:
        with self._news:
            if self._moves(self._heard.status) and not self._moves(status):
                self._heard.rest_row = status.n_rows
            self._heard.status = deepcopy(status)
            self._news.notify_all()

    @staticmethod
    def _moves(status: Status) -> bool:
        return bool(status.signals.get("hand_phase"))

    def _take_strobe(self, data: bytes) -> None:
        said: Any = _STROBE.decode(data, decode_choices=False)
        with self._news:
            heard = self._heard
            if heard.number is not None:
                heard.n_lost += (said["number"] - heard.number - 1) % 256
            heard.number = said["number"]
            heard.points.add((round(said["angle"] * 360.0, 1), round(said["error"] * 1e3, 3)))

    def _take_jog(self) -> None:
        self._heard.jog_row = self._link.status.n_rows

    @property
    def jog_row(self) -> int:
        """The number of the status (n_rows) behind which the newest order to jog came."""
        return self._heard.jog_row

    @property
    def rest_row(self) -> int:
        """The number of the first status in which an axis that was moved by hand stood."""
        return self._heard.rest_row

    def status(self) -> Status:
        """Return the controller's status, not older than this call."""
        return self.wait_for(lambda status: True)

    def wait_for_state(self, *states: str) -> Status:
        """Return the first status from now on in one of some states."""
        return self.wait_for(lambda status: status.state in states)

    def comes(self, is_so: Callable[[Status], bool], patience_s: float = PATIENCE_S) -> bool:
        """Return whether something is so of a status from now on, within some seconds."""
        with self._news:
            n_rows = self._heard.status.n_rows
            return self._news.wait_for(
                lambda: self._heard.status.n_rows > n_rows and is_so(self._heard.status), patience_s
            )

    def wait_for(self, is_so: Callable[[Status], bool]) -> Status:
        """Return the first status from now on of which something is so."""
        with self._news:
            assert self.comes(is_so), f"{self._heard.status.state} {self._heard.status.faults}"
            return self._heard.status

    def points(self) -> tuple[set[Point], int]:
        """Return angle [degrees] and error [um] of all samples, and how many were lost."""
        with self._news:
            return set(self._heard.points), self._heard.n_lost

    def close(self) -> None:
        """Stop listening."""
        self._is_over.set()
        self._thread.join()
        self._bus.shutdown()
