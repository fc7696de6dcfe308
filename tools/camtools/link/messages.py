"""The messages of a controller: their words, a command as bytes, an answer from bytes.

The messages are those of firmware/remote/can/camturn.dbc, whose identifiers are those of node 64.

>>> NAMES["state"][4]
'cutting'
"""

from __future__ import annotations

from dataclasses import dataclass

from cantools.database.can import Database, Message

from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT

DBC = ROOT / "firmware" / "remote" / "can" / "camturn.dbc"
DATABASE = Database()
DATABASE.add_dbc_file(DBC)
COMMAND, ANSWER = (DATABASE.get_message_by_name(name) for name in ("Command", "Answer"))


def choices_of(message: Message, signal: str) -> dict[int, str]:
    """Return the names of a signal's values, by number."""
    table = message.get_signal_by_name(signal).choices
    assert table is not None
    return {number: str(name) for number, name in table.items()}


_STATE = DATABASE.get_message_by_name("State")
_DETAIL = DATABASE.get_message_by_name("Detail")
_OF_DETAIL = (
    "start_wait learn_phase learn_reason recorder_use recorder_phase params_kept hand_phase "
    "hand_end level acknowledge"
)
NAMES = {
    signal: choices_of(message, signal)
    for message, signals in (
        (COMMAND, "command parameter"),
        (ANSWER, "result"),
        (_STATE, "state reset_reason"),
        (_DETAIL, _OF_DETAIL),
    )
    for signal in signals.split()
}
NUMBERS = {table: {name: i for i, name in names.items()} for table, names in NAMES.items()}
assert DATABASE.dbc is not None
REFUSALS = [str(name) for name in DATABASE.dbc.value_tables["refusal_field"].values()]
FAULT_TEXTS = {
    signal.name.removeprefix("fault_"): str(signal.comment)
    for signal in _STATE.signals
    if signal.name.startswith("fault_")
}
NOT_COMMANDER = "not_commander"  # result of what only the commander may order
OLDER = "the controller is older than this program; give it the firmware of this version"
_VALUE_SIGNALS = {
    number: signal for signal in ANSWER.signals for number in signal.multiplexer_ids or []
}


class Refused(Exception):  # noqa: N818 - a controller that says no is no error of the program
    """The controller said no, or nothing; the text is one line for people."""


@dataclass(frozen=True)
class Answer:
    """What a controller answered.

    limits: lowest and highest value, when the value was out of its range.
    """

    command: str
    result: str  # name of a cam_err_t, "done" when accepted
    value: float  # of the signal that the command's answer has, scaled; 0 without one
    parameter: int  # index, as reported
    limits: tuple[float, float] | None = None


def check_range(name: str, value: float, low: float, high: float, unit: str) -> None:
    """Refuse a value outside of its range, in the unit of both."""
    if not low <= value <= high:
        ending = f" {unit}" if unit else ""
        span = f"{low:.10g} .. {high:.10g}{ending}"
        raise CamtoolsError([f"{name} = {value:.10g}{ending}: out of range; give {span}"])


def command_bytes(
    command: str, parameter: int, value: dict[str, float], *, sender: int = 0, session: int = 0
) -> bytes:
    """Return a command as its frame has it.

    value: at most one signal of the message Command, in its unit; sender, session: 0, 0 from a
    sender without command. Raises CamtoolsError: the value is outside the range of its signal.
    """
    number = NUMBERS["command"][command]
    signals: dict[str, float] = {"command": number, "parameter": parameter}
    signals |= {"sender": sender, "session": session}
    needed = {s.name for s in COMMAND.signals if number in (s.multiplexer_ids or [])}
    for name, wanted in value.items():
        signal = COMMAND.get_signal_by_name(name)
        assert signal.minimum is not None and signal.maximum is not None
        check_range(name, wanted, signal.minimum, signal.maximum, signal.unit or "")
    return COMMAND.encode(signals | dict.fromkeys(needed, 0.0) | value, strict=True)


def answer_of(data: bytes) -> Answer:
    """Return an answer; values that depend on the command are scaled by its signal."""
    numbers = {name: int(str(raw)) for name, raw in ANSWER.decode_simple(
        data, decode_choices=False, scaling=False).items()}  # fmt: skip
    signal = _VALUE_SIGNALS.get(numbers["command"])
    value = numbers[signal.name] * signal.scale if signal else 0
    result = NAMES["result"].get(numbers["result"], f"error {numbers['result']}")
    if result == NOT_COMMANDER:  # it tells who has command, whatever the command's own value is
        value = int.from_bytes(data[4:], "little")
    return Answer(
        command=NAMES["command"].get(numbers["command"], str(numbers["command"])),
        result=result,
        value=value,
        parameter=numbers["parameter"],
    )
