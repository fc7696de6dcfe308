"""What several tests of cams use: parts of a text, the firmware's own evaluation."""

from pathlib import Path

from camtools.base.quantities import Floats
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.part import LobePart
from camtools.pipeline.load import parse
from tests.tools.cases.camsim_cases import ROOT
from tests.tools.cases.cut_cases import evaluated

MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"
QUICK = ("--set", "engage_turns=1", "--set", "disengage_turns=1", "--no-learning")
NM = 1e-6  # mm


def cam(text: str) -> LobePart:
    """Return the cam of a text."""
    part = parse(text.encode(), "c.toml").part
    assert isinstance(part, LobePart)
    return part


def evaluate(folder: Path, result: GeneratedLobes, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the columns that camsim eval gives at points."""
    return evaluated(folder, result.table, turn, z_mm)
