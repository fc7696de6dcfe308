"""The result of a campaign: which survivors are explained, and the figures."""

import json
import tomllib
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from tests.mutation.journal import Judged

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LEAST_PERCENT = 97.0
MOST_DEAF_PERCENT = 50.0
Figures = dict[str, int | float]


class Reason(NamedTuple):
    """Why a mutant need not be noticed. All texts are without the spaces at their ends."""

    file: str
    behind: str  # the line before it
    was: str
    becomes: str
    why: str

    def lines(self, root: Path = ROOT) -> list[int]:
        """Return the lines of the file that are meant, from 1."""
        path = root / self.file
        text = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        return [
            n
            for n, (behind, line) in enumerate(pairwise(text), start=2)
            if (behind.strip(), line.strip()) == (self.behind, self.was)
        ]

    def is_of(self, one: Judged, root: Path = ROOT) -> bool:
        """Return whether it is meant for a mutant."""
        same = (self.file, self.becomes) == (one.file, one.becomes.strip())
        return same and one.line in self.lines(root)


def reasons() -> list[Reason]:
    """Return those of explained.toml."""
    text = (HERE / "explained.toml").read_text(encoding="utf-8")
    return [Reason(**entry) for entry in tomllib.loads(text).get("mutant", [])]


def why(one: Judged, known: Sequence[Reason]) -> str | None:
    """Return the reason why a mutant need not be noticed."""
    return next((reason.why for reason in known if reason.is_of(one)), None)


def percent(part: int, whole: int) -> float:
    """Return a share in percent; of nothing it is none."""
    return round(100 * part / whole, 2) if whole else 0.0


def figures_of(judged: Sequence[Judged], seed: int, deaf: Sequence[str]) -> Figures:
    """Return the figures of a campaign.

    Parameters
    ----------
    judged : sequence of Judged
        All that were drawn.
    seed : int
        Of the draw.
    deaf : sequence of str
        The verdicts of the counter-check, in which no assertion was heard.
    """
    valid = [one for one in judged if one.is_valid]
    survived = [one for one in valid if one.verdict == "survived"]
    known = reasons()
    explained = sum(why(one, known) is not None for one in survived)
    killed = len(valid) - len(survived)
    return {
        "seed": seed,
        "count": len(valid),
        "killed": killed,
        "explained": explained,
        "survived": len(survived) - explained,
        "percent": percent(killed + explained, len(valid)),
        "refused_by_compiler": sum(one.verdict == "invalid" for one in judged),
        "same_code": sum(one.verdict == "same code" for one in judged),
        "deaf_count": len(deaf),
        "deaf_percent": percent(sum(verdict != "survived" for verdict in deaf), len(deaf)),
    }


def tell_survivors(judged: Sequence[Judged]) -> None:
    """Print what survived, and why it may."""
    known = reasons()
    for one in sorted(one for one in judged if one.verdict == "survived"):
        print(f"{one.told()}\n    {why(one, known) or 'NOT EXPLAINED: a test is missing'}")


def write(figures: Figures) -> None:
    """Write figures.json."""
    (HERE / "figures.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
