"""Runs the programs of the campaign and adds their figures up."""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build" / "host" / "tests" / "campaign"
VERIFY = ROOT / "build" / "verify"
# Tick rate, its share of the hours, and what is added to the seed; the longest first.
HOURS = ((20000, 4, 3), (20000, 4, 4), (5000, 4, 2), (2000, 6, 1), (1000, 6, 0))

Figures = dict[str, float | str]


def run(words: tuple[str, ...]) -> tuple[list[Figures], str]:
    """Run a program that prints JSON objects; return them, and a finding or ""."""
    done = subprocess.run(
        [PROGRAMS / words[0], *words[1:]], capture_output=True, text=True, check=False
    )
    lines = done.stdout.splitlines()
    found = [json.loads(line) for line in lines if line.startswith("{")]
    if done.returncode == 0:
        return found, ""
    sessions = [line for line in lines if line.startswith("session")]
    return found, " | ".join([" ".join(words), *sessions[-1:], *done.stderr.splitlines()[-1:]])


def hours_of(objects: Sequence[Figures]) -> Figures:
    """Return the sums of what hours.c counted."""
    keys = {key: None for one in objects for key in one}
    return {key: round(sum(float(one[key]) for one in objects), 3) for key in keys}


def main(words: Sequence[str] | None = None) -> int:
    """Run the campaign; return 0 when nothing was found."""
    parser = argparse.ArgumentParser(prog="tests/campaign/run", description=__doc__)
    parser.add_argument("--hours", type=float, default=12.0, help="of machine time (12)")
    parser.add_argument("--seed", type=int, default=1, help="of all that happens at random (1)")
    parser.add_argument("--jobs", type=int, default=2, help="programs at a time (2)")
    asked = parser.parse_args(words)
    if asked.hours <= 0.0 or asked.jobs < 1 or asked.seed < 1:
        parser.error("--hours, --jobs and --seed: give a number above 0")
    whole = sum(share for _, share, _ in HOURS)
    programs = [
        *(("campaign_hours", str(hz), f"{asked.hours * share / whole:.6f}", f"{asked.seed}{more}")
          for hz, share, more in HOURS),
        ("campaign_power_stm",), ("campaign_power_linux",), ("campaign_bus",),
    ]  # fmt: skip
    with ThreadPoolExecutor(asked.jobs) as pool:
        results = list(pool.map(run, programs))
    findings = [finding for _, finding in results if finding]
    figures: dict[str, object] = {"seed": asked.seed, "found": len(findings)}
    figures["hours"] = hours = hours_of(
        [one for found, _ in results[: len(HOURS)] for one in found]
    )
    for (name, *_), (found, _) in zip(programs[len(HOURS) :], results[len(HOURS) :], strict=True):
        figures[name.removeprefix("campaign_")] = found
    VERIFY.mkdir(exist_ok=True)
    (VERIFY / "campaign.json").write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    for finding in findings:
        print(f"found: {finding}")
    done = (f"{hours.get(key, 0):.0f} {key}" for key in ("hours", "parts", "faults"))
    print(f"{', '.join(done)}; {len(findings)} findings (build/verify/campaign.json)")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
