"""What several tests of cams use: parts of a text, the firmware's own evaluation."""

import csv
from pathlib import Path

import numpy as np

from camtools.base.quantities import Floats
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.part import LobePart
from camtools.pipeline.load import parse
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import camsim

NM = 1e-6  # mm


def cam(text: str) -> LobePart:
    """Return the cam of a text."""
    part = parse(text.encode(), "c.toml").part
    assert isinstance(part, LobePart)
    return part


def evaluate(folder: Path, result: GeneratedLobes, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the columns that camsim eval gives at points."""
    path = folder / "cam.camtab"
    path.write_bytes(pack(result.table))
    rows = "".join(f"{t!r},{z!r}\n" for t, z in zip(turn.tolist(), z_mm.tolist(), strict=True))
    done = camsim("eval", path, stdin=f"turn,z_mm\n{rows}")
    assert done.returncode == 0, done.stderr
    table = list(csv.DictReader(done.stdout.splitlines()))
    return {name: np.array([float(row[name]) for row in table]) for name in table[0]}
