r"""Make look-up pages, default.toml, camturn.dbc and its C from their sources, or compare them.

>>> print(table([("a", "b"), ("1", "2|3")]), end="")
| a | b |
|---|---|
| 1 | 2\|3 |
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterable, Sequence

from cantools.database.can import Database, Message, Signal

from camtools.base.project import ROOT
from camtools.link.kept_values import INFOS, Info, group_of
from camtools.link.messages import choices_of
from camtools.sim.machine_file import MachineKey, machine_keys
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


_MACHINE = """\
# The default machine: a voice-coil fast tool servo on a piston lathe. Lists every key with its
# default; a machine file needs only those that differ. Numbers are invented but typical.
# Generated from host_sim/setup/sim_config.c: build/venv/bin/python -m checks.lookup --write
"""
_SECTIONS = {
    "u": "the fast tool axis",
    "x": "carries the profile",
    "z": "feeds along the part",
    "swing": "of the tool for turned cams; other parts do not move it",
    "tool": "that turns sections; cams: --tool-tip-mm",
    "cut": "cutting force on U when turning sections",
    "wheel": "for plunge-ground lobes",
}
_BELIEVED = """
[controller]
# Any parameter of firmware/param/cam_param.h, for example
#   k1_ns = 780000
# Otherwise k1, k2, lead, lag, limits and encoder follow from the machine above (sim_config.h).

# [believed.u], [believed.encoder] and so on take the keys of [u], [encoder] and every other section
# except [machine] and [controller]: the machine as the controller is configured for it. A key that
# is not given there has its true value. One line makes a mismatch:
#   [believed.u]
#   bandwidth_hz = 270
"""
_INDENT, _WIDTH = 32, 100


def _commented(text: str, comment: str) -> str:
    """Return lines with a comment behind them.

    >>> print(_commented("a = 1", "what it is"))
    a = 1                           # what it is
    """
    if not comment:
        return text
    lines = textwrap.wrap(comment, _WIDTH - _INDENT - 2)
    texts = [text, *[""] * (len(lines) - 1)]
    return "\n".join(
        f"{before:{_INDENT - 1}} # {line}" for before, line in zip(texts, lines, strict=True)
    )


def _default_of(key: MachineKey) -> str:
    if key.choices:
        return f'"{key.choices[int(key.default)]}"'
    return str(int(key.default)) if key.default.is_integer() else repr(key.default)


def default_machine() -> str:
    """Return the text of the default machine's file."""
    lines, table = [], ""
    for key in machine_keys():
        if key.table != table:
            table = key.table
            lines += ["", _commented(f"[{table}]", _SECTIONS.get(table, ""))]
            if table == "machine":
                name = "shown in summaries, at most 63 characters"
                lines.append(_commented('name = "default"', name))
        lines.append(_commented(f"{key.name} = {_default_of(key)}", key.meaning))
    return _MACHINE + "\n".join(lines) + "\n" + _BELIEVED


def pages() -> dict[str, str]:
    """Return the texts of DBC, default machine, both pages and the C by their project paths."""
    text = headers()
    dbc = dbc_text(text)
    database = Database()
    database.add_dbc_string(dbc)
    return {
        DBC: dbc,
        "host_sim/machines/default.toml": default_machine(),
        "firmware/PARAMETERS.md": parameters_page(),
        "firmware/remote/can/MESSAGES.md": messages_page(database, text),
        **c_sources(database),
    }


def main(words: list[str] | None = None) -> int:
    """Compare what is made with its sources, or write it anew."""
    return page_command("lookup", __doc__, ROOT, pages, words)


if __name__ == "__main__":
    sys.exit(main())
