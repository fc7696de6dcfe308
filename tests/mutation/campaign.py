"""Draw mutants of the firmware, judge each by the tests, and tell which survived.

A mutant that the compiler refuses, or of which it makes the same code, is drawn anew: it can not
or need not be noticed. What survives is explained in explained.toml, or a test is missing.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

from mutants import Mutant, drawn, sources
from pristine import Pristine
from workshop import Workshop

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LEAST_PERCENT = 97.0


def explained() -> dict[tuple[str, str, str], str]:
    """Return why mutants need not be noticed, by file, line and changed line."""
    text = (HERE / "explained.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(text).get("mutant", [])
    return {(one["file"], one["was"], one["becomes"]): str(one["why"]) for one in entries}


class Campaign:
    """Judges mutants of one stream until enough of them are valid."""

    def __init__(self, stream: Iterator[Mutant], count: int, seconds: float) -> None:
        self._stream, self._left = stream, count
        self._end = time.monotonic() + seconds
        self._lock = Lock()
        self.found: list[tuple[Mutant, str]] = []
        self.passed_over: Counter[str] = Counter()

    def _next(self) -> Mutant | None:
        with self._lock:
            is_over = self._left <= 0 or time.monotonic() > self._end
            return None if is_over else next(self._stream, None)

    def _take(self, mutant: Mutant, verdict: str) -> None:
        with self._lock:
            if verdict in ("invalid", "same code"):
                self.passed_over[verdict] += 1
                return
            self._left -= 1
            self.found.append((mutant, verdict))
            print(f"{len(self.found):4} {verdict:40} {mutant.told()}", flush=True)

    def work(self, shop: Workshop) -> None:
        """Judge in one workshop until nothing is left."""
        while (mutant := self._next()) is not None:
            self._take(mutant, shop.judge(mutant))


def figures_of(campaign: Campaign, seed: int) -> dict[str, int | float]:
    """Return the figures, and print what survived."""
    reasons = explained()
    survived = [one for one, verdict in campaign.found if verdict == "survived"]
    open_ones = []
    for one in sorted(survived):
        why = reasons.get((one.file, one.was.strip(), one.becomes.strip()))
        print(f"survived: {one.told()}\n    {why or 'NOT EXPLAINED: a test is missing'}")
        if why is None:
            open_ones.append(one)
    n = len(campaign.found)
    noticed = n - len(open_ones)
    return {
        "seed": seed,
        "mutants": n,
        "killed": n - len(survived),
        "explained": len(survived) - len(open_ones),
        "open": len(open_ones),
        "killed_or_explained_percent": round(100 * noticed / n, 2) if n else 0.0,
        "refused_by_compiler": campaign.passed_over["invalid"],
        "same_code": campaign.passed_over["same code"],
    }


def main() -> int:
    """Run the campaign; return 0 when enough was noticed."""
    parser = argparse.ArgumentParser(prog="tests/mutation/run", description=__doc__)
    parser.add_argument("--count", type=int, default=320, help="valid mutants (default: 320)")
    parser.add_argument(
        "--seconds",
        type=float,
        default=math.inf,
        help="draw no more after so long (default: no end)",
    )
    parser.add_argument("--seed", type=int, default=18, help="of the draw (default: 18)")
    parser.add_argument("--jobs", type=int, default=2, help="workshops side by side (default: 2)")
    parser.add_argument("--files", nargs="*", default=[], help="draw from these files only")
    parser.add_argument("--quick", action="store_true", help="judge by unit tests only")
    parser.add_argument("--record", action="store_true", help="write figures.json beside this")
    options = parser.parse_args()
    if options.record and options.files:
        parser.error("--record is for a sample of all files: leave out --files")
    folder = ROOT / "build" / "mutation"
    stream = drawn(ROOT, options.seed, options.files or sources(ROOT))
    with ThreadPoolExecutor(options.jobs) as pool:
        presets = ("host",) if options.quick else ("host", "host-asan")
        builds = [Pristine(ROOT, folder / "tree", preset) for preset in presets]
        builds[0].measure()
        shops = [Workshop(ROOT, folder / str(i), builds) for i in range(options.jobs)]
        campaign = Campaign(stream, options.count, options.seconds)
        list(pool.map(campaign.work, shops))
    figures = figures_of(campaign, options.seed) | {"unit_tests_only": int(options.quick)}
    text = json.dumps(figures, indent=1) + "\n"
    print(text, end="")
    (ROOT / "build" / "verify").mkdir(parents=True, exist_ok=True)
    (ROOT / "build" / "verify" / "mutation.json").write_text(text, encoding="utf-8")
    if options.record:
        (HERE / "figures.json").write_text(text, encoding="utf-8")
    return 0 if figures["killed_or_explained_percent"] >= LEAST_PERCENT else 1


if __name__ == "__main__":
    sys.exit(main())
