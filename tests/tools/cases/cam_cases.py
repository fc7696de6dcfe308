"""What several tests of cams use: parts of a text, the firmware's own evaluation."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from camsim_cases import camsim
from camtools.lobe.generate import GeneratedCam
from camtools.lobe.part import CamPart
from camtools.part.file import parse_any
from camtools.skirt.sections import Floats
from camtools.table.image import pack

NM = 1e-6  # mm


def cam(text: str) -> CamPart:
    """Return the cam of a text."""
    part = parse_any(text.encode(), "c.toml")
    assert isinstance(part, CamPart)
    return part


def evaluate(folder: Path, result: GeneratedCam, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the columns that camsim eval gives at points."""
    path = folder / "cam.camtab"
    path.write_bytes(pack(result.table))
    rows = "".join(f"{t!r},{z!r}\n" for t, z in zip(turn.tolist(), z_mm.tolist(), strict=True))
    done = camsim("eval", path, stdin=f"turn,z_mm\n{rows}")
    assert done.returncode == 0, done.stderr
    table = list(csv.DictReader(done.stdout.splitlines()))
    return {name: np.array([float(row[name]) for row in table]) for name in table[0]}
