"""Run by the system's Python: lets LinuxCNC's interpreter read a program, writes down its moves.

usage: linuxcnc_reader.py PROGRAM POINTS VARIABLES
"""

import importlib
import sys
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

MM_PER_INCH = 25.4
REFUSED = 3  # exit status
LINEAR = (0, 1, 2, 6, 7, 8)
# What the interpreter asks of a machine: all nine axes, whether lines with a slash count, user
# units, a tool without offsets, whether somebody asks to stop.
ANSWERS = {
    "get_axis_mask": 0x1FF,
    "get_block_delete": False,
    "get_external_length_units": 1.0,
    "get_external_angular_units": 1.0,
    "get_tool": (-1, *(0.0,) * 12, 0),
    "check_abort": False,
}
MOVES = {"straight_traverse": 0.0, "straight_feed": 1.0}


class Canon:
    """A machine with nine axes that only writes down where it is told to go."""

    def __init__(self, variables: str) -> None:
        self.parameter_file = variables
        self.points = array("d")

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Write moves down, answer what is asked, accept every other call."""
        if name in MOVES:
            return lambda *axes: self._went(MOVES[name], axes)
        return lambda *_: ANSWERS.get(name)

    def _went(self, kind: float, inches: tuple[float, ...]) -> None:
        axes = [v * MM_PER_INCH if i in LINEAR else v for i, v in enumerate(inches)]
        self.points.extend([kind, *axes])


def main() -> int:
    """Read the program; print the interpreter's error; return REFUSED when there is one."""
    program, points, variables = sys.argv[1:]
    gcode: Any = importlib.import_module("gcode")
    canon = Canon(variables)
    result, line = gcode.parse(program, canon, "", "")
    Path(points).write_bytes(canon.points.tobytes())
    if result > gcode.MIN_ERROR:
        print(f"line {line}: {gcode.strerror(result)}")
        return REFUSED
    return 0


if __name__ == "__main__":
    sys.exit(main())
