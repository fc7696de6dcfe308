# SPDX-License-Identifier: Apache-2.0
"""Tables that take a correction off their drawing, against formulas and on the simulator."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.base.errors import CamtoolsError
from camtools.cut.correction import Correction, correction_of, nodes_of
from camtools.pipeline.load import Loaded, load
from camtools.pipeline.make_table import make
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart, example_part
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.part_cases import ROOT

Floats = NDArray[np.float64]
ENDS = (0.0, 62.0)


def part_with(nose_mm: float = 0.0, **process: object) -> SkirtPart:
    """Return the example with a nose and other keys of [process]."""
    raw = example_part().model_dump()
    raw["process"] |= process
    raw["tool"] |= {"nose_radius_mm": nose_mm}
    return SkirtPart.model_validate(raw)


def some_correction() -> Correction:
    """Return waves that `formula_mm` gives in closed form."""
    z = nodes_of(ENDS)
    waves = {
        0: 2e-3 * np.sin(z / 10),
        1: 1e-3 * (1 + 0.5j) * np.ones_like(z),
        2: 3e-3 * np.exp(1j * z / 30),
        7: 5e-4 * (z / 62),
    }
    return Correction(ENDS, {order: one.astype(np.complex128) for order, one in waves.items()})


def formula_mm(turn: Floats, z: Floats) -> Floats:
    """Return what `some_correction` takes off the radius."""
    phi = 2 * np.pi * turn
    one = 1e-3 * (np.cos(phi) + 0.5 * np.sin(phi))
    two = 3e-3 * np.cos(2 * phi - z / 30)
    return 2e-3 * np.sin(z / 10) + one + two + 5e-4 * z / 62 * np.cos(7 * phi)


def tip_mm(folder: Path, turn: Floats, z_mm: Floats) -> Floats:
    """Return where the firmware puts the tip by the table in a folder."""
    rows = "".join(f"{t!r},{z!r}\n" for t, z in zip(turn.tolist(), z_mm.tolist(), strict=True))
    done = camsim("eval", folder / "example.camtab", stdin=f"turn,z_mm\n{rows}")
    assert done.returncode == 0, done.stderr
    values = np.loadtxt(done.stdout.splitlines()[1:], delimiter=",")
    return np.asarray((values[:, 5] - values[:, 2]) * 1e-6)


def written(part: SkirtPart, correction: Correction, folder: Path) -> Path:
    """Make the table of a part into a folder."""
    made = make(Loaded(KIND, part), "example.toml", correction=correction)
    for name, data in made.files(with_plots=False).items():
        (folder / name).write_bytes(data)
    return folder


@pytest.mark.parametrize(
    "process", [{}, {"direction": -1}, {"run_in_mm": 2.0, "run_out_mm": 1.0, "u_zero": "mean"}]
)
def test_firmware_plays_drawing_less_correction(process: dict[str, Any], tmp_path: Path) -> None:
    """Both ways round, with run-in and U about its mean: within 4 nm of the drawing's formula."""
    part = part_with(**process)
    folder = written(part, some_correction(), tmp_path)
    rng = np.random.default_rng(15)
    turn, z = rng.uniform(0, 1, 2000), rng.uniform(*ENDS, 2000).round(6)
    wanted = KIND.drawing(part).radius_mm(turn, z) - formula_mm(turn, z)
    assert np.abs(tip_mm(folder, turn, z) - wanted).max() < 4e-6


def test_nose_follows_the_corrected_surface(tmp_path: Path) -> None:
    """A nose stands off the corrected surface by no less than off the drawing, to 20 nm."""
    (tmp_path / "plain").mkdir()
    (tmp_path / "corrected").mkdir()
    none = Correction(ENDS, {})
    part = part_with(nose_mm=0.8)
    plain, other = (
        written(part, one, tmp_path / name)
        for one, name in ((none, "plain"), (some_correction(), "corrected"))
    )
    rng = np.random.default_rng(16)
    turn, z = rng.uniform(0, 1, 500), rng.uniform(1, 61, 500).round(6)
    taken = tip_mm(plain, turn, z) - tip_mm(other, turn, z)
    assert np.abs(taken - formula_mm(turn, z)).max() < 2e-5


def test_part_is_judged_by_its_drawing(tmp_path: Path) -> None:
    """The form error is the correction, the controller's own error that of the plain part."""
    part = part_with()
    folder = written(part, some_correction(), tmp_path)
    done = camsim("run", folder / "example.camtab", "--summary", tmp_path / "s.json")
    assert done.returncode == 1, "6 um beyond the drawing are beyond the tolerance"
    summary = json.loads((tmp_path / "s.json").read_text())
    turn, z = (one.ravel() for one in np.meshgrid(np.arange(720) / 720, np.linspace(*ENDS, 125)))
    largest_um = 1e3 * np.abs(formula_mm(turn, z)).max()
    assert summary["form_error_um"]["max"] == pytest.approx(largest_um, abs=0.1)
    assert summary["control_error_um"]["max"] < 0.1


def test_breaks_that_differ_by_rounding(tmp_path: Path) -> None:
    """The middle of 65 heights of 30 mm is not 15 mm to the last bit; the feed speed is finite."""
    raw = example_part().model_dump()
    raw["piston"]["profile"]["height_mm"] = [0.0, 15.0, 30.0]
    raw["piston"]["profile"]["diameter_mm"] = [79.99, 80.0, 80.01]
    raw["piston"]["profile"]["overshoot_um"] = 30.0
    raw["piston"]["ovality"]["height_mm"] = [0.0, 15.0, 30.0]
    raw["piston"]["ovality"]["ovality_mm"] = [0.3, 0.35, 0.4]
    ends = (0.0, 30.0)
    assert nodes_of(ends)[32] != 15.0
    folder = written(
        SkirtPart.model_validate(raw),
        Correction(ends, {2: 1e-3 * np.ones(65, dtype=np.complex128)}),
        tmp_path,
    )
    motion = json.loads((folder / "example.json").read_text())["motion"]
    assert 0 < motion["velocity_from_feed_mm_s"] < 1


def test_correction_is_read_back(tmp_path: Path) -> None:
    """NAME.json says the correction to a nanometre between its nodes, and the drawing unchanged."""
    folder = written(part_with(), some_correction(), tmp_path)
    report = json.loads((folder / "example.json").read_text())
    again = correction_of(report["correction"])
    rng = np.random.default_rng(17)
    phi, z = 2 * np.pi * rng.uniform(0, 1, 500), rng.uniform(*ENDS, 500)
    found = again.delta(phi, z)[0] + again.mean(z)
    assert np.abs(found - formula_mm(phi / (2 * np.pi), z)).max() < 1e-6
    assert report["design"].items() >= KIND.drawing(part_with()).document.items()


def test_gauge_refuses_a_correction_that_is_none(tmp_path: Path) -> None:
    """An order that is no whole number is named with its place."""
    folder = written(part_with(), some_correction(), tmp_path)
    path = folder / "example.json"
    report = json.loads(path.read_text())
    report["target"]["correction"][1]["order"] = 2.5
    path.write_text(json.dumps(report))
    done = camsim("run", folder / "example.camtab")
    assert done.returncode == 2
    assert "target.correction[1].order: must be a whole number of 1 .. 64" in done.stderr


def test_other_kinds_refuse(tmp_path: Path) -> None:
    """Cams and polygons have no corrected tables."""
    for name in ("cam-disc", "p3g-25"):
        loaded = load(ROOT / "tools" / "parts" / f"{name}.toml")
        with pytest.raises(CamtoolsError, match="are not corrected by gauged parts"):
            make(loaded, "part.toml", correction=Correction(ENDS, {}))
