# SPDX-License-Identifier: Apache-2.0
"""How far the service is with what it is busy with.

>>> share_of("download, 40 %"), share_of(""), share_of("keep")
(0.4, 0.0, 0.0)
"""

from __future__ import annotations

import re

_PERCENT = re.compile(r"(\d{1,3}) ?%")


def share_of(work: str) -> float:
    """Return the share that a text tells in per cent, 0 .. 1; 0 where it tells none."""
    found = _PERCENT.search(work)
    return min(int(found[1]), 100) / 100 if found else 0.0
