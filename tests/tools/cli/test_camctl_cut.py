"""What changes in the cut, with tools/camctl, against the firmware with an ideal machine."""

import re
from pathlib import Path

from tests.tools.cases.camctl_bench import Bench, Refusal


def test_feed_is_overridden_and_held(bench: Bench, refusal: Refusal, tmp_path: Path) -> None:
    """The state shows the hold; the part ends whole and is counted; the speed stays."""
    bench.do("home")
    assert bench.do("parts", "7") == "parts = 7\n"
    assert bench.do("override", "feed", "20") == "override feed = 20 %\n"
    with bench.cutting():
        assert bench.do("hold").startswith("hold: ")
        held = [bench.do("status") for _ in range(20)]
        assert any("holding" in text for text in held)
        line = refusal(bench, 1, "speed 1000")
        assert "spindle_mrpm cannot change in this state; only phase, amplitude, trim" in line
        assert bench.do("phase", "5") == "phase = 5 deg\n"
        assert bench.do("resume").startswith("resume: ")
        assert bench.do("override", "feed", "150") == "override feed = 150 %\n"
        assert bench.do("override", "spindle", "90") == "override spindle = 90 %\n"
        assert bench.do("override", "spindle") == "override spindle = 90 %\n"
        bench.do("record", tmp_path / "cut.csv", "--cut")
    assert not bench.ended
    assert bench.do("parts") == "parts = 8\n"


def test_a_cut_that_is_stopped_elsewhere_fails(bench: Bench) -> None:
    """The command start gives the reason and how far the part came; nothing is counted."""
    bench.do("home")
    bench.do("override", "feed", "5")
    with bench.cutting("cutting"):
        assert bench.do("stop").startswith("stop: ")
    [ended] = bench.ended
    assert re.fullmatch(
        r"start: the cut was stopped at \d+ %, \d+ of \d+ turns, so the part is not complete; "
        "state ready",
        str(ended),
    )
    assert bench.do("parts") == "parts = 0\n"


def test_trim_is_of_diameter_or_radius(bench: Bench, refusal: Refusal) -> None:
    """A diameter counts twice; beyond the limit the refusal has the numbers."""
    assert bench.do("trim", "diameter", "-0.012") == "trim: diameter -0.012 mm, radius -0.006 mm\n"
    assert bench.do("get", "x_trim_nm") == "x_trim_nm = -6000\n"
    assert bench.do("trim", "radius", "0.2") == "trim: diameter 0.4 mm, radius 0.2 mm\n"
    assert "needs 0.25 mm, limit 0.2 mm (x_trim_limit_nm)" in refusal(bench, 1, "trim radius 0.25")
    assert bench.do("trim", "radius") == "trim: diameter 0.4 mm, radius 0.2 mm\n"


def test_what_is_out_of_place_is_refused(bench: Bench, refusal: Refusal) -> None:
    """No hold without a cut, no resume without a hold, no override out of range."""
    for state in ("off", "ready"):
        refused = f"refused: state {state}; nothing is being cut"
        assert refusal(bench, 1, "hold").endswith(f"hold: {refused}; start first")
        assert refusal(bench, 1, "resume").endswith(f"resume: {refused}, so nothing is on hold")
        assert refusal(bench, 1, "stop").endswith(f"stop: {refused}")
        bench.do("home")
    assert "150" in refusal(bench, 2, "override feed 151")
    assert "50" in refusal(bench, 2, "override spindle 49")
    assert "out of range" in refusal(bench, 1, "set feed_override_ppm 1500001")
