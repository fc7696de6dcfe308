"""Run Frama-C: WP proves the contracts beside the functions, Eva that no tick overflows.

The program fails if anything is left open.
"""

import argparse
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from checks.patience import limit_s

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROOMS = ("base", "table", "servo", "motion", "record", "plan", "tick")  # that the interrupt runs
FOLDERS = ("tests/proof/eva", "tests/proof", *(f"firmware/{room}" for room in ROOMS))
INCLUDES = " ".join(f"-I{name}" for name in (*FOLDERS, "hal/include"))
PROVER_S = 10.0  # on an idle reference machine; the goals that are proved take below 0.3 s
SERVO = ("force_q6", "notched_q6", "integrate", "heat", "feed_forward_q6")
# Functions that Eva takes by their contracts, which WP or another driver of Eva has shown.
BY_CONTRACT = (
    *("cam_eval_height", "cam_lobes_slice", "cam_envelope_smooth_q30", "inverse_q30"),
    *SERVO,
)
# What WP proves: a file with contracts, and of which functions; all of them where none is named.
WP = {
    "base": ("cam_fix.h", ()),
    "evaluator": ("cam_eval.h", ("cam_eval_round",)),
    "move": (
        "cam_move_profile.c",
        ("can_brake", "choose", "cam_move_profile_to_isr", "cam_move_profile_stop_isr"),
    ),
    "guard": ("cam_guard.c", ("is_allowed", "within_stroke_nm")),
    "plan": ("cam_plan.c", ("ramped",)),
}
MACHINES = {"32": "gcc_x86_32", "64": "gcc_x86_64"}
ONLY_32 = ("tick",)  # as long as all others together; its parts are analysed for both
# Drivers of Eva, and the functions whose contracts they show instead of taking them for granted.
# The longest come first, so that none is left alone at the end.
EVA = {
    "tick": (),
    "bare": (),
    "height": ("cam_eval_height", "cam_lobes_slice"),
    "envelope": ("cam_envelope_smooth_q30", "inverse_q30"),
    "servo": SERVO,
    "slot": (),
}
# Sources whose static functions are shown: the driver includes them.
PARTS = {"envelope": ("cam_envelope.c",), "servo": ("cam_servo.c", "cam_axis_command.c")}


class Result(NamedTuple):
    """What one run of Frama-C has shown."""

    name: str
    goals: int
    proved: int
    alarms: list[str]


def frama_c(*words: str | Path) -> str:
    """Return the output of Frama-C, which must accept its input."""
    command = ["frama-c", *map(str, words)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        print(run.stdout[-2000:], run.stderr[-2000:], sep="\n", file=sys.stderr)
        raise SystemExit(f"tests/proof/run: frama-c ended with {run.returncode}; see above")
    return run.stdout


def common(machine: str) -> tuple[str, ...]:
    """Return the options of all runs."""
    cpp = f"-cpp-extra-args=-include tests/proof/platform.h {INCLUDES}"
    return ("-machdep", machine, "-c11", cpp)


def prove(name: str) -> Result:
    """Prove contracts by WP."""
    header, functions = WP[name]
    source = ROOT / "build" / "proof" / f"{name}.c"
    source.parent.mkdir(parents=True, exist_ok=True)
    source.write_text(f'#include "{header}"\n', encoding="utf-8")
    chosen = ("-wp-fct", ",".join(functions)) if functions else ()
    text = frama_c(
        *common(MACHINES["32"]),
        source,
        *("-wp", "-wp-rte", "-wp-prover", "cvc4,z3", "-wp-par", "1"),
        *("-wp-timeout", f"{limit_s(PROVER_S):.0f}", *chosen),
    )
    count = re.search(r"Proved goals:\s*(\d+) / (\d+)", text)
    if count is None:
        raise SystemExit(f"tests/proof/run: WP reports no goals of {name}")
    failed = re.findall(r"\[Failed\] Goal typed_(\S+)", text)
    alarms = [f"{header}: goal {one}" for one in failed]
    return Result(f"wp {name}", int(count[2]), int(count[1]), alarms)


def sources() -> list[Path]:
    """Return what the interrupt runs."""
    ticks = sorted(p for room in ROOMS[2:] for p in (ROOT / "firmware" / room).glob("*.c"))
    table = [ROOT / "firmware" / "table" / name for name in ("cam_feed_profile.c", "cam_lobes.c")]
    share = subprocess.run(
        ["frama-c", "-print-share-path"], capture_output=True, text=True, check=True
    ).stdout.strip()
    return [*ticks, *table, Path(share) / "libc" / "string.c"]


def alarm_of(block: str) -> str | None:
    """Return file and assertion of an alarm, without what changes from run to run.

    A member that may leave its range in a tick is one, too.
    """
    left = re.search(r'Frama_C_show_each_leaves:\s+\{\{ "([^"]+)" \}\}', block)
    if left is not None:
        return f"ranges_state.h: leaves its range: {left[1]}"
    found = re.match(r"\[eva:alarm\] (\S+?):\d+: Warning: (.*)", block, re.DOTALL)
    if found is None:
        return None
    message = " ".join(found[2].split())
    message = re.sub(r"(function \w+?)_\d+:", r"\1:", message)
    return f"{Path(found[1]).name}: {message}"


def is_open(alarm: str, shown: tuple[str, ...]) -> bool:
    """Return whether an alarm is one; what a function promises is shown by WP or its driver."""
    promise = re.search(r"function (\w+)(?:, behavior \w+)?: postcondition", alarm)
    return promise is None or promise[1] in shown


def analyse(driver: str, bits: str) -> Result:
    """Analyse a driver by Eva."""
    taken = [one for one in BY_CONTRACT if one not in EVA[driver]]
    files = [*(HERE / "eva" / f"{name}.c" for name in ("world", "hal", driver)), *sources()]
    own = PARTS.get(driver, ())
    files = [one for one in files if one.name not in own]
    text = frama_c(
        *common(MACHINES[bits]),
        *(one.relative_to(ROOT) if one.is_relative_to(ROOT) else one for one in files),
        *("-eva", "-eva-precision", "1", "-eva-no-show-progress"),
        "-eva-msg-key=-final-states",
        *("-eva-use-spec", ",".join(taken)),
    )
    found = [alarm_of(block) for block in re.split(r"(?m)^(?=\[)", text)]
    alarms = [one for one in found if one is not None]
    alarms = [one for one in alarms if is_open(one, EVA[driver])]
    if "Frama_C_show_each_end" not in text:
        alarms.append(f"{driver}.c: its end is not reached")
    return Result(f"eva {driver} {bits} bits", 0, 0, alarms)


def main(words: Sequence[str] | None = None) -> int:
    """Run all proofs, or some; return 0 when nothing is left open."""
    parser = argparse.ArgumentParser(prog="tests/proof/run", description=__doc__)
    names = [*(f"wp-{one}" for one in WP), *(f"eva-{one}" for one in EVA)]
    parser.add_argument("--only", choices=names, action="append", help="of all proofs")
    parser.add_argument("--jobs", type=int, default=2, help="proofs at a time (2)")
    asked = parser.parse_args(words)
    chosen = [name.split("-") for name in asked.only or names]
    with ThreadPoolExecutor(asked.jobs) as pool:
        runs = [pool.submit(analyse, name, bits) for kind, name in chosen if kind == "eva"
                for bits in MACHINES if bits == "32" or name not in ONLY_32]  # fmt: skip
        runs += [pool.submit(prove, name) for kind, name in chosen if kind == "wp"]
        results = [run.result() for run in runs]
    for one in results:
        print(f"{one.name:20} {one.proved:4} of {one.goals:4} goals {len(one.alarms):4} alarms")
    still = Counter(alarm for one in results for alarm in one.alarms)
    for alarm, n in sorted(still.items()):
        print(f"NOT SHOWN ({n}): {alarm}")
    goals, proved = (sum(getattr(one, key) for one in results) for key in ("goals", "proved"))
    figures = {"goals": goals, "goals_proved": proved, "alarms_open": still.total()}
    (ROOT / "build" / "verify").mkdir(parents=True, exist_ok=True)
    text = json.dumps(figures, indent=1) + "\n"
    (ROOT / "build" / "verify" / "proof.json").write_text(text, encoding="utf-8")
    print(f"{proved} of {goals} goals proved, {still.total()} alarms open")
    return 0 if not still and proved == goals else 1


if __name__ == "__main__":
    sys.exit(main())
