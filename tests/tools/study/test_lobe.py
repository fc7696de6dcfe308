# SPDX-License-Identifier: Apache-2.0
"""The study of cams: worked numbers of MATHS.md (30), (31), (33) .. (38), figures, refusals."""

import csv
import json
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from camtools.cli.analyse import lobe_products, main
from camtools.lobe.part import LobePart
from camtools.pipeline.load import load, parse
from camtools.study.lobe import LobeWishes
from tests.tools.cases.lobe_tables import DISC, POLY345, POLY345_WHEEL
from tests.tools.cases.part_cases import ROOT

PARTS = ROOT / "tools" / "parts"


def products(name: str, wishes: LobeWishes | None = None) -> tuple[str, dict[str, bytes]]:
    """Return what the command makes of a part of the repository."""
    part = load(PARTS / f"{name}.toml").part
    assert isinstance(part, LobePart)
    return lobe_products(part, wishes or LobeWishes(step_deg=5.0), with_pictures=False)


def rows(files: dict[str, bytes], number: int = 0) -> dict[float, dict[str, float]]:
    """Return the rows of a lobe by the direction of the follower."""
    text = files[f"lobe_{number}.csv"].decode()
    found = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(StringIO(text))]
    return {row["theta_deg"]: row for row in found}


def test_disc_is_the_worked_table() -> None:
    """Lift, wheel, cam angle, contact and speed N_C of the eccentric disc, digit by digit."""
    found = rows(products("cam-disc")[1])
    for line in DISC:
        theta, lift, _, s, phi, alpha, radius, travel, speed = map(float, line.split())
        row = found[theta]
        assert row["lift_mm"] == pytest.approx(lift, abs=6e-9)
        assert row["s_mm"] == pytest.approx(s, abs=6e-9)
        assert row["phi_deg"] == pytest.approx(phi, abs=1e-6)
        assert row["contact_angle_deg"] == pytest.approx(alpha, abs=1e-6)
        assert row["contact_radius_mm"] == pytest.approx(radius, abs=6e-9)
        assert row["ds_dphi_mm_rad"] == pytest.approx(travel, abs=1e-6)
        assert row["n_c_rpm"] == pytest.approx(speed, abs=1e-6)
        assert row["curvature_radius_mm"] == pytest.approx(25, abs=1e-6)


def test_lobe_is_the_worked_table() -> None:
    """X = H and swing of the turned lobe; S, phi, ds/dphi and N_C of the ground one."""
    turned, ground = rows(products("cam-345")[1]), rows(products("cam-345-ground")[1])
    for line in POLY345:
        theta, lift, swing, radius, alpha = map(float, line.split()[:5])
        row = turned[theta]
        assert row["x_mm"] == pytest.approx(lift, abs=6e-8)
        assert row["swing_deg"] == pytest.approx(swing, abs=1e-6)
        assert row["contact_radius_mm"] == pytest.approx(radius, abs=6e-8)
        assert row["contact_angle_deg"] == pytest.approx(alpha, abs=1e-6)
    for line in POLY345_WHEEL:
        theta, s, phi, travel, speed = map(float, line.split())
        row = ground[theta]
        assert row["s_mm"] == pytest.approx(s, abs=6e-8)
        assert row["phi_deg"] == pytest.approx(phi, abs=1e-6)
        assert row["ds_dphi_mm_rad"] == pytest.approx(travel, abs=1e-6)
        assert row["n_c_rpm"] == pytest.approx(speed, abs=1e-6)


def test_flat_face_touches_where_its_support_says() -> None:
    """Of a flat face the contact is (s, s') in the frame of its line, s the base circle plus H."""
    text = (PARTS / "cam-345.toml").read_text().replace("[cam]", '[cam]\nfollower = "flat"')
    text = text.replace("base_radius_mm = 20", "base_radius_mm = 40")
    part = parse(text.encode(), "flat.toml").part
    assert isinstance(part, LobePart)
    found = rows(lobe_products(part, LobeWishes(step_deg=5.0), with_pictures=False)[1])
    u = 1 - 30 / 70
    s = 40 + 8 * u**3 * (10 - 15 * u + 6 * u**2)
    s1 = -8 / np.radians(70) * 30 * u**2 * (1 - u) ** 2
    assert found[30]["contact_radius_mm"] == pytest.approx(np.hypot(s, s1), abs=1e-8)
    contact_deg = 30 + np.degrees(np.arctan2(s1, s))
    assert found[30]["contact_angle_deg"] == pytest.approx(contact_deg, abs=1e-6)
    centre = np.hypot(s + 10, s1)
    assert found[30]["x_mm"] == pytest.approx(centre - 50, abs=1e-8)
    seconds = (found[30]["phi_deg"] + 180) / 360
    assert found[30]["t_s"] == pytest.approx(seconds, abs=1e-8)


def test_speeds_are_derivatives_over_time() -> None:
    """Speed and acceleration of X and of the swing are differences of x(t) and swing(t)."""
    found = list(rows(products("cam-345", LobeWishes(step_deg=0.1, rpm=30.0))[1]).values())
    t = np.array([row["t_s"] for row in found])
    assert t[-1] == pytest.approx(2.0)
    for value, speed, bend in (
        ("x_mm", "x_speed_mm_s", "x_acceleration_mm_s2"),
        ("swing_deg", "swing_speed_deg_s", "swing_acceleration_deg_s2"),
    ):
        one, two, three = (np.array([row[key] for row in found]) for key in (value, speed, bend))
        flank = slice(1200, 1780)  # below the nose, where no higher derivative of the law jumps
        measured = np.gradient(one, t)
        assert np.abs(measured - two)[flank].max() < 2e-3 * np.abs(two).max()
        assert np.abs(np.gradient(two, t) - three)[flank].max() < 2e-2 * np.abs(three).max()


def test_figures_and_words() -> None:
    """The extremes of the worked example, and what a user reads."""
    told, files = products("cam-345-ground")
    [lobe] = json.loads(files["analysis.json"])["lobes"]
    assert lobe["n_c_rpm"] == pytest.approx([6.7664, 104.2400], abs=1e-3)
    assert lobe["least_convex_radius_mm"] == pytest.approx(10.679909, abs=1e-5)
    assert lobe["largest_pressure_angle_deg"] == pytest.approx(19.967381, abs=1e-5)
    assert "the cam turns at 6.77 .. 104.24 r/min, before any limit of the spindle" in told
    assert sorted(products("camshaft")[1]) == [
        "analysis.json",
        "lobe_0.csv",
        "lobe_1.csv",
        "lobe_2.csv",
    ]


def test_command_writes_tables_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both pictures of three lobes, the tables, the words."""
    assert main([str(PARTS / "camshaft.toml"), "-o", str(tmp_path)]) == 0
    assert {"lobe_motion.png", "lobe_contact.png"} <= {path.name for path in tmp_path.iterdir()}
    assert "lobe 2, height 10 .. 13 mm: lift 6 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--height", "3"], "--height 3.0: has no meaning for a cam; leave it out"),
        (["--parts", "30"], "--parts 30: has no meaning for a cam"),
        (["--nose-mm", "2"], "--nose-mm 2.0: has no meaning for a cam"),
        (["--step-deg", "7"], "--step-deg 7.0: does not divide 90 degrees"),
        (["--step-deg", "nan"], "--step-deg nan: out of range"),
        (["--rpm", "0"], "--rpm 0.0: out of range; give 1 .. 60000"),
    ],
)
def test_wishes_that_a_cam_does_not_take(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line with the option, status 2, nothing written."""
    assert main([str(PARTS / "cam-345.toml"), "-o", str(tmp_path / "out"), *words]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out").exists()
