# SPDX-License-Identifier: Apache-2.0
"""Strikes and judges in batches, several at a time; what was judged survives an interruption."""

from __future__ import annotations

import hashlib
import json
import queue
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Event

from flips_image import Result, Strike, golden_runs, read_map, run_strikes
from flips_judge import Verdict, judge, limits_of
from flips_plan import REGISTERS, Planner, Sites

HERE = Path(__file__).resolve().parent
BATCH = 250


@dataclass(frozen=True)
class Outcome:
    """A strike, where it went, and its verdict."""

    strike: Strike
    site: str  # function for registers and code, else part of the state and offset in it
    verdict: Verdict

    def __str__(self) -> str:
        """Return one line for people."""
        s, v = self.strike, self.verdict
        return (
            f"{v.kind}: {s.stratum}: {self.site} bit {s.bit}, checkpoint {s.checkpoint} tick"
            f" {s.tick} at {s.at}: {v.what}, {v.wrong_after} ticks behind, most {v.most},"
            f" reaction {v.seen_after} (faults 0x{v.faults:x})"
        )


def _site(strike: Strike, result: Result, sites: Sites) -> str:
    if strike.stratum.startswith("registers"):
        where = sites.of_code(result.pc)
        return f"{REGISTERS[strike.place]} in {where}"
    return (sites.of_code if strike.stratum == "code" else sites.of_address)(result.address)


class Campaign:
    """All strikes of a seed on an image."""

    def __init__(self, image: Path, work: Path, seed: int, jobs: int) -> None:
        self.image, self.work, self.jobs = image, work, jobs
        self._stop = Event()
        self._golden = golden_runs(image, work / "golden")
        told = read_map(work / "golden")
        self.planner = Planner(image, told, self._golden, seed)
        self._limits, self.sites = limits_of(told), Sites(image, told)
        tools = (
            (HERE / f"flips_{name}.py").read_bytes()
            for name in ("image", "judge", "plan", "layout")
        )
        self._base = hashlib.sha256(b"".join([image.read_bytes(), *tools])).digest()
        self._folders: queue.Queue[Path] = queue.Queue()
        for i in range(jobs):
            self._folders.put(work / f"job-{i}")

    def _kept(self, batch: Sequence[Strike]) -> Path:
        """Return the file of a batch, which belongs to image, tools and strikes."""
        name = hashlib.sha256(self._base + repr(batch).encode()).hexdigest()[:24]
        return self.work / "judged" / f"{name}.json"

    def _judge(self, batch: Sequence[Strike]) -> list[Outcome]:
        folder = self._folders.get()
        try:
            results = run_strikes(self.image, folder, batch, self._stop)
        finally:
            self._folders.put(folder)
        return [
            Outcome(s, _site(s, r, self.sites), self._verdict(s, r))
            for s, r in zip(batch, results, strict=True)
        ]

    def _verdict(self, strike: Strike, result: Result) -> Verdict:
        return judge(result, self._golden[strike.checkpoint], self._limits, strike.tick)

    def _batch(self, batch: Sequence[Strike]) -> list[Outcome]:
        kept = self._kept(batch)
        if kept.exists():
            rows = json.loads(kept.read_text())
            return [
                Outcome(s, site, Verdict(**v)) for s, (site, v) in zip(batch, rows, strict=True)
            ]
        outcomes = self._judge(batch)
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part")
        part.write_text(json.dumps([(o.site, asdict(o.verdict)) for o in outcomes]))
        part.replace(kept)
        return outcomes

    def run(self, strikes: Sequence[Strike]) -> list[Outcome]:
        """Return what came of the strikes, in their order.

        What was judged is kept until another campaign begins: one that was interrupted goes on with
        it, and one that is run again tells the same at once.
        """
        size = min(BATCH, -(-len(strikes) // 2))  # the same whatever the jobs
        batches = [strikes[i : i + size] for i in range(0, len(strikes), size)]
        needed = {self._kept(batch) for batch in batches}
        for other in set((self.work / "judged").glob("*")) - needed:
            other.unlink()
        with ThreadPoolExecutor(self.jobs) as pool:
            try:
                judged = list(pool.map(self._batch, batches))
            except BaseException:
                self._stop.set()
                pool.shutdown(cancel_futures=True)
                raise
        return [outcome for batch in judged for outcome in batch]
