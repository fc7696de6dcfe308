# SPDX-License-Identifier: Apache-2.0
"""Runs the targets of tests/fuzz in build/host-fuzz and adds their figures up."""

import argparse
import json
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "fuzz"
PROGRAMS = ROOT / "build" / "host-fuzz" / "tests" / "fuzz"
COVERED = ROOT / "build" / "host-cov"
WORK = ROOT / "build" / "verify" / "fuzz"
RECORDED = HERE / "figures.json"
FIGURES = ROOT / "build" / "verify" / "fuzz.json"
SHORT_S = 10
INPUT_LIMIT_S = 10
MEMORY_LIMIT_MIB = 2048


@dataclass(frozen=True)
class Target:
    """A target, its share of a campaign, and what its dictionary is made of."""

    name: str
    share: int
    max_bytes: int
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What came of a target."""

    name: str
    executions: int
    seconds: float
    edges: int
    edges_of: int
    inputs: int
    found: str


# The share is of the time. The readers are fast and bring most of the executions; the states of the
# machine are deep, so machine, session and can get more than half of the time.
TARGETS = (
    Target("dbc", 6, 128),
    Target("isotp", 8, 300),
    Target("table", 10, 5000),
    Target("cut", 12, 5000),
    Target("can", 18, 400, ("firmware/base/cam_err.h",)),
    Target("session", 22, 200),
    Target("machine", 32, 250),
    Target("kept", 4, 1500, ("firmware/param/cam_param.h", "firmware/param/cam_param_store.c")),
    Target(
        "settings",
        5,
        2000,
        (
            "host_sim/setup/sim_config.c",
            "hal/linux/setup/lin_config.c",
            "host_sim/lathe/sim_inject.c",
            "host_sim/cli/camsim_options.c",
            "host_sim/cli/camsim_parse.c",
        ),
    ),
    Target(
        "design",
        3,
        1500,
        ("host_sim/part/sim_design_file.c", "host_sim/part/sim_surface.c",
         "host_sim/part/sim_lobe_design.c", "host_sim/part/sim_correction.c",
         "host_sim/part/sim_sides.c", "host_sim/base/sim_json.c"),
    ),
)  # fmt: skip


def dictionary(target: Target) -> Path:
    """Write the words that a reader knows: the strings of its sources, or names of parameters."""
    words: set[str] = set()
    for source in target.sources:
        text = (ROOT / source).read_text("utf-8")
        words.update(re.findall(r'"([\w.\-@]{2,32})"', text))
        words.update(re.findall(r"^    X\((\w+),", text, re.MULTILINE))
    numbers = (
        "\\xff\\xff\\xff\\x7f",
        "\\x00\\x00\\x00\\x80",
        "\\xff\\xff\\xff\\xff",
        "1e308",
        "-0",
    )
    path = WORK / f"{target.name}.dict"
    path.write_text("".join(f'"{word}"\n' for word in [*sorted(words), *numbers]), "utf-8")
    return path


def attack(target: Target, seconds: int, seed: int) -> Outcome:
    """Run a target for some time, on the inputs of former campaigns and the seeds."""
    corpus = WORK / "corpus" / target.name
    corpus.mkdir(parents=True, exist_ok=True)
    found = WORK / "found"
    folders = [corpus, WORK / "seeds" / target.name, HERE / "regressions" / target.name]
    began = time.monotonic()
    done = subprocess.run(
        [
            str(PROGRAMS / f"fuzz_{target.name}"),
            f"-max_total_time={seconds}",
            f"-max_len={target.max_bytes}",
            f"-seed={seed}",
            f"-timeout={INPUT_LIMIT_S}",
            f"-rss_limit_mb={MEMORY_LIMIT_MIB}",
            f"-artifact_prefix={found}/{target.name}-",
            f"-dict={dictionary(target)}",
            "-print_final_stats=1",
            "-reduce_inputs=1",
            *(str(folder) for folder in folders if folder.is_dir()),
        ],
        cwd=WORK,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    said = done.stdout + done.stderr
    (WORK / f"{target.name}.log").write_text(said, "utf-8")
    why = ""
    if done.returncode != 0:
        told = re.search(r"broken: .*|runtime error: .*|ERROR: .*", said)
        why = told[0] if told else f"exit status {done.returncode}"
    return Outcome(
        target.name,
        last_number(r"stat::number_of_executed_units:\s+(\d+)", said),
        time.monotonic() - began,
        last_number(r"cov: (\d+)", said),
        last_number(r"\((\d+) inline 8-bit counters\)", said),
        last_number(r"corp: (\d+)", said),
        why,
    )


def last_number(pattern: str, text: str) -> int:
    """Return the last number that a pattern finds, 0 when there is none."""
    numbers = re.findall(pattern, text)
    return int(numbers[-1]) if numbers else 0


def prepare() -> None:
    """Write the seeds anew, and keep what was found before apart."""
    (WORK / "found").mkdir(parents=True, exist_ok=True)
    shutil.rmtree(WORK / "seeds", ignore_errors=True)
    subprocess.run([PROGRAMS / "fuzz_seeds", WORK / "seeds"], check=True)


def coverage() -> dict[str, float]:
    """Return what share of the firmware the collected inputs reach, in a build with counters."""
    script = 'source "$1/tools/setup.sh"; camturn_build host-cov fuzz'
    build = ["bash", "-c", script, "bash", str(ROOT)]
    subprocess.run(build, check=True)
    for counts in COVERED.rglob("*.gcda"):
        counts.unlink()
    for target in TARGETS:
        folders = [WORK / kind / target.name for kind in ("seeds", "corpus")]
        subprocess.run(
            [
                COVERED / "tests" / "fuzz" / f"fuzz_{target.name}",
                *(f for f in folders if f.is_dir()),
            ],
            stdout=subprocess.DEVNULL,
            check=True,
        )
    report = WORK / "coverage.json"
    files = ("--filter", "firmware/", "--exclude", r"firmware/main\.c")
    gcovr = [
        sys.executable,
        "-m",
        "gcovr",
        "--root",
        str(ROOT),
        *files,
        "--json-summary",
        str(report),
        str(COVERED),
    ]
    subprocess.run(gcovr, check=True, stdout=subprocess.DEVNULL)
    summary = json.loads(report.read_text("utf-8"))
    return {
        "firmware_line_percent": round(summary["line_percent"], 1),
        "firmware_branch_percent": round(summary["branch_percent"], 1),
    }


def figures(outcomes: list[Outcome], wall_s: float, jobs: int) -> dict[str, float | str]:
    """Return the figures of a campaign as one flat object."""
    flat: dict[str, float | str] = {
        "seconds": round(wall_s),
        "jobs": jobs,
        "executions": sum(o.executions for o in outcomes),
        "found": sum(bool(o.found) for o in outcomes),
    }
    for o in outcomes:
        flat[f"{o.name}_executions"] = o.executions
        flat[f"{o.name}_per_second"] = round(o.executions / max(o.seconds, 1e-3))
        flat[f"{o.name}_edges"] = o.edges
        flat[f"{o.name}_edges_of"] = o.edges_of
        flat[f"{o.name}_inputs"] = o.inputs
    return flat


def table(flat: Mapping[str, float | str]) -> str:
    """Return the table of the figures of a campaign."""
    lines = [
        "| target | executions | a second | edges reached | of | inputs kept |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for target in TARGETS:
        if f"{target.name}_executions" in flat:
            keys = ("executions", "per_second", "edges", "edges_of", "inputs")
            numbers = " | ".join(str(flat[f"{target.name}_{key}"]) for key in keys)
            lines.append(f"| {target.name} | {numbers} |")
    return "\n".join(lines)


def arguments() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(prog="tests/fuzz/run", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="only these")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--seconds", type=int, default=600, help="of the whole campaign (600)")
    length.add_argument("--short", action="store_true", help=f"{SHORT_S} s for each target")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time (2)")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations, not 0 (1)")
    parser.add_argument(
        "--record", action="store_true", help="measure coverage, write tests/fuzz/figures.json"
    )
    asked = parser.parse_args()
    unknown = set(asked.targets) - {t.name for t in TARGETS}
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: no such target; give one of "
                     f"{', '.join(t.name for t in TARGETS)}")  # fmt: skip
    if asked.seconds < 1 or asked.jobs < 1 or asked.seed < 1:
        parser.error("--seconds, --jobs and --seed: give a number above 0")
    return asked


def main() -> int:
    """Run the campaign; return 0 when nothing was found."""
    asked = arguments()
    targets = [t for t in TARGETS if not asked.targets or t.name in asked.targets]
    prepare()
    whole = sum(t.share for t in targets)

    def one(target: Target) -> Outcome:
        time_s = asked.seconds * asked.jobs * target.share / whole
        return attack(target, SHORT_S if asked.short else max(1, round(time_s)), asked.seed)

    began = time.monotonic()
    with ThreadPoolExecutor(asked.jobs) as pool:  # the longest first, so that all end together
        order = sorted(targets, key=lambda t: -t.share)
        by_name = {o.name: o for o in pool.map(one, order)}
    outcomes = [by_name[t.name] for t in targets]
    flat = figures(outcomes, time.monotonic() - began, asked.jobs)
    print(table(flat))
    for outcome in outcomes:
        if outcome.found:
            print(f"{outcome.name}: {outcome.found}")
    if asked.record:
        flat |= coverage()
        RECORDED.write_text(json.dumps(flat, indent=2) + "\n", "utf-8")
    FIGURES.write_text(json.dumps(flat, indent=2) + "\n", "utf-8")
    found = flat["found"]
    print(f"{flat['executions']} executions, {found} targets with a finding (build/verify/fuzz)")
    return 0 if found == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
