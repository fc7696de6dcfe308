# SPDX-License-Identifier: Apache-2.0
"""The campaigns of tools/verify; step_runner.py runs them one after the other."""

from __future__ import annotations

import sys
from pathlib import Path

from step_runner import Runner, Step

ROOT = Path(__file__).resolve().parent.parent
LIMIT_S = 7200.0  # twice what all of them take on two cores
# What each is asked for, so that all of them end within an hour on two cores.
CAMPAIGNS: dict[str, tuple[str, ...]] = {
    "fuzz": ("--seconds", "600"),
    "proof": (),
    "campaign": (),
    "mutation": ("--count", "300"),
}


def steps(names: list[str], is_recorded: bool) -> list[Step]:
    """Return the campaigns of some names, or all, and at the end the safety case."""
    record = ("--record",) if is_recorded else ()
    found = [
        Step(name, (ROOT / "tests" / name / "run", *words, *record), is_wide=True, limit_s=LIMIT_S)
        for name, words in CAMPAIGNS.items()
        if not names or name in names
    ]
    if is_recorded:
        write = (sys.executable, "-m", "checks.safety", "--write")
        needs = tuple(step.name for step in found)
        found.append(Step("safety case", write, needs, is_wide=True))
    return found


def main(words: list[str]) -> int:
    """Run campaigns; return the exit status."""
    names = [word for word in words if word != "--record"]
    unknown = [name for name in names if name not in CAMPAIGNS]
    if unknown:
        known = ", ".join(CAMPAIGNS)
        print(f"tools/verify: no campaign {unknown[0]}; there are {known}", file=sys.stderr)
        return 2
    chosen = steps(names, "--record" in words)
    return Runner(chosen, ROOT, ROOT / "build" / "steps", 2).run()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
