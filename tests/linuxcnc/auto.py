"""Runs under LinuxCNC's own Python: switches on and starts a program, aborts, or switches off.

usage: auto.py NML_FILE PROGRAM|abort|off
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

LIMIT_S = 600


def main(nml_file: str, program: str) -> None:
    """Return after the start: the test watches HAL's pins."""
    linuxcnc: Any = import_module("linuxcnc")  # LinuxCNC's own, not that of the tests
    linuxcnc.nmlfile = nml_file
    command = linuxcnc.command()
    starts: list[tuple[Any, ...]] = [
        ("state", linuxcnc.STATE_ESTOP_RESET),
        ("state", linuxcnc.STATE_ON),
        ("mode", linuxcnc.MODE_AUTO),
        ("program_open", program),
        ("auto", linuxcnc.AUTO_RUN, 0),
    ]
    others: dict[str, list[tuple[Any, ...]]] = {
        "abort": [("abort",)],  # as Esc does
        "off": [("state", linuxcnc.STATE_OFF)],
    }
    for name, *values in others.get(program, starts):
        getattr(command, name)(*values)
        if name != "auto":
            command.wait_complete(LIMIT_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
