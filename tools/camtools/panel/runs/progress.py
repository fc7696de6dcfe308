# SPDX-License-Identifier: Apache-2.0
"""How far a run is, from the lines that tools/run prints.

>>> seen = RunProgress()
>>> seen = seen.after("run: cutting 622 turns, 15 s of machine time on the host simulator")
>>> seen = seen.after("camsim:  42.5 %, 6.4 s of machine time, about 3 s left")
>>> seen.share, seen.left_s, seen.text
(0.425, 3.0, 'cutting 622 turns, 15 s of machine time on the host simulator')
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

_CAMSIM = re.compile(r"camsim:\s+([\d.]+) %.*?(?:about (\d+) s left)?\s*\Z")
_MOST_CHARS = 300


@dataclass(frozen=True)
class RunProgress:
    """How far a run is."""

    text: str = "starting"  # what is done
    share: float | None = None  # of the cut, 0 .. 1, where it is known
    left_s: float | None = None  # of the cut [s]
    last: str = ""  # the last line that was no progress: why it failed, where it does

    def after(self, line: str) -> RunProgress:
        """Return the progress after another line."""
        line = line.strip()[:_MOST_CHARS]
        if found := _CAMSIM.match(line):
            left = None if found[2] is None else float(found[2])
            return replace(self, share=float(found[1]) / 100, left_s=left)
        if line.startswith("run: ") and "; " not in line:
            return RunProgress(line.removeprefix("run: "), last=self.last)
        return replace(self, last=line) if line else self
