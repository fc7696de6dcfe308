r"""Make look-up pages, lists of camturn.dbc and its C from their sources, or compare them.

>>> print(table([("a", "b"), ("1", "2|3")]), end="")
| a | b |
|---|---|
| 1 | 2\|3 |
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence

from cantools.database.can import Database, Message, Signal

from camtools.base.project import ROOT
from camtools.link.kept_values import INFOS, Info, group_of
from camtools.link.messages import choices_of
from checks.dbc import DBC, c_sources, dbc_text, errors, headers
from checks.page_command import page_command

_NOTE = "`build/venv/bin/python -m checks.lookup --write` (in tools/) generates the page.\n"
_PARAMETERS = f"""# Parameters of the controller

For whoever sets up a machine: every parameter with default, range and meaning, as
[cam_param.h](param/cam_param.h) has them. Values are whole numbers in the unit at the end of the
name; `tools/camctl list` prints those in force. "no." is the index on the bus. Parameters change in
the states off, ready and manual, in the unlocked level ([rights](README.md#rights)). Flags:
`operator`: also without that level; `cut`: also in the work; `off`: in off only; `rest`: only while
U rests; `unlearn`: ends what was learned of U's drive; `ripple`: blends the learned ripple anew;
`sign`: 0 is refused; `transient`: the controller does not keep it.
{_NOTE}"""
_MESSAGES = f"""# CAN messages

For those who write a tool for the bus: the signals of every message and the names of their values,
as [camturn.dbc](camturn.dbc) has them. [README.md](README.md) describes how they are used.
{_NOTE}"""
_TITLES = {"axis_u": "Axis U", "axes_x_z": "Axes X and Z"}


def table(rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown; the first row is its head."""
    lines = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    head, *body = [f"| {' | '.join(line)} |\n" for line in lines]
    return f"{head}|{'---|' * len(lines[0])}\n{''.join(body)}"


def _parameter_row(name: str, info: Info) -> Sequence[str]:
    number = str(list(INFOS).index(name))
    span = f"{info.low} .. {info.high}"
    return f"`{name}`", number, str(info.default), span, ", ".join(info.flags), info.what


def parameters_page() -> str:
    """Return the text of PARAMETERS.md."""
    groups: dict[str, list[Sequence[str]]] = {}
    for name, info in INFOS.items():
        groups.setdefault(group_of(name), []).append(_parameter_row(name, info))
    head = ("parameter", "no.", "default", "range", "flags", "meaning")
    return _PARAMETERS + "".join(
        f"\n## {_TITLES.get(group, group.capitalize())}\n\n{table([head, *rows])}"
        for group, rows in groups.items()
    )


def _sent_with(signal: Signal, message: Message) -> str:
    """Return the pages or commands with which a signal is sent."""
    numbers = sorted(signal.multiplexer_ids or [])
    if signal.multiplexer_signal == "page":
        return ", ".join(map(str, numbers))
    if len(numbers) > 8:
        return "other commands"
    return ", ".join(choices_of(message, "command")[n] for n in numbers)


def _signal_row(signal: Signal, message: Message) -> Sequence[str]:
    unit = " ".join([f"{signal.scale:.6g}"] * (signal.scale != 1) + [signal.unit or ""])
    last = signal.start + signal.length - 1
    bits = f"{signal.start} .. {last}" if signal.length > 1 else str(last)
    sent_with = _sent_with(signal, message)
    return f"`{signal.name}`", sent_with, bits, unit.strip(), str(signal.comment or "")


def _message_text(message: Message) -> str:
    signals = [
        signal for signal in message.signals if not re.search("(name|bytes)_[1-9]$", signal.name)
    ]
    signals.sort(key=lambda signal: (min(signal.multiplexer_ids or [-1]), signal.start))
    rows = [_signal_row(signal, message) for signal in signals]
    head = ("signal", "with", "bits", "unit", "meaning")
    return (
        f"\n## {message.name}, 0x{message.frame_id:03X}\n\n"
        f"{message.comment}\n\n{table([head, *rows])}"
    )


def _names_of_values(database: Database) -> str:
    assert database.dbc is not None
    tables = {
        signal.name: choices_of(message, signal.name)
        for message in database.messages
        for signal in message.signals
        if signal.choices and signal.name not in ("parameter", "result", "table_result")
    }
    lines = [
        f"- `{title}`: {', '.join(f'{number} {names[number]}' for number in sorted(names))}\n"
        for title, names in (tables | dict(database.dbc.value_tables)).items()
    ]
    return f"\n## Names of values\n\n{''.join(lines)}"


def messages_page(database: Database, text: str) -> str:
    """Return the text of MESSAGES.md."""
    results = [(number, f"`{name}`", what) for number, name, what in errors(text)]
    return (
        _MESSAGES
        + "".join(map(_message_text, database.messages))
        + _names_of_values(database)
        + f"\n## Results\n\n{table([('result', 'name', 'meaning'), *results])}"
    )


def pages() -> dict[str, str]:
    """Return the texts of the DBC, both pages and the C by their paths in the project."""
    text = headers()
    dbc = dbc_text(text)
    database = Database()
    database.add_dbc_string(dbc)
    return {
        DBC: dbc,
        "firmware/PARAMETERS.md": parameters_page(),
        "firmware/remote/can/MESSAGES.md": messages_page(database, text),
        **c_sources(database),
    }


def main(words: list[str] | None = None) -> int:
    """Compare the DBC, both pages and the C with their sources, or write them anew."""
    return page_command("lookup", __doc__, ROOT, pages, words)


if __name__ == "__main__":
    sys.exit(main())
