"""The ring-helix on the simulator: Z against its path, the surface between tracks."""

import numpy as np
import pytest

from camtools.cut.path import ToolPath, ramp_of
from camtools.part.common import MachineLimits
from camtools.skirt.geometry.skirt_geometry import make_geometry
from tests.tools.cases.camsim_cases import cut, while_in
from tests.tools.cases.part_cases import ROOT, TableOf, load_part

PART = ROOT / "tools" / "parts" / "perkins240_ring_helix.toml"
Z_DRIVE_HZ = 50.0  # of the default machine, two equal poles
LAG_S = 2 / (2 * np.pi * Z_DRIVE_HZ) + 25e-6  # compensated by reading ahead: half a tick of hold
ROUND_S = 21 * 50e-6
# Two equal poles of w delay by a gamma distribution of mean 2 / w; where the speed jumps by v they
# are off by v E[(2 / w - T)+] = 4 / e^2 v / w.
CORNER = 4 * np.exp(-2) / (2 * np.pi * Z_DRIVE_HZ)
ROOT_UM = 1000.0


def z_error_um(rpm: float, path: ToolPath) -> float:
    """Return how far Z of the default machine may be off: rounded corners, and a round."""
    per_s = rpm / 60
    speed = path.feed_mm * per_s / (1 - path.ramp)
    return float(speed * CORNER * 1000) + planned_error_um(rpm, path)


def planned_error_um(rpm: float, path: ToolPath) -> float:
    """Return how far the set-point of Z may be off: a''(round)^2 / 8, lag times speed ripple."""
    per_s = rpm / 60
    acceleration = path.feed_mm * per_s**2 / (path.ramp * (1 - path.ramp))
    ripple = path.feed_mm * per_s / (1 - path.ramp) * 0.004 * (LAG_S + 2 * ROUND_S)
    return float(acceleration * ROUND_S**2 / 8 + ripple) * 1000 + 0.02


@pytest.mark.parametrize("rpm", [500.0, 2500.0])
def test_z_follows_the_path(rpm: float, table_of: TableOf) -> None:
    """Z is that of path.py within derived bounds; amid a ring, at 500 r/min, to 0.1 um."""
    words = ("--rpm", rpm, "--turns-limit", 6, "--no-learning")
    trace = while_in(cut(table_of(PART.stem), *words, tables=["trace"]).trace, "cutting")
    turn, true_z, set_z = (trace[name] for name in ("turn", "true_z_mm", "out_z_nm"))
    path = ToolPath("ring-helix", 0.0, 62.0, 0.1, ramp_of(0.1, rpm, MachineLimits()))
    turns = turn - np.round(turn[0])
    inside = turns < 6  # the operator's stop goes on to the end of a ring
    off_um = (true_z - path.height_mm(turns))[inside] * ROOT_UM
    ahead = path.height_mm(turns + rpm / 60 * LAG_S)
    set_off_um = (set_z * 1e-6 - ahead)[inside] * ROOT_UM
    assert np.abs(set_off_um).max() <= planned_error_um(rpm, path)
    assert np.abs(off_um).max() <= z_error_um(rpm, path)
    assert np.abs(off_um).max() >= z_error_um(rpm, path) / 3  # the bound is no room for errors
    assert np.round(turn[-1]) - np.round(turn[0]) == 7  # four rings, three turns of a helix
    assert true_z[-1] == pytest.approx(0.3, abs=z_error_um(rpm, path) / 1000)
    for ring in range(4 if rpm == 500 else 0):
        middle = (turns > 2 * ring + 0.25) & (turns < 2 * ring + 0.75)
        assert middle.any()
        assert np.abs(true_z[middle] - 0.1 * ring).max() < 1e-4


@pytest.mark.long
def test_map_is_that_of_the_exact_tracks(table_of: TableOf) -> None:
    """Circles on the exact tracks of a helix, cut out of the exact surface, to 0.03 um."""
    words = ("--rpm", 500, "--nose-mm", 2)
    first = cut(table_of("perkins240"), *words, tables=["scallop"]).scallop[:401]
    geometry = make_geometry(load_part(PART))
    z_mm, proud_um = first["z_mm"], first["proud_um"]
    assert (z_mm[0], z_mm[-1]) == pytest.approx((30.8, 31.2))
    # Ramped up over two turns, the helix lags by one: at the long axis the tracks are whole feeds.
    tracks = np.arange(28.0, 34.0, 0.1)
    tip = geometry.radius_mm(tracks)
    off = z_mm[:, None] - tracks
    near = np.abs(off) < 2
    left = np.where(near, tip + 2 - np.sqrt(np.where(near, 4 - off**2, 4)), np.inf).min(axis=1)
    np.testing.assert_allclose(proud_um, (left - geometry.radius_mm(z_mm)) * 1000, atol=0.03)


def test_summary_tells_the_scallop(table_of: TableOf) -> None:
    """Only with a nose; the path stands there, too."""
    words = (table_of(PART.stem), "--rpm", 900, "--feed", 2, "--set", "z_margin_nm=1000000")
    found = cut(*words).summary
    assert "scallop" not in found
    assert found["cut"]["path"] == "ring-helix"
    assert found["cut"]["planned_turns"] == 63
    scallop = cut(*words, "--nose-mm", 5).summary["scallop"]
    assert scallop["z_last_mm"] - scallop["z_first_mm"] == pytest.approx(8)
    assert 0 < scallop["peak_to_valley_min_um"] < scallop["peak_to_valley_max_um"] < 110
