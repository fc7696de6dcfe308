"""NC programs as the tests read them, which share nothing with what writes them."""

import re
from pathlib import Path

import numpy as np

from camtools.base.quantities import Floats

WORD = re.compile(r"([A-Z])(-?[0-9.]+)")


def moves(program: Path, code: str, axes: str) -> Floats:
    """Return the words of all blocks of a motion code, our own way of reading."""
    rows = []
    for line in program.read_text().splitlines():
        if line.startswith(f"{code} "):
            words = dict(WORD.findall(line.partition(" ")[2]))
            rows.append([float(words[axis]) for axis in axes])
    return np.array(rows)
