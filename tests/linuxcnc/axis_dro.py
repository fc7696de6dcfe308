"""Runs under LinuxCNC's own Python on a virtual screen: starts AXIS and compares its DRO with HAL.

usage: axis_dro.py NML_FILE

U is read in the preview before and after homing, with the index of its mark, and in the tab DRO in
mm and inches.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tkinter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

LIMIT_S, INI, MM_PER_INCH = 600.0, "lathe.ini", 25.4
N_JOINTS = 16  # LinuxCNC has marks of so many; that of U follows
ROW_OF_U = 4  # after radius, diameter, Z
END_S = time.monotonic() + LIMIT_S
PRINTED = Path("axis.txt")
# Appended to the file that is tested: prints lines and marks, which are pixels.
SPY = """
def spy(line, index_of=o.idx_for_home_or_limit_icon):
    print("line", line.strip(), index_of(line), flush=True)
    return index_of(line)
o.idx_for_home_or_limit_icon = spy
o.show_icon = lambda index, icon: print("mark", index, flush=True)
"""


def _wait(what: str, holds: Callable[[], bool]) -> None:
    while not holds():
        if time.monotonic() > END_S:
            sys.exit(f"not in time: {what}\n{PRINTED.read_text()}")
        time.sleep(0.1)


class _Lathe:
    """LinuxCNC, of which HAL's values are read."""

    def __init__(self, nml_file: str) -> None:
        linuxcnc: Any = import_module("linuxcnc")  # LinuxCNC's own, not those of the tests
        linuxcnc.nmlfile = nml_file
        self.linuxcnc = linuxcnc
        self.hal: Any = import_module("hal")
        self.component = self.hal.component("axis-dro")  # without one no value can be read
        self.component.ready()

    def switch_on(self) -> None:
        command = self.linuxcnc.command()
        for state in (self.linuxcnc.STATE_ESTOP_RESET, self.linuxcnc.STATE_ON):
            command.state(state)
            command.wait_complete()

    def is_homed(self) -> bool:
        return bool(self.hal.get_value("camturn.homed"))

    def u(self, text: str, unit_mm: float = 1.0) -> str:
        return f"U:{text % (self.hal.get_value('camturn.u') / unit_mm)}"


class _Axis:
    """AXIS, controlled as axis-remote does it."""

    def __init__(self) -> None:
        self.root = tkinter.Tk()
        self.root.withdraw()
        with PRINTED.open("w") as printed:
            self.program = subprocess.Popen(
                ["axis", "-ini", INI],
                env=os.environ | {"INI_FILE_NAME": INI},
                stdout=printed,
                stderr=printed,
            )

    def send(self, *words: str) -> str:
        try:
            return str(self.root.tk.call("send", "axis", *words))
        except tkinter.TclError:  # not there yet
            return ""

    def has_printed(self, line: str) -> bool:
        return line in PRINTED.read_text().splitlines()

    def row_of_u(self) -> str:
        text = self.send("set", "_tabs_numbers") + ".text"
        return self.send(text, "get", f"{ROW_OF_U}.0", f"{ROW_OF_U}.end").strip()


def _compare(axis: _Axis, lathe: _Lathe) -> None:
    _wait("U not homed", lambda: axis.has_printed(f"line {lathe.u('% 9.3f')} -1"))
    assert not axis.has_printed(f"mark {N_JOINTS}")
    axis.send("set", "show_offsets", "0")  # the short lines
    lathe.switch_on()
    _wait("homing", lathe.is_homed)
    _wait("U homed", lambda: axis.has_printed(f"line {lathe.u('% 9.3f')} {N_JOINTS}"))
    _wait("mark of U", lambda: axis.has_printed(f"mark {N_JOINTS}"))
    axis.send(".pane.top.right", "raise", "numbers")
    _wait("U in the tab", lambda: axis.row_of_u() == lathe.u("% 9.3f"))
    axis.send("set", "metric", "0")
    _wait("U in inches", lambda: axis.row_of_u() == lathe.u("% 9.4f", MM_PER_INCH))
    assert "Exception" not in PRINTED.read_text(), PRINTED.read_text()


def main(nml_file: str) -> None:
    """Start AXIS, compare, end AXIS."""
    with Path("axis_u.py").open("a") as file:
        file.write(SPY)
    lathe, axis = _Lathe(nml_file), _Axis()
    try:
        _compare(axis, lathe)
    finally:
        axis.program.terminate()
        axis.program.wait()
        lathe.component.exit()


if __name__ == "__main__":
    main(sys.argv[1])
