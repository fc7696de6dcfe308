"""A cut on the live lathe as the panel sees it: learning and the time that is left."""

from pathlib import Path

import numpy as np
import pytest

from camtools.link.lessons import Convergence
from camtools.link.status_text import cut_progress
from checks.patience import limit_s
from tests.tools.cases.live_cases import live_case


@pytest.mark.long
def test_a_cut_is_seen_as_it_is(tmp_path: Path) -> None:
    """Lessons fall, the time left comes true."""
    with live_case(tmp_path, "--machine", "real") as case:
        seen = Convergence()
        case.order("home", "ready")
        case.set(feed_nm=2_000_000, rehearse_turns=30)
        told: list[tuple[float, float, float]] = []
        ended: list[float] = []

        def look(_: object) -> None:
            seen.add(case.link.status.signals)
            now = cut_progress(case.link.status.state, case.link.status.signals)
            if case.link.status.state in ("rehearsing", "cutting", "disengaging"):
                assert now.left_s is not None and now.fraction is not None
                told.append((case.now_s, now.left_s, now.fraction))
            elif told and not ended and case.link.status.state == "ready":
                ended.append(case.now_s)

        case.link.on_row = look
        case.order("start", "rehearsing")
        case.until("cutting")
        case.until("ready")
        assert case.link.wait(lambda: bool(ended), limit_s())  # its row has more messages
    at_s, left_s, fraction = np.array(told).T
    end_s = ended[-1]
    whole_s = end_s - at_s[0]
    assert whole_s > 3
    # The approach between rehearsal and cut is not in what is told, and pages come every 0.25 s.
    is_cut = fraction > 0.5
    assert np.abs(at_s + left_s - end_s)[is_cut].max() < 0.4
    assert np.all(np.diff(fraction) >= -1e-9) and fraction[0] < 0.2 and fraction[-1] > 0.9
    turn, error_um = np.array(seen.lessons()).T
    assert np.all(np.diff(turn) > 0) and len(turn) >= 5
    assert error_um.min() < 0.2 * case.link.status.signals["learn_begin_error"]
