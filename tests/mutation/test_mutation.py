"""Each entry of explained.toml is about one line of the firmware."""

from itertools import pairwise

from tests.mutation.mutation import ROOT, explained


def test_each_explanation_is_of_one_line() -> None:
    """One that fits no line, or several, explains something else than was meant."""
    for file, after, was, becomes in explained():
        lines = [line.strip() for line in (ROOT / file).read_text("utf-8").splitlines()]
        found = [before for before, line in pairwise(lines) if line == was]
        assert (found.count(after) if after else len(found)) == 1, (file, was)
        assert was != becomes
