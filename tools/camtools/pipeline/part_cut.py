"""The cuts that tools/run makes of a part: how long they are, what they write, the comparison.

All of them work in the folder of the table, which is the working folder.

>>> traced_turns(620, 2500), overview_every(62_000, 2500)
(None, 596)
"""

import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.text import Json, duration_text
from camtools.sim.results import OVERVIEW, SECTIONS, SURFACE, TRACE, CutVariant
from camtools.sim.simulate import Result, begun, cut

_OVERVIEW_TICKS = 50_000
MAX_TRACED_TICKS = 500_000  # about 13 MB of trace
_WINDOW_TURNS = 200  # at most of a longer cut, for trace and comparison
_TICK_HZ = 20_000  # of the default machine; good enough for an estimate
# Learning makes up for what is missing, so each part is judged without it.
_VARIANTS = {
    "complete controller": [],
    "without learning": ["--no-learning"],
    "without learning and lead": ["--no-learning", "--no-lead"],
    "without learning and feed-forward": ["--no-learning", "--no-feed-forward"],
}
_LONG_TICKS = 3_000_000  # a few seconds of computing
_TRIAL_TICKS = 400_000
_SHOWN_EVERY_S, _LINE_EVERY_S = 0.2, 20.0  # progress on a terminal, and elsewhere


def traced_turns(turns: float, speed_rpm: float) -> float | None:
    """Return how many turns of a cut too long to trace are traced, nothing when all of it is."""
    ticks_per_turn = 60 / speed_rpm * _TICK_HZ
    if turns * ticks_per_turn <= MAX_TRACED_TICKS:
        return None
    return min(_WINDOW_TURNS, MAX_TRACED_TICKS / 2 / ticks_per_turn)


def overview_every(turns: float, speed_rpm: float) -> int:
    """Return of how many ticks the overview of a long cut holds one."""
    return int(turns * 60 / speed_rpm * _TICK_HZ / _OVERVIEW_TICKS) + 1


class CutPlan(NamedTuple):
    """What a cut will take.

    >>> CutPlan(650.0, 17.5, 20_000.0).text()
    '650 turns, 18 s of machine time'
    >>> CutPlan(6_200_030.0, 148_802.0, 20_000.0, 2_976.0).text()
    '6200030 turns, 1 d 17 h of machine time, about 49 min 36 s of computing'
    """

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


def plan_of(table: str, words: Sequence[str]) -> CutPlan:
    """Return what a cut will take, or what the simulator refuses."""
    with begun([table, *words]) as session:
        plan = CutPlan(*session.plan())
        if not plan.is_long:
            return plan
        begin_s = time.monotonic()
        session.run(_TRIAL_TICKS)
        tick_s = (time.monotonic() - begin_s) / _TRIAL_TICKS
    return plan._replace(computing_s=plan.machine_s * plan.tick_hz * tick_s)


class _Progress:
    """Reports how much of a cut is done, in place on a terminal, else in a line now and then."""

    def __init__(self, machine_s: float) -> None:
        self._machine_s = machine_s
        self._begin_s = self._shown_s = time.monotonic()
        self._is_terminal = sys.stderr.isatty()

    def __call__(self, share: float) -> None:
        now_s = time.monotonic()
        every_s = _SHOWN_EVERY_S if self._is_terminal else _LINE_EVERY_S
        if share < 1 and now_s < self._shown_s + every_s:
            return
        self._shown_s = now_s
        left_s = (now_s - self._begin_s) * (1 / share - 1) if share else 0.0
        begin = "\r" if self._is_terminal else ""
        end = "   " if self._is_terminal and share < 1 else "\n"
        done = f"{100 * share:5.1f} %, {share * self._machine_s:.1f} s of machine time"
        sys.stderr.write(f"{begin}camsim: {done}, about {left_s:.0f} s left{end}")
        sys.stderr.flush()


def made_cut(table: str, words: Sequence[str], **options: Any) -> Result:  # noqa: ANN401
    """Cut as `cut` does, with its options, and refuse what the controller refuses."""
    result = cut([table, *words], **options)
    if result.status == BAD_INPUT:
        raise CamtoolsError([result.message])
    return result


def cut_part(
    table: str,
    words: Sequence[str],
    plan: CutPlan,
    window_turns: float | None,
    every: int = 1,
    *,
    sections_mm: Sequence[float] = (),
    keeps_text: bool = False,
) -> Result:
    """Cut a part; write surface, sections and trace; return the result with surface and sections.

    `window_turns`: the trace is of a second run that ends after so many turns; None: of the cut
    itself. `every`: the overview of a longer cut holds one tick of so many. `sections_mm`: heights,
    rising; none: those that camsim chooses. `keeps_text`: also write the traces as CSV.
    """
    more = ["--sections-mm", ",".join(map(repr, sections_mm))] if len(sections_mm) else []
    more += [] if window_turns is None else ["--trace-every", str(every)]

    def trace(file: str) -> dict[str, str]:
        names = [file, Path(file).with_suffix(".csv").name] if keeps_text else [file]
        return dict.fromkeys(names, "trace")

    files = {SURFACE: "surface", SECTIONS: "sections"}
    result = made_cut(
        *(table, [*words, *more]),
        tables=("surface", "sections"),
        files=files | trace(TRACE if window_turns is None else OVERVIEW),
        progress=_Progress(plan.machine_s) if plan.is_long else None,
    )
    if result.message:
        sys.stderr.write(f"camsim: {result.message}\n")
    if window_turns is not None:
        made_cut(table, [*words, "--turns-limit", repr(window_turns)], files=trace(TRACE))
    return result


def variant_of(name: str, summary: Json) -> CutVariant | None:
    """Return the controller's own error in a comparison cut, None when nothing was cut."""
    form = summary["control_error_um" if "control_error_um" in summary else "form_error_um"]
    if form["max"] is None:
        return None
    ended = "" if summary["end"] in ("done", "stopped") else f" (ended early: {summary['end']})"
    return CutVariant(name + ended, form["max"], form["rms"])


def compare(table: str, words: Sequence[str], window_turns: float | None) -> tuple[CutVariant, ...]:
    """Return the same cut with parts of the controller switched off, the complete one first."""
    limit = [] if window_turns is None else ["--turns-limit", repr(window_turns)]
    found = []
    for name, switches in _VARIANTS.items():
        with suppress(CamtoolsError):
            found.append(variant_of(name, made_cut(table, [*words, *limit, *switches]).summary))
    return tuple(variant for variant in found if variant is not None)
