# SPDX-License-Identifier: Apache-2.0
"""Times and sizes as people say them.

>>> duration_text(8.04), duration_text(200), duration_text(5_000), duration_text(400_000)
('8 s', '3 min 20 s', '1 h 23 min', '4 d 15 h')
>>> size_text(3456), size_text(9_900_000)
('3.5 kB', '9.9 MB')
"""

from __future__ import annotations

from itertools import pairwise

_STEPS = (("d", 86_400), ("h", 3_600), ("min", 60), ("s", 1))


def duration_text(seconds: float) -> str:
    """Return a time in its two largest units."""
    left = round(seconds)
    for (large, n_large), (small, n_small) in pairwise(_STEPS):
        if left >= n_large:
            whole, rest = divmod(left, n_large)
            return f"{whole} {large}" + (f" {rest // n_small} {small}" if rest >= n_small else "")
    return f"{left} s"


def size_text(n_bytes: float) -> str:
    """Return a size in the unit that leaves one to three digits before the point."""
    for unit in ("bytes", "kB", "MB"):
        if n_bytes < 1000:
            digits = 0 if unit == "bytes" or n_bytes >= 10 else 1
            return f"{n_bytes:.{digits}f} {unit}"
        n_bytes /= 1000
    return f"{n_bytes:.1f} GB"
