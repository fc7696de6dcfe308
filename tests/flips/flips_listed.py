# SPDX-License-Identifier: Apache-2.0
"""Wrong motions that are known, with the reason why nothing prevents them: listed.toml."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from flips_campaign import Outcome
from scipy.stats import beta

HERE = Path(__file__).resolve().parent
CERTAINTY = 0.99


@dataclass(frozen=True)
class Listed:
    """A kind of wrong motion."""

    name: str
    stratum: str
    moves: str  # what moved how far, for people
    why: str
    most_percent: float  # of all flips in the stratum
    site: str = ".*"  # regular expression, for the whole site
    what: str = ".*"  # likewise
    most: int = 1 << 62  # of what is wrong

    def covers(self, outcome: Outcome) -> bool:
        """Return whether an outcome is of this kind."""
        verdict = outcome.verdict
        return (
            outcome.strike.stratum == self.stratum
            and verdict.most <= self.most
            and re.fullmatch(self.site, outcome.site) is not None
            and re.fullmatch(self.what, verdict.what) is not None
        )


def read_listed() -> list[Listed]:
    """Return what is listed."""
    text = (HERE / "listed.toml").read_text("utf-8")
    return [Listed(**one) for one in tomllib.loads(text)["wrong"]]


def least_percent(n: int, of: int) -> float:
    """Return the share that n of so many show at least, by Clopper and Pearson.

    >>> round(least_percent(10, 1000), 2), least_percent(0, 10)
    (0.41, 0.0)
    """
    return 100.0 * float(beta.ppf(1.0 - CERTAINTY, n, of - n + 1)) if n > 0 else 0.0


def by_kind(
    wrong: Sequence[Outcome], outcomes: Sequence[Outcome], listed: Sequence[Listed]
) -> dict[str, list[Outcome]]:
    """Return the wrong ones of each kind, the first that covers them; of "" those that none covers.

    A kind that is more frequent than it may be covers nothing.
    """
    sizes = Counter(o.strike.stratum for o in outcomes)
    found, left = {}, list(wrong)
    for kind in listed:
        covered = [o for o in left if kind.covers(o)]
        is_rare = least_percent(len(covered), max(sizes[kind.stratum], 1)) <= kind.most_percent
        found[kind.name] = covered if is_rare else []
        left = [o for o in left if not is_rare or not kind.covers(o)]
    return {**found, "": left}
