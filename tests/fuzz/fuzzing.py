"""Runs the targets of tests/fuzz in build/host-fuzz, on what earlier runs collected."""

import argparse
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from checks.patience import limit_s

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "fuzz"
PROGRAMS = ROOT / "build" / "host-fuzz" / "tests" / "fuzz"
VERIFY = ROOT / "build" / "verify"
WORK = VERIFY / "fuzz"
ENDLESS_S = 60.0  # for one input, on an idle reference machine; the slowest takes 0.1 s
NUMBERS = ("\\xff\\xff\\xff\\x7f", "\\x00\\x00\\x00\\x80", "\\xff\\xff\\xff\\xff", "1e308", "-0")


class Target(NamedTuple):
    """A target, its executions in a whole campaign, and the sources of its dictionary."""

    name: str
    executions: int
    max_bytes: int
    sources: tuple[str, ...] = ()


# The states of the machine are deep: machine, session and can take more than half of the time.
TARGETS = (
    Target("machine", 6_500, 250),
    Target("session", 18_000, 200),
    Target("can", 48_000, 400, ("firmware/base/cam_err.h",)),
    Target("cut", 500_000, 5000),
    Target("table", 3_000_000, 5000),
    Target("settings", 950_000, 2000,
           ("host_sim/setup/sim_config.c", "hal/linux/setup/lin_config.c",
            "host_sim/lathe/sim_inject.c", "host_sim/cli/camsim_options.c",
            "host_sim/cli/camsim_parse.c")),
    Target("servo", 1_000_000, 3000),
    Target("feasible", 60_000, 200),
    Target("learning", 15_000, 1000),
    Target("kept", 17_000, 1500,
           ("firmware/param/cam_param.h", "firmware/param/cam_param_store.c")),
    Target("design", 140_000, 1500,
           ("host_sim/part/sim_design_file.c", "host_sim/part/sim_surface.c",
            "host_sim/part/sim_lobe_design.c", "host_sim/part/sim_correction.c",
            "host_sim/part/sim_sides.c", "host_sim/base/sim_json.c")),
)  # fmt: skip


def dictionary(target: Target) -> Path:
    """Write the words that a reader knows: the strings of its sources, or names of parameters."""
    text = "\n".join((ROOT / source).read_text("utf-8") for source in target.sources)
    words = {*re.findall(r'"([\w.\-@]{2,32})"', text)}
    words |= {*re.findall(r"^    X\((\w+),", text, re.MULTILINE)}
    path = WORK / f"{target.name}.dict"
    path.write_text("".join(f'"{word}"\n' for word in [*sorted(words), *NUMBERS]), "utf-8")
    return path


def last_number(pattern: str, text: str) -> int:
    """Return the last number that a pattern finds, 0 when there is none."""
    numbers = re.findall(pattern, text)
    return int(numbers[-1]) if numbers else 0


def attack(target: Target, factor: float, seed: int) -> tuple[int, int, str]:
    """Run a target.

    Returns
    -------
    tuple
        Executions, edges reached, and the finding or "".
    """
    corpus = WORK / "corpus" / target.name
    corpus.mkdir(parents=True, exist_ok=True)
    folders = [corpus, WORK / "seeds" / target.name, HERE / "regressions" / target.name]
    words = [
        f"-runs={max(1, round(target.executions * factor))}",
        f"-max_len={target.max_bytes}",
        f"-seed={seed}",
        f"-timeout={limit_s(ENDLESS_S):.0f}",
        "-rss_limit_mb=2048",
        f"-artifact_prefix={WORK / 'found' / target.name}-",
        f"-dict={dictionary(target)}",
        "-print_final_stats=1",
        "-reduce_inputs=1",
        *(str(folder) for folder in folders if folder.is_dir()),
    ]
    log = WORK / f"{target.name}.log"
    with log.open("wb") as file:
        program = PROGRAMS / f"fuzz_{target.name}"
        done = subprocess.run([program, *words], cwd=WORK, stdout=file, stderr=file, check=False)
    text = log.read_text("utf-8", errors="replace")
    named = re.search(r"broken: .*|runtime error: .*|ERROR: .*", text)
    finding = named[0] if named else f"exit status {done.returncode}"
    executions = last_number(r"stat::number_of_executed_units:\s+(\d+)", text)
    return executions, last_number(r"cov: (\d+)", text), finding if done.returncode else ""


def main(words: Sequence[str] | None = None) -> int:
    """Run the targets; return 0 when nothing was found."""
    parser = argparse.ArgumentParser(prog="tests/fuzz/run", description=__doc__)
    names = [target.name for target in TARGETS]
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(names)}")
    parser.add_argument("--factor", type=float, default=1.0, help="for all executions (1)")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time (2)")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations, not 0 (1)")
    asked = parser.parse_args(words)
    if unknown := set(asked.targets) - set(names):
        parser.error(f"no target {', '.join(sorted(unknown))}; give some of {', '.join(names)}")
    if asked.factor <= 0.0 or asked.jobs < 1 or asked.seed < 1:
        parser.error("--factor, --jobs and --seed: give a number above 0")
    targets = [target for target in TARGETS if not asked.targets or target.name in asked.targets]
    (WORK / "found").mkdir(parents=True, exist_ok=True)
    shutil.rmtree(WORK / "seeds", ignore_errors=True)
    subprocess.run([PROGRAMS / "fuzz_seeds", WORK / "seeds"], check=True)
    with ThreadPoolExecutor(asked.jobs) as pool:
        outcomes = list(pool.map(lambda one: attack(one, asked.factor, asked.seed), targets))
    figures = {"seed": asked.seed, "found": sum(bool(found) for *_, found in outcomes)}
    for target, (executions, edges, found) in zip(targets, outcomes, strict=True):
        print(f"{target.name:9}{executions:>10} executions{edges:>6} edges  {found}")
        figures |= {f"{target.name}_executions": executions, f"{target.name}_edges": edges}
    (VERIFY / "fuzz.json").write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    print(f"{figures['found']} of {len(targets)} targets with a finding (build/verify/fuzz)")
    return 1 if figures["found"] else 0


if __name__ == "__main__":
    sys.exit(main())
