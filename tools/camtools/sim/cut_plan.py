# SPDX-License-Identifier: Apache-2.0
"""How long a cut takes: its turns and machine time by camsim's own plan, computing by a trial.

>>> CutPlan(650.0, 17.5, 20_000.0).text()
'650 turns, 18 s of machine time'
>>> long = CutPlan(6_200_030.0, 148_802.0, 20_000.0, 2_976.0)
>>> long.text()
'6200030 turns, 1 d 17 h of machine time, about 49 min 36 s of computing'
"""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from typing import NamedTuple

from camtools.base.readable import duration_text
from camtools.sim.camsim import Simulator
from camtools.sim.results import read_summary

_LONG_TICKS = 3_000_000  # a few seconds of computing
_TRIAL_TURNS = 20
_TRIAL = "trial.json"


class CutPlan(NamedTuple):
    """What a cut will take."""

    turns: float  # of all passes
    machine_s: float
    tick_hz: float
    computing_s: float | None = None  # of a cut that is long

    @property
    def is_long(self) -> bool:
        """Return whether people want to know how far it is."""
        return self.machine_s * self.tick_hz > _LONG_TICKS

    def text(self) -> str:
        """Return it in a few words."""
        computing = self.computing_s
        about = "" if computing is None else f", about {duration_text(computing)} of computing"
        return f"{self.turns:.0f} turns, {duration_text(self.machine_s)} of machine time{about}"


def plan_of(simulator: Simulator, words: Sequence[str]) -> CutPlan | None:
    """Return what a cut will take; nothing where camsim does not plan it."""
    command = [str(simulator.program), "params", simulator.table, *words]
    try:
        done = subprocess.run(
            command, cwd=simulator.folder, capture_output=True, text=True, check=False
        )
    except OSError:
        return None  # the cut says why
    if done.returncode != 0:
        return None
    said = dict(line.split(",") for line in done.stdout.splitlines())
    plan = CutPlan(*(float(said[name]) for name in ("planned_turns", "planned_s", "tick_hz")))
    return _with_trial(simulator, words, plan) if plan.is_long else plan


def _with_trial(simulator: Simulator, words: Sequence[str], plan: CutPlan) -> CutPlan:
    """Return the plan with the time of computing, by that of a short cut."""
    trial = [*words, "--turns-limit", str(_TRIAL_TURNS), "--summary", _TRIAL]
    if simulator.run(trial, is_quiet=True) == 2 or not (simulator.folder / _TRIAL).exists():
        return plan
    rate = float(read_summary(simulator.folder / _TRIAL)["ticks_per_s"])
    (simulator.folder / _TRIAL).unlink()
    return plan._replace(computing_s=plan.machine_s * plan.tick_hz / rate)
