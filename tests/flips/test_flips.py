# SPDX-License-Identifier: Apache-2.0
"""The figures that README.md tells are those recorded, and the judge sees what it is there for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from flips_campaign import Outcome
from flips_figures import HERE, recorded, told
from flips_image import EXCEPTION, NOTHING, RAN, TICK, Result, Strike
from flips_judge import ENABLE, FAULT, Limits, Verdict, judge
from flips_listed import Listed, by_kind, read_listed
from flips_plan import SHARES
from numpy.typing import NDArray

LIMITS = Limits(np.array([20e3, 5e3, 10e3]), np.array([750.0, 50.0, 50.0]), 600e3)
N_TICKS, STRUCK, U, X, Z = 400, 10, 0, 1, 2
Ticks = NDArray[np.void]


def _ticks() -> Ticks:
    ticks = np.zeros(N_TICKS, TICK)
    ticks["nm"][:, X] = 40_000_000
    ticks["nm"][:, Z] = -1000 * np.arange(N_TICKS)
    ticks["outputs"] = ENABLE
    return ticks


def _result(ticks: Ticks, end: int = RAN) -> Result:
    n = len(ticks)
    return Result(0, end, 0, 0, 0, True, n, n, 0, 0, ticks)


def _verdict(change: Callable[[Ticks], None]) -> Verdict:
    ticks = _ticks()
    change(ticks)
    return judge(_result(ticks), replace(_result(_ticks()), first=N_TICKS), LIMITS, STRUCK)


def _step(axis: int, nm: int, ticks: slice = slice(20, 21)) -> Callable[[Ticks], None]:
    def change(trace: Ticks) -> None:
        trace["nm"][ticks, axis] += nm

    return change


def _fault(at: int, change: Callable[[Ticks], None]) -> Callable[[Ticks], None]:
    def both(trace: Ticks) -> None:
        trace["outputs"][at:] |= FAULT
        change(trace)

    return both


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (_step(U, 300), "small"),
        (_step(U, 2_000), "limits"),  # no U can obey that
        (_step(X, 6_000), "limits"),
        (_fault(21, _step(U, 2_000)), "detected"),
        (_fault(30, _step(U, 2_000)), "limits"),  # seen too late
        (_fault(10, _step(U, 2_000)), "limits"),  # or the retract itself
    ],
)
def test_one_wrong_set_point_is_judged_by_limits_and_reaction(
    change: Callable[[Ticks], None], kind: str
) -> None:
    """Beyond the limits is wrong unless a fault comes within three ticks of it."""
    assert _verdict(change).kind == kind


@pytest.mark.parametrize(
    ("axis", "nm_per_tick", "kind"),
    [
        (U, 100, "course"),
        (U, -100, "out"),
        (X, -40, "course"),
        (X, 40, "out"),
        (Z, 1_000, "course"),
    ],
)
def test_slow_drift_is_wrong_where_it_leads_deeper(axis: int, nm_per_tick: int, kind: str) -> None:
    """A tool that leaves the work spoils nothing, one that goes deeper does."""

    def drift(trace: Ticks) -> None:
        steps = np.clip(np.arange(N_TICKS) - 20, 0, None)
        ramp = np.cumsum(np.minimum(40 * steps, abs(nm_per_tick)))  # begins within the acceleration
        trace["nm"][:, axis] += (np.sign(nm_per_tick) * ramp).astype(np.int32)

    assert _verdict(drift).kind == kind


def test_unstruck_run_and_ends_of_the_core_are_told_apart() -> None:
    """The same trace is no effect; one that ends with an exception was stopped."""
    golden = _result(_ticks())
    same = Result(0, RAN, 0, 0, 0, True, N_TICKS, N_TICKS, 0, N_TICKS, _ticks()[:0])
    assert judge(same, golden, LIMITS, STRUCK).kind == "none"
    ended = replace(same, end=EXCEPTION, n_ticks=15, first=15)
    assert judge(ended, replace(golden, ticks=_ticks()), LIMITS, STRUCK).kind == "stopped"


def _outcome(site: str, kind: str = "limits") -> Outcome:
    strike = Strike(0, 1, 2, NOTHING, 0, 0, "state")
    return Outcome(strike, site, Verdict(kind, "U speed", 100))


def test_listed_kind_covers_its_sites_up_to_its_share() -> None:
    """What is not listed is found, and so is a listed kind that has become frequent."""
    kind = Listed("guard", "state", "U", "known", 1.0, site=r"g_cam\.guard\..*")
    known, other = _outcome("g_cam.guard.u+1"), _outcome("g_cam.motion.state")
    many = [known] * 300
    kinds = by_kind([known, other], [*many, other], [kind])
    assert (kinds["guard"], kinds[""]) == ([known], [other])
    assert by_kind(many[:20], many, [kind])[""] == many[:20]


def test_readme_tells_the_recorded_figures() -> None:
    """Its tables are made of figures.json and listed.toml as they are."""
    readme = (HERE / "README.md").read_text("utf-8")
    for name, rows in told(recorded()).items():
        assert f"<!-- {name} -->\n{rows}<!-- end of {name} -->" in readme


def test_recorded_campaign_is_whole_and_found_nothing_that_is_not_listed() -> None:
    """Ten thousand flips in all strata."""
    flat = recorded()
    assert flat["count"] >= 10000
    assert flat["unlisted"] == 0
    strata = {kind.stratum for kind in read_listed()}
    assert strata <= set(SHARES)
