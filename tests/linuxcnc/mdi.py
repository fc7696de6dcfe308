"""Runs under LinuxCNC's own Python: switches the machine on and carries out blocks, one a line.

Behind each block it prints the block, whether it ended in time, and output 0, input 0 and Z.
"""

import sys
from importlib import import_module
from typing import Any

LIMIT_S, DONE = 600, 1  # linuxcnc.RCS_DONE


def main(nml_file: str, blocks: list[str]) -> int:
    """Return 0 when all blocks ended well."""
    linuxcnc: Any = import_module("linuxcnc")  # LinuxCNC's own, not that of the tests
    linuxcnc.nmlfile = nml_file
    command, status = linuxcnc.command(), linuxcnc.stat()
    for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
        command.state(state)
        command.wait_complete()
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete()
    for block in blocks:
        command.mdi(block)
        ended = command.wait_complete(LIMIT_S)
        status.poll()
        print(f"{block}: {ended} {status.dout[0]} {status.din[0]} {status.position[2]:.3f}")
        if ended != DONE:
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
