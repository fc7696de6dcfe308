"""Make host_sim/machines/default.toml from the keys that the simulator has.

>>> main([])
0
"""

import sys
import textwrap

from camtools.base.project import ROOT
from camtools.sim.machine_file import MachineKey, machine_keys
from checks.page_command import page_command

_PAGE = "host_sim/machines/default.toml"
_MACHINE = """\
# The default machine: a voice-coil fast tool servo on a piston lathe. Lists every key with its
# default; a machine file needs only those that differ. Numbers are invented but typical.
# Generated from host_sim/setup/sim_config.c: build/venv/bin/python -m checks.machinefile --write
"""
_SECTIONS = {
    "u": "the fast tool axis",
    "x": "carries the profile",
    "z": "feeds along the part",
    "swing": "of the tool for turned cams; other parts do not move it",
    "tool": "that turns sections; cams: --tool-tip-mm",
    "cut": "cutting force on U when turning sections",
    "chuck": "its jaws spring parts that are turned by sections",
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
    """Return a line and its comment, in as many lines as it takes.

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
    """Return the text of the file by its path in the project."""
    return {_PAGE: default_machine()}


def main(words: list[str] | None = None) -> int:
    """Compare the file with the built simulator, or write it anew."""
    return page_command("machinefile", __doc__, ROOT, pages, words)


if __name__ == "__main__":
    sys.exit(main())
