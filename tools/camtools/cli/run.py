"""Command line of the whole pipeline: table, cut on the host simulator, gauge, report.

>>> main(["--feed", "0"])
2
"""

from __future__ import annotations

import sys

from camtools.base.arguments import command
from camtools.pipeline.run import run

_USAGE = """\
tools/run [PART.toml] [--rpm N] [--feed MM] [--machine M] [--tolerance-nm T]
                 [--measured SURFACE.csv ..] [--upr N] [--forecast DIR] [--csv] [--keep N] [-o DIR]
                 [-- CAMSIM-OPTIONS]"""
_EPILOG = """\
Options after -- go to `camsim run`, for example an emergency stop after 5 s of cutting:
  tools/run -o build/run/estop -- --inject estop@5
Exit status: 0 done, 1 the cut ended in a fault, is out of tolerance, not decided or not gauged, 2
wrong usage or bad input."""

main = command("tools/run", run, usage=_USAGE, epilog=_EPILOG)

if __name__ == "__main__":
    sys.exit(main())
