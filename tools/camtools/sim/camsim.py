"""`camsim run` in this process: one cut, its files, its errors; and the cuts of tools/run.

>>> traced_turns(620, 2500), overview_every(62_000, 2500)
(None, 596)
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, chdir, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.json_text import Json
from camtools.base.output import cannot_write
from camtools.base.readable import duration_text
from camtools.part.common import MachineLimits
from camtools.sim.binding import Ending, SimSession, build_folder
from camtools.sim.results import CutVariant
from camtools.sim.simulate import ONE_AT_A_TIME, TABLES, TICKS_AT_A_TIME

if TYPE_CHECKING:
    from camtools.sim.trace_file import CsvFile, ParquetFile

TRACE, SURFACE, SUMMARY = "trace.parquet", "surface.csv", "summary.json"
SECTIONS = "sections.csv"
OVERVIEW = "overview.parquet"  # one tick of several of a cut too long to trace
_OVERVIEW_TICKS = 50_000
MAX_TRACED_TICKS = 500_000  # about 13 MB of trace, which came as 150 MB of text
_WINDOW_TURNS = 200  # at most of a longer cut, for trace and comparison
_TICK_HZ = 20_000  # of the default machine; good enough for an estimate
_INERTIA_KGM2 = 0.1  # of the default machine
# Learning makes up for what is missing, so each part is judged without it.
_VARIANTS = {
    "complete controller": [],
    "without learning": ["--no-learning"],
    "without learning and lead": ["--no-learning", "--no-lead"],
    "without learning and feed-forward": ["--no-learning", "--no-feed-forward"],
}

_MACHINE = """\
# The simulator's default machine with the limits of the part file.
[machine]
name = "{name}"
tick_hz = {tick_hz!r}
[spindle]
limit_rpm = {rpm!r}
torque_Nm = {torque!r}
inertia_kgm2 = {inertia!r}
bandwidth_rad_per_s = {bandwidth!r}
ripple = {ripple!r}
[u]
speed_mm_per_s = {speed!r}
acceleration_mm_per_s2 = {acceleration!r}
stroke_mm = {stroke!r}
[z]
speed_mm_per_s = {z_speed!r}
acceleration_mm_per_s2 = {z_acceleration!r}
"""
_WORN = """\
[tool]
wear_um = {!r}
[controller]
x_trim_nm = {}
"""
_NM_PER_UM = 1000
_LONG_TICKS = 3_000_000  # a few seconds of computing
_TRIAL_TICKS = 400_000
_GROUP_ROWS = 1 << 16  # of a table that are written at once
_SHOWN_EVERY_S, _LINE_EVERY_S = 0.2, 20.0  # progress on a terminal, and elsewhere


def camsim_path() -> Path:
    """Return where the program is built."""
    return build_folder() / "camsim"


def machine_text(limits: MachineLimits, wear_um: float = 0.0) -> str:
    """Return a machine file with a part's limits, as far as the simulator's ranges go.

    A worn tool stands back, and the controller's offset of X makes up for it.

    >>> print(*machine_text(MachineLimits(), 25.0).splitlines()[-4:], sep=" | ")
    [tool] | wear_um = 25.0 | [controller] | x_trim_nm = -25000
    """
    inertia = limits.spindle_inertia_kgm2 or _INERTIA_KGM2
    return _MACHINE.format(
        name="default, limits of the part file",
        tick_hz=limits.tick_hz,
        rpm=limits.spindle_rpm,
        torque=inertia * limits.alpha_rad_s2,
        inertia=inertia,
        bandwidth=limits.spindle_bandwidth_rad_s,
        ripple=limits.spindle_ripple,
        speed=min(max(limits.u_speed_mm_s, 0.1), 10_000.0),
        acceleration=min(max(limits.u_acceleration_mm_s2, 10.0), 1e7),
        stroke=limits.u_stroke_mm,
        z_speed=limits.z_speed_mm_s,
        z_acceleration=limits.z_acceleration_mm_s2,
    ) + (_WORN.format(wear_um, round(-wear_um * _NM_PER_UM)) if wear_um else "")


def traced_turns(turns: float, speed_rpm: float) -> float | None:
    """Return how many turns of a cut too long to trace are traced, nothing when all of it is.

    >>> traced_turns(620, 2500), traced_turns(62000, 2500), traced_turns(620, 60)
    (None, 200, 12.5)
    """
    ticks_per_turn = 60 / speed_rpm * _TICK_HZ
    if turns * ticks_per_turn <= MAX_TRACED_TICKS:
        return None
    return min(_WINDOW_TURNS, MAX_TRACED_TICKS / 2 / ticks_per_turn)


@dataclass(frozen=True)
class Simulator:
    """Where a table is, and where its results go."""

    folder: Path  # names of files in the words of camsim are relative to it
    table: str  # name of the table

    @contextmanager
    def begun(self, words: Sequence[str]) -> Iterator[SimSession]:
        """Begin a cut; the folder is the working folder until its end, and other threads wait.

        Raises
        ------
        CamtoolsError
            The simulator refuses it.
        """
        with ONE_AT_A_TIME, chdir(self.folder), SimSession() as session:
            session.begin([self.table, *words])
            yield session

    def run(
        self,
        words: Sequence[str],
        *,
        is_quiet: bool = False,
        keeps_text: bool = False,
        shows_progress: bool = False,
    ) -> Ending:
        """Cut, and write the outputs that the words name, as camsim does; .parquet is Parquet.

        Parameters
        ----------
        is_quiet : bool
            Do not say on standard error why a part is not good.
        keeps_text : bool
            Also write what is Parquet as CSV, with the suffix .csv.
        shows_progress : bool
            Report on standard error how much is done.

        Raises
        ------
        CamtoolsError
            The simulator refuses, or a file cannot be written.
        """
        begin_s = time.monotonic()
        try:
            with self.begun(words) as session, ExitStack() as stack:
                files = _Files(session, stack, keeps_text=keeps_text)
                progress = _Progress(session) if shows_progress else None
                while session.run(TICKS_AT_A_TIME):
                    files.write(_GROUP_ROWS)
                    if progress is not None:
                        progress.show()
                if progress is not None:
                    progress.show(is_end=True)
                ending = session.finish(time.monotonic() - begin_s)
                if ending.status == BAD_INPUT:
                    raise CamtoolsError([ending.message])
                files.write()
                summary = session.path("summary")
                if summary is not None:
                    Path(summary).write_text(ending.summary_text, encoding="ascii")
        except OSError as error:
            raise cannot_write(self.folder.parent, error) from error
        if ending.message and not is_quiet:
            sys.stderr.write(f"camsim: {ending.message}\n")
        return ending


class _Files:
    """The tables of a cut that its words name."""

    def __init__(self, session: SimSession, stack: ExitStack, *, keeps_text: bool) -> None:
        self._session = session
        self._of: dict[str, list[CsvFile | ParquetFile]] = {}
        for name in TABLES:
            named, columns = session.path(name), session.columns(name)
            if named is None:
                continue
            from camtools.sim.trace_file import CsvFile, ParquetFile  # pyarrow is slow to load

            path, files = Path(named), self._of.setdefault(name, [])
            is_packed = path.suffix == ".parquet"
            if is_packed:
                files.append(stack.enter_context(ParquetFile(path, columns)))
            if keeps_text or not is_packed:
                text = CsvFile(path.with_suffix(".csv") if is_packed else path, columns)
                files.append(stack.enter_context(text))

    def write(self, at_least: int = 0) -> None:
        """Write the rows of each table, unless there are fewer."""
        for name, files in self._of.items():
            numbers = self._session.take(name, at_least).numbers
            for file in files:
                file.write(numbers)


class _Progress:
    """How much of a cut is done, in place on a terminal, else in a line now and then."""

    def __init__(self, session: SimSession) -> None:
        self._session = session
        self._begin_s = self._shown_s = time.monotonic()
        self._is_terminal = sys.stderr.isatty()

    def show(self, *, is_end: bool = False) -> None:
        """Report it, when it is time to."""
        now_s = time.monotonic()
        if not is_end and now_s < self._shown_s + (
            _SHOWN_EVERY_S if self._is_terminal else _LINE_EVERY_S
        ):
            return
        self._shown_s = now_s
        share = 1.0 if is_end else self._session.progress()
        _, machine_s, _ = self._session.plan()
        left_s = (now_s - self._begin_s) * (1 / share - 1) if share else 0.0
        begin = "\r" if self._is_terminal else ""
        end = "   " if self._is_terminal and not is_end else "\n"
        done = f"{100 * share:5.1f} %, {share * machine_s:.1f} s of machine time"
        sys.stderr.write(f"{begin}camsim: {done}, about {left_s:.0f} s left{end}")
        sys.stderr.flush()


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


def plan_of(simulator: Simulator, words: Sequence[str]) -> CutPlan:
    """Return what a cut will take.

    Raises
    ------
    CamtoolsError
        The simulator refuses it.
    """
    with simulator.begun(words) as session:
        plan = CutPlan(*session.plan())
        if not plan.is_long:
            return plan
        begin_s = time.monotonic()
        session.run(_TRIAL_TICKS)
        tick_s = (time.monotonic() - begin_s) / _TRIAL_TICKS
    return plan._replace(computing_s=plan.machine_s * plan.tick_hz * tick_s)


def overview_every(turns: float, speed_rpm: float) -> int:
    """Return of how many ticks the overview of a long cut holds one.

    >>> overview_every(62_000, 2500)
    596
    """
    return int(turns * 60 / speed_rpm * _TICK_HZ / _OVERVIEW_TICKS) + 1


def cut(
    simulator: Simulator,
    words: Sequence[str],
    window_turns: float | None,
    every: int = 1,
    *,
    sections_mm: Sequence[float] = (),
    keeps_text: bool = False,
    shows_progress: bool = False,
) -> Json:
    """Cut a part; write surface, sections, summary and trace; return the summary.

    Parameters
    ----------
    window_turns : float or None
        The trace is of a second run that ends after so many turns; None: of the cut itself.
    every : int
        The overview of a longer cut holds one tick of so many.
    sections_mm : list of float
        Heights of sections, rising; none: those that camsim chooses.
    keeps_text : bool
        Also write the traces as CSV.
    shows_progress : bool
        Report on standard error how much is done.
    """
    results = ["--surface", SURFACE, "--summary", SUMMARY, "--sections", SECTIONS]
    results += ["--sections-mm", ",".join(map(repr, sections_mm))] if len(sections_mm) else []
    if window_turns is None:
        results += ["--trace", TRACE]
    else:
        results += ["--trace-every", str(every), "--trace", OVERVIEW]
    ending = simulator.run([*words, *results], keeps_text=keeps_text, shows_progress=shows_progress)
    if window_turns is not None:
        window = [*words, "--turns-limit", repr(window_turns), "--trace", TRACE]
        simulator.run(window, is_quiet=True, keeps_text=keeps_text)
    return ending.summary


def variant_of(name: str, summary: Json) -> CutVariant | None:
    """Return the result of a comparison cut, None when nothing was cut.

    The controller is compared, so its own error counts, not that of a refit.
    """
    form = summary["control_error_um" if "control_error_um" in summary else "form_error_um"]
    if form["max"] is None:
        return None
    ended = "" if summary["end"] in ("done", "stopped") else f" (ended early: {summary['end']})"
    return CutVariant(name + ended, form["max"], form["rms"])


def compare(
    simulator: Simulator, words: Sequence[str], window_turns: float | None
) -> tuple[CutVariant, ...]:
    """Return the same cut with parts of the controller switched off, the complete one first."""
    if window_turns is not None:
        words = [*words, "--turns-limit", repr(window_turns)]

    def measured(name: str, switches: Sequence[str]) -> CutVariant | None:
        try:
            ending = simulator.run([*words, *switches], is_quiet=True)
        except CamtoolsError:
            return None
        return variant_of(name, ending.summary)

    found = [measured(*one) for one in _VARIANTS.items()]
    return tuple(variant for variant in found if variant is not None)
