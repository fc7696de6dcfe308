"""Numbers, parameters and learning as the operator's page shows them."""

import re

from hypothesis import given
from hypothesis import strategies as st

from camtools.link.kept_values import INFOS
from camtools.link.messages import DATABASE, NAMES
from camtools.panel.views import wording
from camtools.panel.views.convergence_chart import MOST_POINTS, points_of, words
from camtools.panel.views.parameter_rows import judged, rows, unit_of
from camtools.panel.views.wording import Field, clock, plain, share_of

FIELDS = [one for one in vars(wording).values() if isinstance(one, Field)]
DEFAULTS = {name: info.default for name, info in INFOS.items()}


@given(st.floats(-1e6, 1e6), st.integers(0, 4))
def test_a_sign_never_stands_before_zeros(value: float, decimals: int) -> None:
    """Numbers of one magnitude are equally wide, whatever their sign."""
    text = plain(value, decimals, "+")
    assert len(text) == len(plain(-value, decimals, "+"))
    assert not re.fullmatch(r"\N{MINUS SIGN}[0.]+", text)
    assert not re.fullmatch(r"\N{MINUS SIGN}[0.]+", plain(value, decimals))


def test_what_is_not_known_is_no_zero() -> None:
    """A dash, for every number of the page."""
    assert len(FIELDS) >= 10
    for one in FIELDS:
        assert one.text({}) == wording.NOTHING
    assert clock(None) == clock(float("inf")) == plain(float("nan"), 2) == wording.NOTHING


def test_every_number_is_a_signal_of_the_status_with_a_unit() -> None:
    """The unit is that of the DBC, times the factor."""
    signals = {s.name: s for m in DATABASE.messages for s in m.signals}
    known = {("mm", 1.0): "mm", ("mm", 1e3): "µm", ("mm", 2.0): "mm"}
    for one in FIELDS:
        unit = signals[one.signal].unit
        assert one.unit and one.label
        assert known.get((str(unit), one.factor), one.unit) == one.unit


def test_x_is_marked_as_radius_and_as_diameter() -> None:
    """Nobody takes one for the other."""
    at = {"x": 40.0}
    assert wording.X_RADIUS.text(at) == "40.0000" and wording.X_DIAMETER.text(at) == "80.0000"
    assert "radius" in wording.X_RADIUS.label and "diameter" in wording.X_DIAMETER.label


def test_every_parameter_has_a_row_with_meaning_and_range() -> None:
    """In the order of the controller; what ends in a unit tells it."""
    told = rows(DEFAULTS)
    assert [row["name"] for row in told] == list(NAMES["parameter"].values())
    assert all(row["meaning"] and row["is_default"] for row in told)
    without = {name for name in DEFAULTS if not unit_of(name)}
    assert not {name for name in without if re.search(r"_(nm|ns|us|ms|ppm|mrpm|udeg|mdeg)$", name)}
    assert unit_of("x_trim_rate_nm_per_s") == "nm/s" and unit_of("k2_us2") == "us2"


def test_a_value_is_judged_before_it_is_sent() -> None:
    """Whole numbers within the range; spaces between digits are read."""
    assert judged("lead_ns", " 120 000 ") == 120000
    for text in ("", "x", "1.5", "1e5", "0x10"):
        assert judged("lead_ns", text) == "give a whole number"
    assert judged("lead_ns", "-1") == "out of range; give 0 .. 20000000"


def test_the_course_of_learning_stays_small_and_keeps_its_newest() -> None:
    """However long it learns."""
    n = 5 * MOST_POINTS + 1
    points = points_of([(turn, 1.0) for turn in range(1, n + 1)])
    assert len(points) <= MOST_POINTS + 1 and points[-1] == [n, 1.0]
    assert points_of([(1, 0.0)]) == [] and "nothing learned yet" in words({})


def test_how_far_a_download_is() -> None:
    """Never more than all of it."""
    assert share_of("download, 100 %") == 1.0 and share_of("download, 250 %") == 1.0
    assert share_of("home x") == 0.0
