"""Draw mutants of the firmware, judge each by the tests, and name those that survive.

A mutant that does not compile, or of which the compiler makes the same code, is replaced by the
next of the draw. A survivor has its reason in explained.toml, or a test is missing. A run that was
interrupted continues as long as the tree is the same.
"""

import argparse
import hashlib
import json
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

from tests.mutation.mutants import Mutant, drawn, sources
from tests.mutation.shop import INVALID, Shop, tracked

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LEAST_PERCENT = 97.0
JUDGED = ("firmware/", "hal/", "host_sim/", "tests/unit/", "tests/scenarios/", "tests/mutation/")


def explained() -> set[tuple[str, ...]]:
    """Return file, line before or "", line and changed line of each mutant that no test notices."""
    entries = tomllib.loads((HERE / "explained.toml").read_text("utf-8"))["mutant"]
    return {
        tuple(one.get(key, "") for key in ("file", "after", "was", "becomes")) for one in entries
    }


class Verdicts:
    """The verdicts of a draw, kept in a file for a run that continues."""

    def __init__(self, tree: Path, stream: Iterator[Mutant], key: str, path: Path) -> None:
        self._tree, self._stream, self._path, self._lock = tree, stream, path, Lock()
        self._explained = explained()
        self.judged: list[tuple[Mutant, str]] = []  # "" until the verdict
        digest = hashlib.blake2b(key.encode())
        for name in tracked(tree):
            if name.startswith(JUDGED):
                digest.update(name.encode() + (tree / name).read_bytes())
        lines = path.read_text("utf-8").splitlines() if path.exists() else []
        is_same = lines[:1] == [digest.hexdigest()]
        self._known: dict[str, str] = dict(map(json.loads, lines[1:])) if is_same else {}
        if not is_same:
            path.write_text(digest.hexdigest() + "\n", "utf-8")

    def valid(self) -> list[int]:
        """Return the positions of mutants that count."""
        return [i for i, (_, verdict) in enumerate(self.judged) if verdict not in (*INVALID, "")]

    def _is_explained(self, mutant: Mutant) -> bool:
        lines = ["", *(self._tree / mutant.file).read_text("utf-8").splitlines()]
        before, was, becomes = (
            text.strip() for text in (lines[mutant.line - 1], mutant.was, mutant.becomes)
        )
        return any((mutant.file, one, was, becomes) in self._explained for one in ("", before))

    def fill(self, shop: Shop, n_wanted: int) -> None:
        """Judge mutants in a shop until enough count."""
        while True:
            with self._lock:
                mutant = next(self._stream, None) if len(self.valid()) < n_wanted else None
                if mutant is None:
                    return
                position = len(self.judged)
                self.judged.append((mutant, ""))
            verdict = "explained" if self._is_explained(mutant) else self._known.get(str(mutant))
            line = (
                "" if verdict else json.dumps([str(mutant), verdict := shop.judge(mutant)]) + "\n"
            )
            with self._lock, self._path.open("a", encoding="utf-8") as file:
                file.write(line)
                self.judged[position] = mutant, str(verdict)
                if verdict not in INVALID:
                    print(f"{len(self.valid()):4} {verdict}: {mutant}", flush=True)


def main(words: list[str] | None = None) -> int:
    """Run the campaign; return 0 when enough mutants are noticed."""
    parser = argparse.ArgumentParser(prog="tests/mutation/run", description=__doc__)
    parser.add_argument("--count", type=int, default=60, help="of mutants that count (60)")
    parser.add_argument("--seed", type=int, default=44, help="of the draw (44)")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time (2)")
    parser.add_argument("--files", nargs="+", help="draw from these files only")
    parser.add_argument("--tree", type=Path, default=ROOT, help="another clone to judge")
    asked = parser.parse_args(words)
    if asked.count < 1 or asked.jobs < 1:
        parser.error("--count and --jobs: give at least 1")
    if not (asked.tree / "firmware").is_dir():
        parser.error(f"--tree {asked.tree}: give a clone of this project")
    if unknown := set(asked.files or ()) - set(sources(asked.tree)):
        parser.error(f"--files {min(unknown)}: give sources such as firmware/tick/cam_tick.c")
    tree, verify = asked.tree.resolve(), ROOT / "build" / "verify"
    folders = [tree / "build" / "mutation" / str(i) for i in range(asked.jobs)]
    verify.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(asked.jobs) as pool:
        shops = list(pool.map(Shop, [tree] * asked.jobs, folders))
        times = shops[0].measure()
        stream = drawn(tree, asked.seed, asked.files or sources(tree))
        key = f"{asked.seed} {asked.files}"
        verdicts = Verdicts(tree, stream, key, folders[0].with_name("verdicts.jsonl"))
        for shop in shops:
            shop.times = times
        list(pool.map(verdicts.fill, shops, [asked.count] * asked.jobs))
    judged = verdicts.judged[: verdicts.valid()[: asked.count][-1] + 1]
    sums = Counter(verdict.partition(" by")[0] for _, verdict in judged)
    n_valid = sum(n for verdict, n in sums.items() if verdict not in INVALID)
    percent = round(100 * (1 - sums["survived"] / n_valid), 2)
    for mutant, verdict in judged:
        if verdict == "survived":
            print(f"survived, and is not explained: {mutant}")
    figures = {"seed": asked.seed, "count": n_valid, "percent": percent, **sums}
    (verify / "mutation.json").write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    print(f"{percent} % of {n_valid} mutants noticed or explained: {dict(sums)}")
    return 0 if percent >= LEAST_PERCENT else 1


if __name__ == "__main__":
    sys.exit(main())
