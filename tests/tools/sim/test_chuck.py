"""Parts that a chuck springs: what is gauged of them against the Fourier series of a ring."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.quantities import Floats
from tests.tools.cases.camsim_cases import cut, form_um, plain
from tests.tools.cases.cut_cases import written_skirt
from tests.tools.cases.part_cases import oval_text
from tests.tools.measured.test_measured import Rounds

ROUND = oval_text("oval", (10, 80), [0, 0], "feed_mm = 0.5\ndirection = -1")
HEIGHTS_MM = (3, 5, 7)


def sprung_um(deg: Floats, jaws: int, jaw_deg: float) -> Floats:
    """Return the spring of a ring for 1 um peak to valley, above 0 where it stands out.

    A force that acts at single points is the sum of all cos(m phi), m a multiple of the jaws; the
    ring without change of its length, EI (w'''''  + 2 w''' + w') = R^4 q', answers each by
    1 / (m^2 - 1)^2: Timoshenko, "Strength of Materials", part II, or Love's "Theory", art. 290.
    """
    m = jaws * np.arange(1, 2000)
    share = 1.0 / (m**2 - 1.0) ** 2
    w = np.cos(np.radians(np.subtract.outer(deg, jaw_deg))[..., None] * m) @ share
    return np.asarray(w / (share * (1 - (-1.0) ** np.arange(1, 2000))).sum())


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the table of a round part, its report beside it."""
    return written_skirt(ROUND, tmp_path_factory.mktemp("cylinder"))


def sections_um(table: Path, chuck: str, *words: str) -> tuple[Floats, Floats, float]:
    """Return angles [deg], deviations at HEIGHTS_MM and the largest form error [um]."""
    heights = ",".join(map(str, HEIGHTS_MM))
    options = ("--sections", "s.csv", "--sections-mm", heights, "--tolerance-um", "99", *words)
    found = cut(table, *options, tables=("sections",), machine=f"[chuck]\n{chuck}\n")
    section, turn, _, _, nm = plain(found.sections)
    rows = [nm[section == i + 1] / 1000 for i in range(len(HEIGHTS_MM))]
    return 360 * turn[section == 1], np.array(rows), form_um(found)


@pytest.mark.parametrize(
    ("jaws", "jaw_deg", "spring_um", "more", "shares"),
    [
        (3, 0, 30, "", (1, 1, 1)),
        (3, 17, -30, "", (1, 1, 1)),
        (2, -40, 8, "jaw_height_mm = 4", (0.75, 1, 1)),
        (4, 100, 12, "jaw_height_mm = 2\nround_height_mm = 6", (0.75, 0.25, 0)),
        (12, 5, 4, "jaw_height_mm = 20\nround_height_mm = -5", (8 / 25, 10 / 25, 12 / 25)),
    ],
)
def test_spring_is_gauged(
    cylinder: Path, jaws: int, jaw_deg: float, spring_um: float, more: str, shares: tuple[float]
) -> None:
    """Metal is left at jaws that grip from outside, and the mean diameter is the drawing's."""
    keys = f"jaws = {jaws}\njaw_deg = {jaw_deg}\nspring_um = {spring_um}\n{more}"
    deg, rows_um, form_um = sections_um(cylinder, keys)
    ring_um = sprung_um(deg, jaws, jaw_deg)
    for row_um, share in zip(rows_um, shares, strict=True):
        assert row_um == pytest.approx(spring_um * share * ring_um, abs=0.02)
    if not more:
        assert form_um == pytest.approx(abs(spring_um * ring_um).max(), abs=0.02)


def test_jaws_stay_where_the_phase_turns_the_part(cylinder: Path) -> None:
    """A part that is turned by 25 degrees on the spindle has its lobes 25 degrees earlier."""
    deg, rows_um, _ = sections_um(cylinder, "spring_um = 9", "--set", "phase_udeg=25000000")
    assert rows_um[0] == pytest.approx(9 * sprung_um(deg, 3, -25), abs=0.02)


@pytest.mark.long
def test_two_rounds_cut_the_spring_out(tmp_path: Path) -> None:
    """A coarse cut: three lobes of 30 um are left at first, 1 um at most after two rounds."""
    keys = "jaw_deg = 20\nspring_um = 30\njaw_height_mm = 10\nround_height_mm = -5"
    rounds = Rounds(tmp_path, ROUND, f"[chuck]\n{keys}\n")
    rounds.words.remove("--no-learning")
    rounds.play(3)
    largest_um = [rounds.summary_um(number) for number in range(3)]
    assert 14 < largest_um[0] < 17  # a ring's lobes are 53 % of the spring high, 47 % deep
    assert largest_um[1] < 0.4 * largest_um[0]
    assert largest_um[2] < 1.0
