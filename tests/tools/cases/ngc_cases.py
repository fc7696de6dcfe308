"""Part files with changes, and NC programs read without what writes them."""

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


def changed(folder: Path, part: Path, **values: str) -> Path:
    """Return a copy of a part file with values of [process] replaced, or added."""
    text = part.read_text()
    for key, value in values.items():
        line = re.compile(rf"^{key} = .*$", re.MULTILINE)
        text, n = line.subn(f"{key} = {value}", text, count=1)
        if n == 0:
            text = text.replace("[process]", f"[process]\n{key} = {value}")
    path = folder / "part.toml"
    path.write_text(text)
    return path
