# SPDX-License-Identifier: Apache-2.0
r"""Make the look-up pages of parameters and CAN messages of their sources, or compare them.

>>> print(table([("a", "b"), ("1", "2|3")]), end="")
| a | b |
|---|---|
| 1 | 2\|3 |
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping, Sequence

from cantools.database.can import Message, Signal

from camtools.base.project_paths import ROOT
from camtools.link.messages import DATABASE, NAMES
from camtools.link.parameters import INFOS, Info, group_of
from checks.page_command import page_command

_NOTE = "`build/venv/bin/python -m checks.lookup --write` (in tools/) generates the page.\n"
_PARAMETERS = f"""# Parameters of the controller

For whoever sets up a machine: every parameter with default, range and meaning, as
[cam_param.h](param/cam_param.h) has them. Values are whole numbers in the unit at the end of the
name; `tools/camctl list` prints those in force. An operator may change those marked "yes"; all
others need the unlocked level ([rights](README.md#rights)). "no." is the index on the bus.
{_NOTE}"""
_MESSAGES = f"""# CAN messages

For those who write a tool for the bus: the signals of every message and the names of their values,
as [camturn.dbc](camturn.dbc) has them. [README.md](README.md) describes how they are used.
{_NOTE}"""
_TITLES = {
    "axis_u": "Axis U",
    "axes_x_z": "Axes X and Z",
}


def table(rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown; the first row is its head."""
    lines = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    head, *body = [f"| {' | '.join(line)} |\n" for line in lines]
    return f"{head}|{'---|' * len(lines[0])}\n{''.join(body)}"


def _operator_names() -> set[str]:
    header = (ROOT / "firmware" / "param" / "cam_param.h").read_text("utf-8")
    listed = header.split("#define CAM_OPERATOR_PARAMS(X)")[1].split("// clang-format")[0]
    return set(re.findall(r"X\((\w+)\)", listed))


def _parameter_row(name: str, info: Info, *, is_operators: bool) -> Sequence[str]:
    number = str(list(INFOS).index(name))
    span = f"{info.low} .. {info.high}"
    return f"`{name}`", number, str(info.default), span, "yes" * is_operators, info.what


def parameters_page() -> str:
    """Return the text of PARAMETERS.md."""
    operators = _operator_names()
    groups: dict[str, list[Sequence[str]]] = {}
    for name, info in INFOS.items():
        row = _parameter_row(name, info, is_operators=name in operators)
        groups.setdefault(group_of(name), []).append(row)
    head = ("parameter", "no.", "default", "range", "operator", "meaning")
    return _PARAMETERS + "".join(
        f"\n## {_TITLES.get(group, group.capitalize())}\n\n{table([head, *rows])}"
        for group, rows in groups.items()
    )


def _sent_with(signal: Signal) -> str:
    """Return the pages or commands with which a signal is sent."""
    numbers = sorted(signal.multiplexer_ids or [])
    if signal.multiplexer_signal == "page":
        return ", ".join(map(str, numbers))
    return ", ".join(NAMES["command"][n] for n in numbers) if len(numbers) < 9 else "other commands"


def _signal_row(signal: Signal) -> Sequence[str]:
    unit = " ".join([f"{signal.scale:.6g}"] * (signal.scale != 1) + [signal.unit or ""])
    last = signal.start + signal.length - 1
    bits = f"{signal.start} .. {last}" if signal.length > 1 else str(last)
    return f"`{signal.name}`", _sent_with(signal), bits, unit.strip(), str(signal.comment or "")


def _message_text(message: Message) -> str:
    signals = [one for one in message.signals if not re.search("(name|bytes)_[1-9]$", one.name)]
    signals.sort(key=lambda one: (min(one.multiplexer_ids or [-1]), one.start))
    rows = [("signal", "with", "bits", "unit", "meaning"), *map(_signal_row, signals)]
    return f"\n## {message.name}, 0x{message.frame_id:03X}\n\n{message.comment}\n\n{table(rows)}"


def _results() -> str:
    header = (ROOT / "firmware" / "base" / "cam_err.h").read_text("utf-8")
    rows = re.findall(r'X\((\w+), +(-\d+), +"([^"]*)"', header)
    cells = [(number, f"`{name}`", text) for name, number, text in rows]
    return f"\n## Results\n\n{table([('result', 'name', 'meaning'), *cells])}"


def _names() -> str:
    assert DATABASE.dbc is not None
    shown = {name: names for name, names in NAMES.items() if name not in ("parameter", "result")}
    tables: dict[str, Mapping[int, object]] = {**shown, **DATABASE.dbc.value_tables}
    lines = [
        f"- `{title}`: {', '.join(f'{number} {names[number]}' for number in sorted(names))}\n"
        for title, names in tables.items()
    ]
    return f"\n## Names of values\n\n{''.join(lines)}"


def messages_page() -> str:
    """Return the text of MESSAGES.md."""
    return _MESSAGES + "".join(map(_message_text, DATABASE.messages)) + _names() + _results()


def pages() -> dict[str, str]:
    """Return the texts of both pages by their paths in the project."""
    return {
        "firmware/PARAMETERS.md": parameters_page(),
        "firmware/remote/can/MESSAGES.md": messages_page(),
    }


def main(words: list[str] | None = None) -> int:
    """Compare both pages with their sources, or write them anew."""
    return page_command("lookup", __doc__, ROOT, pages, words)


if __name__ == "__main__":
    sys.exit(main())
