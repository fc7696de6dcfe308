"""Run the firmware's unit tests and tell which lines, branches and conditions they have tried.

MC/DC: for each condition of a decision, two tests that differ in it alone and in the outcome. What
moves the machine (guard, move, sequence, machine) must have all of it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILD = ROOT / "build" / "host-mcdc"
PROFILES = BUILD / "profiles"
# What decides whether and how an axis moves.
DECIDING = (
    *(
        "cam_guard.c",
        "cam_axis_command.c",
        "cam_move_profile.c",
        "cam_jerk_filter.c",
        "cam_play.c",
        "cam_plan.c",
    ),
    *("cam_jog.c", "cam_positioning.c", "cam_plan_move.c", "cam_tick.c"),
    *("cam_machine*.c", "cam_acknowledge.c", "cam_rights.c"),
)
LEAST = {"lines": 99.0, "branches": 97.0}
LINE, COLUMN, CONDITIONS = 0, 1, -1


def programs() -> list[Path]:
    """Return the unit tests, those of simulator and ports included: they run the firmware, too."""
    found = BUILD.glob("tests/unit/test_*")
    return sorted(p for p in found if p.is_file() and os.access(p, os.X_OK))


def run_tests(tests: list[Path], jobs: int) -> None:
    """Run the tests, each with a profile of its own; one that fails measures nothing."""
    PROFILES.mkdir(parents=True, exist_ok=True)
    for old in PROFILES.glob("*.profraw"):
        old.unlink()

    def run(test: Path) -> int:
        environment = os.environ | {"LLVM_PROFILE_FILE": str(PROFILES / f"{test.name}.profraw")}
        done = subprocess.run([test], env=environment, capture_output=True, check=False)
        return done.returncode

    with ThreadPoolExecutor(jobs) as pool:
        failed = [t.name for t, s in zip(tests, pool.map(run, tests), strict=True) if s != 0]
    if failed:
        sys.exit(f"mcdc: these tests fail: {' '.join(failed)}; mend them first")


def exported(tests: list[Path]) -> dict[str, Any]:
    """Return what llvm-cov tells of the firmware's files."""
    merged = PROFILES / "all.profdata"
    raw = sorted(map(str, PROFILES.glob("*.profraw")))
    subprocess.run(["llvm-profdata-19", "merge", "-sparse", "-o", merged, *raw], check=True)
    objects = [word for test in tests[1:] for word in ("-object", str(test))]
    words = ["llvm-cov-19", "export", f"-instr-profile={merged}", "-skip-functions", str(tests[0])]
    folders = sorted(str(p) for p in (ROOT / "firmware").iterdir() if p.is_dir())
    done = subprocess.run(
        [*words, *objects, *folders], capture_output=True, text=True, check=True, cwd=ROOT
    )
    data: dict[str, Any] = json.loads(done.stdout)["data"][0]
    return data


def open_conditions(file: dict[str, Any]) -> list[str]:
    """Return the conditions of a file that no pair of tests has shown, by their decisions."""
    found = []
    for record in file.get("mcdc_records", []):
        shown = record[CONDITIONS]
        if not all(shown):
            which = ", ".join(str(i + 1) for i, one in enumerate(shown) if not one)
            found.append(f"line {record[LINE]}: condition {which} of {len(shown)}")
    return found


def percent(files: list[dict[str, Any]], what: str) -> float:
    """Return how many percent of lines, branches or conditions of some files are covered."""
    count = sum(file["summary"][what]["count"] for file in files)
    covered = sum(file["summary"][what]["covered"] for file in files)
    return round(100 * covered / count, 2) if count else 100.0


def main() -> int:
    """Measure; return 0 when enough was tried."""
    parser = argparse.ArgumentParser(prog="tests/mcdc/run", description=__doc__)
    parser.add_argument("--jobs", type=int, default=2, help="tests side by side (default: 2)")
    parser.add_argument("--record", action="store_true", help="write figures.json beside this")
    parser.add_argument("--all", action="store_true", help="list the open conditions of all files")
    options = parser.parse_args()
    tests = programs()
    run_tests(tests, options.jobs)
    files = [f for f in exported(tests)["files"] if "/can/" not in f["filename"]]
    deciding = [f for f in files if any(Path(f["filename"]).match(one) for one in DECIDING)]
    for file in files if options.all else deciding:
        name = Path(file["filename"]).relative_to(ROOT)
        for one in open_conditions(file):
            print(f"{name}: {one}")
    figures = {
        "lines_percent": percent(files, "lines"),
        "branches_percent": percent(files, "branches"),
        "mcdc_percent": percent(files, "mcdc"),
        "deciding_mcdc_percent": percent(deciding, "mcdc"),
        "deciding_conditions": sum(f["summary"]["mcdc"]["count"] for f in deciding),
        "conditions": sum(f["summary"]["mcdc"]["count"] for f in files),
        "tests": len(tests),
    }
    text = json.dumps(figures, indent=1) + "\n"
    print(text, end="")
    (ROOT / "build" / "verify").mkdir(parents=True, exist_ok=True)
    (ROOT / "build" / "verify" / "mcdc.json").write_text(text, encoding="utf-8")
    if options.record:
        (HERE / "figures.json").write_text(text, encoding="utf-8")
    enough = figures["deciding_mcdc_percent"] == 100.0
    enough = enough and all(figures[f"{what}_percent"] >= LEAST[what] for what in LEAST)
    return 0 if enough else 1


if __name__ == "__main__":
    sys.exit(main())
