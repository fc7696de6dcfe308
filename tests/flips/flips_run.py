# SPDX-License-Identifier: Apache-2.0
"""Lets single bits flip in a cut on the emulated core, and tells what came of it."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path

from flips_image import ImageError, Result, Strike, golden_runs, read_map, run_strikes
from flips_judge import CLASSES, WRONG, Verdict, judge, limits_of
from flips_plan import REGISTERS, ROOT, SHARES, Planner, Sites
from scipy.stats import beta

HEADINGS = {
    "none": "no effect",
    "small": "within the course",
    "detected": "retracted",
    "stopped": "stopped at once",
    "main": "stopped, main loop",
    "limits": "wrong: limits",
    "course": "wrong: course",
}


def most_wrong_percent(n_wrong: int, n: int) -> float:
    """Return the upper bound of the share, at 95 %, by Clopper and Pearson."""
    return 100.0 * float(beta.ppf(0.95, n_wrong + 1, n - n_wrong)) if n_wrong < n else 100.0


def describe(strike: Strike, result: Result, verdict: Verdict, sites: Sites) -> str:
    """Return one line about one run."""
    where = (
        f"{REGISTERS[strike.place]} in {sites.of_code(result.pc)} at 0x{result.pc:x}"
        if strike.stratum.startswith("registers")
        else sites.of_code(result.address)
        if strike.stratum == "code"
        else sites.of_address(result.address)
    )
    return (
        f"{strike.stratum}: {where} bit {strike.bit}, checkpoint {strike.checkpoint} tick"
        f" {strike.tick} at {strike.at}: {verdict.what}, {verdict.wrong_after} ticks behind,"
        f" reaction {verdict.seen_after} (faults 0x{verdict.faults:x})"
    )


def table(counts: dict[str, Counter[str]], sizes: dict[str, int]) -> list[str]:
    """Return the rows of the table."""
    rows = [
        "| stratum | bytes | flips | " + " | ".join(HEADINGS.values()) + " | wrong at most |",
        "|---" * (len(HEADINGS) + 4) + "|",
    ]
    every: Counter[str] = Counter()
    for stratum, count in counts.items():
        every += count
        rows.append(_row(stratum, str(sizes[stratum] or "-"), count))
    return [*rows, _row("all", "", every)]


def _row(name: str, size: str, count: Counter[str]) -> str:
    n = sum(count.values())
    n_wrong = sum(count[k] for k in WRONG)
    cells = " | ".join(str(count[k]) for k in CLASSES)
    return f"| {name} | {size} | {n} | {cells} | {most_wrong_percent(n_wrong, n):.2f} % |"


def figures(counts: dict[str, Counter[str]], seed: int, seconds: float) -> dict[str, float]:
    """Return everything as one flat object."""
    flat: dict[str, float] = {"seed": seed, "seconds": round(seconds)}
    every: Counter[str] = Counter()
    for stratum, count in counts.items():
        every += count
        key = stratum.replace(", ", "_").replace(" ", "_")
        for kind in CLASSES:
            flat[f"{key}.{kind}"] = count[kind]
    for kind in CLASSES:
        flat[f"all.{kind}"] = every[kind]
    flat["all.count"] = sum(every.values())
    n_wrong = sum(every[k] for k in WRONG)
    flat["all.wrong_most_percent"] = round(most_wrong_percent(n_wrong, sum(every.values())), 3)
    return flat


def main() -> int:
    """Run the campaign. Return 0 when nothing wrong stayed unseen but what README.md lists."""
    parser = argparse.ArgumentParser(prog="tests/flips/run", description=__doc__)
    parser.add_argument("--count", type=int, default=10000, help="flips, default %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="default %(default)s")
    parser.add_argument("--record", action="store_true", help="keep the figures in the folder")
    parser.add_argument("--image", type=Path, default=ROOT / "build/mcu-qemu/tests/flips/flips.elf")
    parser.add_argument("--work", type=Path, default=ROOT / "build/flips", help="scratch folder")
    words = parser.parse_args()
    image = words.image.resolve()
    if not image.exists():
        parser.error(f"{image} is missing: build it by 'cmake --build --preset mcu-qemu'")
    begin = time.monotonic()
    try:
        golden = golden_runs(image, words.work)
        told = read_map(words.work)
        planner = Planner(image, told, golden, words.seed)
        strikes = planner.plan(words.count)
        results = run_strikes(image, words.work, strikes)
    except ImageError as error:
        print(error, file=sys.stderr)
        return 2
    limits, sites = limits_of(told), Sites(image, told)
    counts: dict[str, Counter[str]] = {s: Counter() for s in SHARES}
    wrong = []
    for strike, result in zip(strikes, results, strict=True):
        verdict = judge(result, golden[strike.checkpoint], limits, strike.tick)
        counts[strike.stratum][verdict.kind] += 1
        if verdict.kind in WRONG:
            wrong.append(f"{verdict.kind}: {describe(strike, result, verdict, sites)}")
    seconds = time.monotonic() - begin
    print("\n".join(table(counts, {s: planner.bytes_of(s) for s in SHARES})))
    print(f"seed {words.seed}, {len(strikes)} flips in {seconds:.0f} s")
    flat = figures(counts, words.seed, seconds)
    kept = ROOT / "build" / "verify"
    kept.mkdir(parents=True, exist_ok=True)
    (kept / "flips.json").write_text(json.dumps(flat, indent=1, sort_keys=True) + "\n")
    (kept / "flips.wrong.txt").write_text("\n".join([*wrong, ""]))
    if words.record:
        (Path(__file__).parent / "figures.json").write_text(
            json.dumps(flat, indent=1, sort_keys=True) + "\n"
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
