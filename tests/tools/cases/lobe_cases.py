"""What several tests of cams use: parts of a text, the firmware's own evaluation."""

from pathlib import Path

import numpy as np

from camtools.base.quantities import Floats
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.part import LobePart
from camtools.pipeline.load import parse
from tests.tools.cases.camsim_cases import ROOT
from tests.tools.cases.cut_cases import PARTS, evaluated

MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"
QUICK = ("--set", "engage_turns=1", "--set", "disengage_turns=1", "--no-learning")
NM = 1e-6  # mm


def cam(text: str) -> LobePart:
    """Return the cam of a text."""
    part = parse(text.encode(), "c.toml").part
    assert isinstance(part, LobePart)
    return part


def ground_list(csv: Path, step_deg: float, digits: int, rise: tuple[float, float]) -> str:
    """Return a ground cam listed at even angles: a 4-5-6-7 polynomial of mm in degrees.

    The lobe, base circle 18 mm, has hollow flanks; its wheel has a radius of 50 mm.
    """
    lift_mm, half_deg = rise
    deg = step_deg * np.arange(round(360 / step_deg))
    x = np.clip(1 - np.abs(deg - 180) / half_deg, 0, 1)
    lift = lift_mm * x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
    np.savetxt(
        csv,
        np.stack([deg, lift], axis=1),
        ["%.6f", f"%.{digits}f"],
        ",",
        header="angle_deg,lift_mm",
        comments="",
    )
    text = (PARTS / "cam-345-ground.toml").read_text()
    for old, new in (
        ('law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70\n', f'law = "list"\ncsv = "{csv}"\n'),
        ("base_radius_mm = 20", "base_radius_mm = 18"),
        ("wheel_radius_mm = 200", "wheel_radius_mm = 50"),
        ('speed = "constant-surface"', 'speed = "uniform"'),
        ("spindle_rpm = 60", "spindle_rpm = 30"),
    ):
        assert old in text
        text = text.replace(old, new)
    return text


def evaluate(folder: Path, result: GeneratedLobes, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the columns that camsim eval gives at points."""
    return evaluated(folder, result.table, turn, z_mm)
