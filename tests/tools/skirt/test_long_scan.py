"""Long scans: what is too much for a table is refused with a remedy, and the remedy works."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.pipeline.make_table import Made
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import generate
from tests.tools.cases.camsim_cases import camsim, columns_of
from tests.tools.cases.part_cases import ROOT, load_part

SCAN = ROOT / "tools" / "parts" / "scan90.toml"


def true_um(phi: Floats, z_mm: Floats) -> Floats:
    """Return the section that is measured: an oval with waves of three and five."""
    oval = (50 + 0.4 * z_mm) * (1 - np.cos(2 * phi))
    return np.asarray(oval + 1.5 * np.cos(3 * phi) + 0.6 * np.cos(5 * phi + z_mm / 40))


def scan_part(
    folder: Path, n: int, z_mm: list[float], noise_um: float, **keys: object
) -> SkirtPart:
    """Return a part of n noisy points at each height."""
    noise = np.random.default_rng(7)
    lines = ["angle_deg,z_mm,reduction_um"]
    deg = 360 * np.arange(n) / n
    for z in z_mm:
        um = true_um(np.radians(deg), np.full(n, z)) + noise_um * noise.standard_normal(n)
        lines += [f"{a:.6f},{z},{value:.4f}" for a, value in zip(deg, um, strict=True)]
    (folder / "long.csv").write_text("\n".join(lines) + "\n")
    tree = load_part(SCAN).model_dump()
    tree["piston"]["section"] = {"shape": "table", "csv": str(folder / "long.csv")} | keys
    return SkirtPart.model_validate(tree)


def test_remedy_of_a_long_scan_makes_the_table(tmp_path: Path) -> None:
    """The number of waves that the message names is taken, and the cut is the true section."""
    heights = [0.0, 15, 30, 45, 60]
    with pytest.raises(GeometryError, match="no table through all points of the scan") as info:
        generate(scan_part(tmp_path, 360, heights, 0.05))
    told = re.search(r"set harmonics = (\d+): .* within ([\d.]+) um", str(info.value))
    assert told is not None
    part = scan_part(tmp_path, 360, heights, 0.05, harmonics=int(told[1]))
    result = generate(part)
    assert result.geometry.off_points_um == pytest.approx(float(told[2]), rel=0.01)
    for file, data in Made(KIND, result).files(with_plots=False).items():
        (tmp_path / file).write_bytes(data)
    words = ("--surface", str(tmp_path / "s.csv"), "--summary", str(tmp_path / "s.json"))
    done = camsim("run", tmp_path / "scan90.camtab", *words)
    assert done.returncode == 0, done.stderr
    rows = list(columns_of(tmp_path / "s.csv").values())
    off_um = 1e3 * (result.geometry.radius_mm(rows[1]) - rows[2]) - true_um(
        2 * np.pi * rows[0], rows[1]
    )
    assert np.abs(off_um).max() < 0.15  # filtered noise, the spline between heights, control
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["control_error_um"]["max"] < 0.05 < summary["form_error_um"]["max"]


def test_long_scan_of_one_height_is_read_and_gauged(tmp_path: Path) -> None:
    """Of 3600 points the wanted waves are kept; the gauge holds all points, in less than a MB."""
    part = scan_part(tmp_path, 3600, [0.0], 0.05, harmonics=15, single_height=True)
    result = generate(part)
    for file, data in Made(KIND, result).files(with_plots=False).items():
        (tmp_path / file).write_bytes(data)
    assert (tmp_path / "scan90.json").stat().st_size < 1_000_000
    done = camsim("run", tmp_path / "scan90.camtab", "--turns-limit", "20")
    assert done.returncode == 0, done.stderr
    assert "control error" in done.stdout


def test_a_jump_between_heights_is_refused(tmp_path: Path) -> None:
    """A spline over the height would leave both heights' points by more than 1 um."""
    rows = ["angle_deg,z_mm,reduction_um"]
    for z, um in ((0, 0.0), (15, 0.0), (20, 60.0), (40, 60.0), (60, 60.0)):
        rows += [f"{deg},{z},{um}" for deg in range(0, 360, 15)]
    (tmp_path / "jump.csv").write_text("\n".join(rows) + "\n")
    tree = load_part(SCAN).model_dump()
    tree["piston"]["section"] = {"shape": "table", "csv": str(tmp_path / "jump.csv")}
    with pytest.raises(GeometryError, match=r"the section at 0 degrees goes .* um beyond both"):
        make_geometry(SkirtPart.model_validate(tree))
    tree["piston"]["section"]["interpolation"] = "pchip"
    geometry = make_geometry(SkirtPart.model_validate(tree))
    between = geometry.delta(np.radians([0.0, 17.0, 200.0]), np.linspace(0, 60, 601)[:, None]).delta
    assert between.min() >= -1e-9
    assert between.max() <= 0.06 + 1e-9
    rising = geometry.delta(np.array([0.3]), np.linspace(15, 20, 101)[:, None]).delta
    assert (np.diff(rising[:, 0]) >= 0).all()


@pytest.mark.parametrize("interpolation", ["linear", "pchip", "akima", "spline"])
def test_every_way_between_heights_meets_the_points(interpolation: str, tmp_path: Path) -> None:
    """At the measured heights the surface is the points, whatever is between."""
    part = scan_part(tmp_path, 48, [0.0, 12, 30, 44, 60], 0.0, interpolation=interpolation)
    geometry = make_geometry(part)
    phi = np.radians(360 * np.arange(48) / 48)
    z = np.array([[0.0], [12], [30], [44], [60]])
    wanted = true_um(phi, z) * 1e-3
    np.testing.assert_allclose(geometry.delta(phi, z).delta, wanted, atol=1e-7)
