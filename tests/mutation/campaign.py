"""Draw mutants of the firmware, judge each by the tests, and tell which survived.

A mutant that the compiler refuses, or of which it makes the same code, is drawn anew: it can not
or need not be noticed. What survives is explained in explained.toml, or a test is missing. A run
that was interrupted goes on where it was, as long as the sources and the tests are the same.
"""

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from threading import Lock

from tests.mutation.account import (
    LEAST_PERCENT,
    MOST_DEAF_PERCENT,
    ROOT,
    figures_of,
    reasons,
    tell_survivors,
    why,
    write,
)
from tests.mutation.journal import Journal, Judged, Killers, digest_compiled, digest_of
from tests.mutation.mutants import Mutant, drawn, sources
from tests.mutation.pristine import Pristine
from tests.mutation.workshop import Workshop

_N_DEAF = 40  # mutants of the counter-check
_N_QUICK = 75


class Campaign:
    """Judges mutants of one stream until enough of them are valid.

    Parameters
    ----------
    stream : iterator of Mutant
        In the order of the draw.
    journal : Journal
        What it knows is not judged again.
    n_most : int
        Valid ones that are wanted.
    seconds : float
        After which no more is begun.
    """

    def __init__(
        self, stream: Iterator[Mutant], journal: Journal, n_most: int, seconds: float
    ) -> None:
        self._stream, self._journal, self._n_most = stream, journal, n_most
        self._end = time.monotonic() + seconds
        self._known = reasons()
        self._lock = Lock()
        self._found: dict[int, tuple[Mutant, Judged]] = {}
        self._places = count()

    def _n_valid(self) -> int:
        return sum(one.is_valid for _, one in self._found.values())

    def _next(self) -> tuple[int, Mutant] | None:
        with self._lock:
            while self._n_valid() < self._n_most and time.monotonic() < self._end:
                if (mutant := next(self._stream, None)) is None:
                    return None
                place = next(self._places)
                known = self._journal.judged.get((mutant.file, mutant.line, mutant.becomes))
                if known is None:
                    return place, mutant
                self._found[place] = mutant, known
            return None

    def _take(self, place: int, mutant: Mutant, verdict: str, seconds: float) -> None:
        one = Judged(*mutant, verdict, round(seconds, 1))
        with self._lock:
            self._journal.add(one)
            self._found[place] = mutant, one
            if one.is_valid:
                print(f"{self._n_valid():4} {one.told()}", flush=True)

    def work(self, shop: Workshop) -> None:
        """Judge in one workshop until nothing is left."""
        while (drawn_one := self._next()) is not None:
            place, mutant = drawn_one
            begin = time.monotonic()
            one = Judged(*mutant, "", 0.0)
            verdict = shop.judge(mutant, "all" if why(one, self._known) is None else "own")
            self._take(place, mutant, verdict, time.monotonic() - begin)

    def judged(self) -> list[tuple[Mutant, Judged]]:
        """Return mutants in the order of the draw, up to the last that was wanted."""
        made, n_valid = [], 0
        for _, (mutant, one) in sorted(self._found.items()):
            n_valid += one.is_valid
            made.append((mutant, one))
            if n_valid == self._n_most:
                break
        return made


def deaf_verdicts(campaign: Campaign, shop: Workshop) -> list[str]:
    """Return verdicts of a judge that hears no assertion, to see that those of the others count."""
    valid = [mutant for mutant, one in campaign.judged() if one.is_valid]
    return [shop.judge(mutant, "deaf") for mutant in valid[:_N_DEAF]]


def options_of(words: list[str]) -> argparse.Namespace:
    """Return what is asked for."""
    parser = argparse.ArgumentParser(prog="tests/mutation/run", description=__doc__)
    parser.add_argument("--count", type=int, default=320, help="valid mutants (default: 320)")
    parser.add_argument(
        "--seconds",
        type=float,
        default=math.inf,
        help="draw no more after so long (default: no end)",
    )
    parser.add_argument("--seed", type=int, default=29, help="of the draw (default: 29)")
    parser.add_argument("--jobs", type=int, default=2, help="workshops side by side (default: 2)")
    parser.add_argument("--files", nargs="*", default=[], help="draw from these files only")
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"judge by the module's own unit tests and {_N_QUICK} others only",
    )
    parser.add_argument(
        "--units",
        action="store_true",
        help="judge by all unit tests, without sanitizers and scenarios",
    )
    parser.add_argument("--record", action="store_true", help="write figures.json beside this")
    options = parser.parse_args(words)
    if options.record and (options.files or options.quick or options.units):
        parser.error("--record is for a sample of all files and all judges: leave out the others")
    return options


def main(words: list[str]) -> int:
    """Run the campaign; return 0 when enough was noticed."""
    options = options_of(words)
    folder, verify = ROOT / "build" / "mutation", ROOT / "build" / "verify"
    key = digest_of(ROOT, options.seed, options.files, options.quick, options.units)
    journal = Journal(verify / "mutation.jsonl", key, digest_compiled(ROOT))
    stream = drawn(ROOT, options.seed, options.files or sources(ROOT))
    is_short = options.quick or options.units
    presets = ("host",) if is_short else ("host", "host-asan")
    builds = [Pristine(ROOT, folder / "tree", preset) for preset in presets]
    builds[0].measure()
    if not is_short:
        builds[0].check_scenarios()
    killers = Killers(folder / "killers.jsonl")
    n_others = _N_QUICK if options.quick else None
    shops = [
        Workshop(ROOT, folder / str(i), builds, killers, n_others) for i in range(options.jobs)
    ]
    campaign = Campaign(stream, journal, options.count, options.seconds)
    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(campaign.work, shops))
    judged = [one for _, one in campaign.judged()]
    tell_survivors(judged)
    figures = figures_of(judged, options.seed, deaf_verdicts(campaign, shops[0]))
    text = json.dumps(figures, indent=1) + "\n"
    print(text, end="")
    (verify / "mutation.json").write_text(text, encoding="utf-8")
    if options.record:
        write(figures)
    is_heard = figures["deaf_percent"] < MOST_DEAF_PERCENT
    return 0 if is_heard and figures["percent"] >= LEAST_PERCENT else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
