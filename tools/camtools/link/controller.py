"""A controller at the other end of a CAN bus: commands and their answers, the newest status.

The messages are those of firmware/remote/can/camturn.dbc, whose identifiers are those of node 64.

>>> Status({"state": 4}).state
'cutting'
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import can
from cantools.database import DecodeError
from cantools.database.can import Message

from camtools.base.signals import signals_held
from camtools.link import messages
from camtools.link.bus import remedy_for
from camtools.link.messages import Answer, Refused
from camtools.link.rights import Rights, sender_of

_MESSAGES = {message.name: message for message in messages.DATABASE.messages}
_STATUS = {
    _MESSAGES[name].frame_id: _MESSAGES[name] for name in ("State", "Spindle", "AxisU", "Detail")
}
WANTED = {signal.name for message in _STATUS.values() for signal in message.signals}
BLOCK_ID, FLOW_ID, PART_ID, FD_PART_ID = (
    _MESSAGES[name].frame_id for name in ("Block", "BlockFlow", "Recording", "RecordingFd")
)
_PART_BYTES = {PART_ID: 8, FD_PART_ID: 64}

DBC_NODE = 64  # the node whose identifiers the DBC has
ANSWER_S = 1.0
_WITHOUT_RANGE = ("zero_x", "zero_z", "set_learned", "set_parts")  # they answer once
HEARTBEAT = messages.NUMBERS["command"]["heartbeat"]
BUSY_TRIES, BUSY_S = 20, 0.01
MOST_MENDS = 4  # a session that was joined and is over, command, the level; and the order itself
PERIOD_S = 0.01  # of the status
PATIENCE_S = 10.0  # longest time for which a controller is waited for that lags behind the clock
SILENT_S = 0.5  # without status: no controller is there


@dataclass
class Status:
    """Newest signals of the status by their names, and when [s] their message came."""

    signals: dict[str, float] = field(default_factory=dict)
    at_s: float = -1e9
    n_rows: int = 0

    @property
    def state(self) -> str:
        """Name of the state."""
        return messages.NAMES["state"].get(int(self.signals.get("state", -1)), "unknown")

    @property
    def faults(self) -> list[str]:
        """Names of the latched faults."""
        return [name for name in messages.FAULT_TEXTS if self.signals.get(f"fault_{name}")]

    @property
    def table_name(self) -> str:
        """Name of the part whose table is in use, as far as it was reported."""
        parts = (int(self.signals.get(f"table_name_{i}", 0)) for i in range(6))
        raw = b"".join(part.to_bytes(6, "little") for part in parts)
        return raw.split(b"\0")[0].decode("ascii", "replace")


def _frame(identifier: int, data: bytes) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)


class Link:
    """A bus with one controller.

    where: how the user named the bus, for messages. node: 1 .. 127; identifiers here are those of
    node 64, as in the DBC. on_row: called whenever a set of status messages is complete. on_wait:
    called before each frame is waited for; what it raises ends what runs, as a signal would.
    Heartbeats are sent while frames are waited for.
    """

    def __init__(self, bus: can.BusABC, where: str, node: int = DBC_NODE) -> None:
        self.bus, self.where = bus, where
        self.rights = Rights(self, sender_of("camctl"))
        self.is_fd = bus.protocol in (can.CanProtocol.CAN_FD, can.CanProtocol.CAN_FD_NON_ISO)
        self._shift = node - DBC_NODE
        self.status = Status()
        self.on_row: Callable[[Status], None] = lambda status: None
        self.on_wait: Callable[[], None] = lambda: None
        self._answers: deque[can.Message] = deque()
        self.flows: deque[can.Message] = deque()
        self.parts: deque[bytes] = deque(maxlen=256)

    # Frames

    def pump(self, timeout_s: float) -> bool:
        """Take one frame; return whether one came."""
        self.on_wait()
        self.rights.beat()
        try:
            with signals_held():
                frame = self.bus.recv(timeout_s)
        except (can.CanError, OSError) as error:
            problem = f"the connection to the bus is lost: {error}; {remedy_for(error, self.where)}"
            raise Refused(f"{self.where}: {problem}") from error
        if frame is None:
            return False
        if not (frame.is_error_frame or frame.is_remote_frame or frame.is_extended_id):
            self._take(frame)
        return True

    def catch_up(self) -> None:
        """Take all frames that have come."""
        while self.pump(0):
            pass

    def _take(self, frame: can.Message) -> None:
        identifier = frame.arbitration_id - self._shift
        if identifier == messages.ANSWER.frame_id and len(frame.data) == messages.ANSWER.length:
            if frame.data[0] == HEARTBEAT:
                self.rights.heard(messages.answer_of(bytes(frame.data)))
            else:
                self._answers.append(frame)
        elif len(frame.data) == _PART_BYTES.get(identifier):
            self.parts.append(bytes(frame.data))
        elif identifier == FLOW_ID:
            self.flows.append(_frame(identifier, bytes(frame.data)))
        elif (message := _STATUS.get(identifier)) and len(frame.data) == message.length:
            self._take_status(message, bytes(frame.data))

    def _take_status(self, message: Message, data: bytes) -> None:
        try:
            decoded = message.decode_simple(data, decode_choices=False, allow_truncated=False)
        except DecodeError:  # a page of a controller that is newer than this program
            return
        self.status.signals |= {name: float(str(value)) for name, value in decoded.items()}
        self.status.at_s = time.monotonic()
        if message.name == "Detail" and decoded["page"] == 0 and "state" in self.status.signals:
            self.status.n_rows += 1
            self.on_row(self.status)

    def send_frame(self, identifier: int, data: bytes) -> None:
        """Send a frame."""
        try:
            with signals_held():
                self.bus.send(_frame(identifier + self._shift, data), timeout=ANSWER_S)
        except (can.CanError, OSError) as error:
            asked = "is the bus up, with somebody else on it at the same bit rate?"
            problem = f"the frame cannot be sent: {error}; {remedy_for(error, self.where, asked)}"
            raise Refused(f"{self.where}: {problem}") from error

    def wait(self, is_done: Callable[[], bool], timeout_s: float) -> bool:
        """Take frames until a condition holds; return whether it did in time."""
        end_s = time.monotonic() + timeout_s
        while not is_done():
            left_s = end_s - time.monotonic()
            if left_s <= 0:
                return False
            self.pump(min(left_s, 0.1))
        return True

    def await_anew(self, signal: str, timeout_s: float) -> None:
        """Forget a signal of the status, and wait until it comes."""
        self.status.signals.pop(signal, None)
        self.wait(lambda: signal in self.status.signals, timeout_s)

    def wait_in_its_time(self, is_done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait by the controller's own time, which may be slower; `PATIENCE_S` more at most."""
        begin_s, rows = time.monotonic(), self.status.n_rows
        if self.wait(is_done, timeout_s):
            return True
        while time.monotonic() - begin_s < timeout_s + PATIENCE_S:
            is_heard = time.monotonic() - self.status.at_s < SILENT_S
            if not is_heard or self.status.n_rows - rows >= timeout_s / PERIOD_S:
                return False
            if self.wait(is_done, PERIOD_S):
                return True
        return False

    def next_row(self, timeout_s: float) -> bool:
        """Wait for the next set of status messages; return whether it came in time."""
        n_rows = self.status.n_rows
        return self.wait(lambda: self.status.n_rows > n_rows, timeout_s)

    def _silence(self) -> Refused:
        if time.monotonic() - self.status.at_s < SILENT_S:
            return Refused(
                f"{self.where}: no answer, though status comes; is another program sending "
                "commands, or the bus too busy?"
            )
        return Refused(
            f"{self.where}: no answer and no status from a controller; check its power, the "
            "wiring with both terminators, --interface, --channel, --bitrate and --node"
        )

    # Commands

    def next_answer(self, command: str, timeout_s: float, echo: int | None = None) -> Answer:
        """Return the next answer to a command, of those that echo a parameter if one is given."""
        end_s = time.monotonic() + timeout_s
        while True:
            left_s = end_s - time.monotonic()
            if not self.wait_in_its_time(lambda: bool(self._answers), left_s):
                raise self._silence()
            answer = messages.answer_of(bytes(self._answers.popleft().data))
            if answer.command == command and echo in (None, answer.parameter):
                return answer

    def send_command(self, command: str, *, parameter: int = 0, **value: float) -> None:
        """Send a command without waiting for its answer; arguments and errors as those of ask()."""
        stamp = self.rights.stamp(command)
        data = messages.command_bytes(command, parameter, value, **stamp)
        self.send_frame(messages.COMMAND.frame_id, data)

    def ask(
        self, command: str, *, timeout_s: float = ANSWER_S, parameter: int = 0, **value: float
    ) -> Answer:
        """Send a command, again while the controller is busy, and return its answer.

        Where it needs command, `rights` takes it first, if it may. value: at most one signal of the
        message Command, in its unit. Raises CamtoolsError: the value is outside the range of its
        signal; Refused: no answer comes, another has command, or it was lost.
        """
        self.rights.prepare(command)
        for _ in range(MOST_MENDS):
            answer = self.ask_once(
                command, timeout_s=timeout_s, parameter=parameter, echo=None, **value
            )
            if not self.rights.mend(answer):
                break
        return answer

    def ask_once(
        self,
        command: str,
        *,
        timeout_s: float = ANSWER_S,
        parameter: int = 0,
        echo: int | None = None,
        **value: float,
    ) -> Answer:
        """Do as ask(), but leave the rights as they are; `echo` is that of next_answer()."""
        for _ in range(BUSY_TRIES):
            self.catch_up()
            self._answers.clear()
            self.send_command(command, parameter=parameter, **value)
            answer = self.next_answer(command, timeout_s, echo)
            if answer.result == "param_range" and command not in _WITHOUT_RANGE:
                low = self.next_answer("get_minimum", ANSWER_S).value
                high = self.next_answer("get_maximum", ANSWER_S).value
                return Answer(**(vars(answer) | {"limits": (low, high)}))
            if answer.result != "busy":
                break
            self.wait(lambda: False, BUSY_S)
        return answer

    def listen(self) -> Status:
        """Catch up, and wait for every message and page of the status.

        Refused where a controller lacks one.
        """
        self.catch_up()
        if not self.wait_in_its_time(lambda: self.status.signals.keys() >= WANTED, ANSWER_S):
            is_heard = time.monotonic() - self.status.at_s < SILENT_S
            older = f"{self.where}: {_lacks(self.status.signals.keys())}: {messages.OLDER}"
            raise Refused(older) if is_heard else self._silence()
        return self.status


def _lacks(there: Collection[str]) -> str:
    """Return which messages and pages of the status are not there, or not whole."""
    parts = {
        message.name + (f" page {signal.multiplexer_ids[0]}" if signal.multiplexer_ids else "")
        for message in _STATUS.values()
        for signal in message.signals
        if signal.name not in there
    }
    return f"the status lacks {', '.join(sorted(parts))}"
