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


class Canon:
    """A machine with nine axes that only writes down where it is told to go."""

    def __init__(self, variables: str) -> None:
        self.parameter_file = variables
        self.points = array("d")

    def __getattr__(self, name: str) -> Callable[..., None]:
        """Accept every call that is no move."""
        return lambda *_: None

    def get_axis_mask(self) -> int:
        """Return all axes."""
        return 0x1FF

    def get_block_delete(self) -> bool:
        """Return that lines with a slash count."""
        return False

    def get_external_length_units(self) -> float:
        """Return user units per mm."""
        return 1.0

    def get_external_angular_units(self) -> float:
        """Return user units per degree."""
        return 1.0

    def get_tool(self, _pocket: int) -> tuple[float, ...]:
        """Return a tool without offsets."""
        return (-1, *(0.0,) * 12, 0)

    def check_abort(self) -> bool:
        """Return that nobody asks to stop."""
        return False

    def _went(self, kind: float, inches: tuple[float, ...]) -> None:
        axes = [v * MM_PER_INCH if i in LINEAR else v for i, v in enumerate(inches)]
        self.points.extend([kind, *axes])

    def straight_traverse(self, *axes: float) -> None:
        """Write a rapid move down."""
        self._went(0.0, axes)

    def straight_feed(self, *axes: float) -> None:
        """Write a feed move down."""
        self._went(1.0, axes)


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
