"""Encoder counts in step with the ticks, and the orientation of a part: MATHS.md (231)."""

from pathlib import Path

import numpy as np
import pytest

from camtools.sim.simulate import Result
from tests.tools.cases.camsim_cases import ROOT, plain
from tests.tools.cases.camsim_cases import cut as camsim_cut
from tests.tools.cases.part_cases import TableOf

MACHINES = ROOT / "tests" / "learn" / "machines"


def cut(table: Path, machine: str, rpm: float, *words: str) -> Result:
    """Return a cut on a machine."""
    options = ("--machine", MACHINES / f"{machine}.toml", "--rpm", rpm, "--tolerance-um", 9)
    return camsim_cut(table, *options, *words)


def test_the_better_speed_is_better(table_of: TableOf) -> None:
    """It is reported where edges have no time stamps, and at least halves the error."""
    bad = cut(table_of("oval30"), "coarse", 3000).summary
    assert bad["better_rpm"] == 2990
    good = cut(table_of("oval30"), "coarse", bad["better_rpm"]).summary
    assert "better_rpm" not in good
    assert good["form_error_um"]["max"] < bad["form_error_um"]["max"] / 2


TICK_HZ, OBSERVER_HZ, DRIVE_HZ = 20_000, 100.0, 300.0


def missed_counts(counts: int, rpm: float) -> float:
    """Return the rms [counts] that observer (52) and drive make of counts, at a ripple of 0.2 %."""
    w, t = 2 * np.pi * OBSERVER_HZ / TICK_HZ, np.arange(60_000) / TICK_HZ
    true = rpm / 60 * t + 0.002 / (4 * np.pi) * np.sin(4 * np.pi * rpm / 60 * t) + 0.3 / counts
    off = (np.floor(true * counts) + 0.5) / counts - true
    place = speed = u = u_speed = 0.0
    found = []
    drive = 2 * np.pi * DRIVE_HZ / TICK_HZ
    for one in off:
        ahead = place + speed
        place = ahead + 2 * w * (one - ahead)
        speed += w * w * (one - ahead)
        u_speed += drive * (drive * (place - u) - 1.4 * u_speed)
        u += u_speed
        found.append(u)
    return counts * float(np.std(found[6000:]))


@pytest.mark.parametrize(
    ("counts", "rpm", "is_named"),
    [
        (4096, 600, False),
        (4096, 640, False),
        (4096, 591, True),
        (4096, 2931, True),
        (10_000, 3012, False),
        (10_000, 121, True),
        (10_000, 2996, True),
    ],
)
def test_named_speeds_are_those_of_quantised_counts(
    table_of: TableOf, counts: int, rpm: float, is_named: bool
) -> None:
    """A named speed leaves more than twice as much as the proposed one, others leave as little."""
    coarse = (MACHINES / "coarse.toml").read_text()
    machine = coarse.replace("counts_per_turn = 10000", f"counts_per_turn = {counts}")
    words = ("--rpm", rpm, "--turns-limit", 3)
    found = camsim_cut(table_of("oval30"), *words, machine=machine, status=None)
    better_rpm = found.summary.get("better_rpm")
    assert (better_rpm is not None) is is_named
    assert missed_counts(counts, better_rpm or rpm) < 0.02
    if better_rpm is not None:
        assert missed_counts(counts, rpm) > 2 * missed_counts(counts, better_rpm)


def test_stamped_edges_need_no_other_speed(table_of: TableOf) -> None:
    """Their counts have no steps."""
    summary = cut(table_of("oval30"), "stamps", 3000, "--turns-limit", "3").summary
    assert "better_rpm" not in summary


def test_a_lead_that_is_wrong_turns_the_part(table_of: TableOf) -> None:
    """10 us more at 3000 r/min turn it by 3142 urad, which is nearly all of the error."""
    words = ("--turns-limit", "20", "--set", "learn_harmonics=0", "--set", "rehearse_turns=0")
    cuts = [
        cut(table_of("oval30"), "known", 3000, *words, "--set", f"lead_ns={lead_ns}")
        for lead_ns in (100_000, 110_000)
    ]
    found = [one.summary["form_error_um"] for one in cuts]
    by_urad = found[1]["turned_urad"] - found[0]["turned_urad"]
    assert abs(by_urad) == pytest.approx(2 * 3.14159265 * 50 * 10, rel=0.02)
    assert found[1]["rms_not_turned"] < 0.2 < found[1]["rms"]
    turn, _, radius_mm, error_nm = plain(cuts[1].surface)[:4]
    angle = 2 * np.pi * turn  # fit the section's harmonics, and turn it back
    order = np.arange(9)
    waves = np.hstack([np.cos(np.outer(angle, order)), np.sin(np.outer(angle, order))])
    fit = np.linalg.lstsq(waves, radius_mm - 1e-6 * error_nm, rcond=None)[0]
    slope = np.hstack([-order * waves[:, 9:], order * waves[:, :9]]) @ fit
    left_um = 1e-3 * error_nm - 1e-3 * found[1]["turned_urad"] * slope
    assert found[1]["max_not_turned"] == pytest.approx(np.abs(left_um).max(), rel=0.02)
    assert found[1]["max_not_turned"] < found[1]["max"] / 5
