"""Command line of the whole pipeline: table, cut on the host simulator, gauge, report.

>>> main(["--feed", "0"])
2
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from camtools.base.command import run_command
from camtools.pipeline.run import run


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status.

    Returns
    -------
    int
        0 done, 1 fault or out of tolerance, 2 wrong usage or bad input, 128 + n on signal n.
    """
    return run_command("run", lambda: run(sys.argv[1:] if argv is None else argv))


if __name__ == "__main__":
    sys.exit(main())
