# SPDX-License-Identifier: Apache-2.0
"""What a cut does when something goes wrong: judged from the trace of camsim."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TICK_S = 50e-6
AT_S = 0.2  # of cutting
CLEAR_NM = 100_000  # the tip is out of the work when it is so far from the drawn surface
FORM_UM = 2.0  # a cut that goes on is within this of its drawing


@dataclass(frozen=True)
class Case:
    """A disturbance, and the fault that has to come of it; "" where the cut has to go on."""

    name: str
    inject: str
    fault: str
    latch_ms: float = 0.0
    """[ms] within which the fault has to be latched"""


@dataclass(frozen=True)
class Reaction:
    """What came of a case."""

    case: Case
    fault: str
    form_um: float | None = None
    latch_ticks: int | None = None
    out_ms: float | None = None
    """[ms] from the latch until the tip is out of the work for good"""
    gouge_um: float | None = None
    """[um] by which the tip was below the drawn surface, from the cause on"""
    wrong: str = ""


def now(kind: str, value: str = "") -> str:
    """Return an --inject in the cut."""
    return f"{kind}@{AT_S}{':' if value else ''}{value}"


CASES = (
    *(
        Case(f"clock {ppm:+d} ppm", f"clock-drift@t0:{ppm}", "")
        for ppm in (-10000, -1000, -100, 100, 1000, 10000)
    ),
    *(Case(f"jitter 0..{p} %", now("tick-jitter", str(p)), "") for p in (5, 10, 20)),
    Case("jitter 0..45 %", now("tick-jitter", "45"), ""),
    Case("jitter 0..60 %", now("tick-jitter", "60"), "late_tick", 10),
    Case("jitter 0..90 %", now("tick-jitter", "90"), "late_tick", 10),
    *(Case(f"one of 16 ticks {p} % late", now("tick-burst", str(p)), "") for p in (10, 20, 45)),
    Case("one of 16 ticks 55 % late", now("tick-burst", "55"), "late_tick", 10),
    *(Case(f"a tick twice, {p} % apart", now("tick-twice", str(p)), "") for p in (5, 50)),
    Case("a tick twice, 95 % apart", now("tick-twice", "95"), ""),
    *(Case(f"a tick {p} % late", now("late-tick", str(p)), "") for p in (30, 49)),
    Case("a tick 51 % late", now("late-tick", "51"), "late_tick", 0.1),
    Case("1 tick lost", now("late-tick", "100"), "late_tick", 0.15),
    Case("2 ticks lost", now("late-tick", "200"), "late_tick", 0.2),
    Case("10 ticks lost", now("late-tick", "1000"), "late_tick", 0.65),
    Case("emergency stop", now("estop"), "estop", 0.1),
    Case("drive not ready", now("drive"), "drive", 0.1),
    Case("node of the bus silent", now("bus"), "bus", 0.1),
    Case("2000 counts lost at once", now("lost-counts", "2000"), "encoder_jump", 0.1),
    Case("10 counts lost at once", now("lost-counts", "10"), "encoder_jump", 0.1),
    Case("4 counts lost", now("lost-counts", "4"), "lost_counts", 30),
    Case("1 count lost", now("lost-counts", "1"), "lost_counts", 30),
    Case("encoder stands", now("encoder-stuck"), "encoder_jump", 30),
    Case("no index", now("index-dead"), "index_missing", 60),
    Case("spindle reverses", now("reverse"), "reverse", 3000),
    Case("spindle stops", now("spindle-stop"), "spindle_stopped", 3000),
    Case("spindle runs away", now("spindle-speed", "4000"), "overspeed", 1000),
    Case("Z is 3 mm off", now("z-offset", "3"), "z_range", 1),
    Case("U is blocked", now("u-block"), "following_error", 30),
    Case("a bit of the table flips", now("table-flip", "2000"), "table", 1000),
)


def columns(path: Path) -> dict[str, np.ndarray]:
    """Return what is judged of a trace."""
    with path.open() as file:
        names = file.readline().strip().split(",")
    numbers = ("t_s", "error_nm")
    wanted = [names.index(name) for name in (*numbers, "state")]
    text = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=wanted, dtype=str)
    found = {name: text[:, i].astype(float) for i, name in enumerate(numbers)}
    return found | {"state": text[:, len(numbers)]}


def react(camsim: Path, table: Path, case: Case, folder: Path) -> Reaction:
    """Cut with a disturbance and judge it."""
    stem = case.inject.replace(":", "_").replace("@", "_")
    trace, summary = folder / f"{stem}.csv", folder / f"{stem}.json"
    for old in (trace, summary):
        old.unlink(missing_ok=True)
    words = [*("--feed", "1", "--inject", case.inject), "--trace", str(trace)]
    words += ["--summary", str(summary)]
    done = subprocess.run(
        [str(camsim), "run", str(table), *words], capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 1):
        return Reaction(case, "", wrong=done.stderr.strip())
    told = json.loads(summary.read_text("utf-8"))
    seen = columns(trace)
    trace.unlink()
    faults = [fault["name"] if isinstance(fault, dict) else fault for fault in told["faults"]]
    if not faults:
        form_um = round(float(told["form_error_um"]["max"]), 3)
        wrong = "" if not case.fault and done.returncode == 0 else f"no fault {case.fault}"
        if form_um > FORM_UM:
            wrong = f"form error {form_um} um"
        return Reaction(case, "", form_um=form_um, wrong=wrong)
    return judged(case, str(told.get("first_fault", faults[0])), seen)


def judged(case: Case, fault: str, seen: dict[str, np.ndarray]) -> Reaction:
    """Return what the trace tells of a cut that ended in a fault."""
    cutting = int(np.argmax(seen["state"] == "cutting"))
    cause_s = float(seen["t_s"][cutting]) + AT_S
    first = int(np.argmax(seen["state"] == "fault"))
    cause = int(np.argmax(seen["t_s"] >= cause_s - 1e-9))
    inside = np.flatnonzero(seen["error_nm"][first:] < CLEAR_NM)
    is_out = len(inside) == 0 or int(inside[-1]) + 1 < len(seen["t_s"]) - first
    out = first + (int(inside[-1]) + 1 if len(inside) else 0)
    latch_s = float(seen["t_s"][first]) - cause_s
    wrong = ""
    if fault != case.fault:
        wrong = f"fault {fault}, not {case.fault or 'none'}"
    elif latch_s * 1e3 > case.latch_ms:
        wrong = f"latched after {latch_s * 1e3:.3f} ms of {case.latch_ms}"
    elif not is_out and fault != "drive":
        wrong = "the tip stays in the work"
    return Reaction(
        case,
        fault,
        latch_ticks=round(latch_s / TICK_S),
        out_ms=round(float(seen["t_s"][out] - seen["t_s"][first]) * 1e3, 2) if is_out else None,
        gouge_um=round(max(0.0, -float(seen["error_nm"][cause:].min()) / 1e3), 2),
        wrong=wrong,
    )
