# SPDX-License-Identifier: Apache-2.0
"""Lets single bits flip in a cut on the emulated core, and tells what came of it."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from flips_campaign import Campaign, Outcome
from flips_figures import figures, record, table
from flips_image import ImageError
from flips_judge import WRONG
from flips_listed import by_kind, read_listed
from flips_plan import ROOT, SHARES
from flips_short import COUNT, LEAST_RETRACTED, MOST_WRONG, judge_short, short_strikes

TOLD = ROOT / "build" / "verify"


def arguments() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(prog="tests/flips/run", description=__doc__)
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--count", type=int, default=10000, help="flips (%(default)s)")
    length.add_argument(
        "--short",
        action="store_true",
        help=f"{COUNT} aimed ones: {MOST_WRONG} may be wrong, {LEAST_RETRACTED} have to be noticed",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the draw (%(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="emulators at a time (%(default)s)")
    parser.add_argument(
        "--record", action="store_true", help="write tests/flips/figures.json and README.md's table"
    )
    parser.add_argument("--image", type=Path, default=ROOT / "build/mcu-qemu/tests/flips/flips.elf")
    parser.add_argument("--work", type=Path, default=ROOT / "build/flips", help="scratch folder")
    words = parser.parse_args()
    if words.count < 1 or words.jobs < 1 or words.seed < 0:
        parser.error("--count and --jobs: give a number above 0; --seed: 0 or more")
    if words.short and words.record:
        parser.error("--record: leave --short away; a short campaign is not recorded")
    if not words.image.exists():
        parser.error(f"{words.image} is missing: tests/flips/run builds it")
    return words


def tell_wrong(kinds: Mapping[str, Sequence[Outcome]], name: str) -> None:
    """Write the wrong ones into a file, kind by kind."""
    lines = [f"{kind or 'not listed'}: {one}\n" for kind, found in kinds.items() for one in found]
    TOLD.mkdir(parents=True, exist_ok=True)
    (TOLD / f"{name}.wrong.txt").write_text("".join(lines))


def run(words: argparse.Namespace) -> int:
    """Run the campaign. Return 0 when nothing was wrong but what is listed."""
    begin_s = time.monotonic()
    name = "flips-short" if words.short else "flips"
    campaign = Campaign(words.image.resolve(), words.work.resolve(), words.seed, words.jobs)
    planner = campaign.planner
    aimed = short_strikes(planner, campaign.sites.layout) if words.short else None
    strikes = aimed or planner.plan(words.count)
    outcomes = campaign.run(strikes)
    wrong = [o for o in outcomes if o.verdict.kind in WRONG]
    kinds = by_kind(wrong, outcomes, read_listed())
    tell_wrong(kinds, name)
    found = kinds[""]
    flat = figures(outcomes, {s: planner.bytes_of(s) for s in SHARES}, words.seed, kinds)
    (TOLD / f"{name}.json").write_text(json.dumps(flat, indent=1) + "\n")
    print(table(flat), end="")
    for one in [] if words.short else found:
        print(one)
    if words.record:
        record(flat)
    seconds = time.monotonic() - begin_s
    allowed = f"{MOST_WRONG} may be" if words.short else f"{len(found)} of them not listed"
    print(
        f"seed {words.seed}: {len(strikes)} flips in {seconds:.0f} s, {flat['wrong']} wrong,"
        f" {allowed} (build/verify/{name}.wrong.txt)"
    )
    if not words.short:
        return int(bool(found))
    complaint = judge_short(outcomes)
    print(complaint, end="\n" if complaint else "", file=sys.stderr)
    return int(bool(complaint))


def interrupt(*_: object) -> None:
    """End the campaign where it is. A shell's background process would ignore the keyboard's."""
    raise KeyboardInterrupt


def main() -> int:
    """Run the campaign; return the exit status."""
    words = arguments()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    try:
        return run(words)
    except ImageError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where this one ended", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
