"""The simulator as a process: one cut, its files, its errors.

>>> simulator = Simulator(Path("camsim"), Path(), "a.camtab")
>>> simulator.command(["--rpm", "600"])
['camsim', 'run', 'a.camtab', '--rpm', '600']
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from camtools.base.errors import CamtoolsError
from camtools.base.json_text import Json
from camtools.base.output import cannot_write
from camtools.base.project_paths import ROOT
from camtools.part.common import MachineLimits
from camtools.sim.results import CutVariant, read_summary

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
_PIPE_BYTES = 1 << 20


def camsim_path() -> Path:
    """Return where the simulator is built: the folder that CAMTURN_BUILD names, or build/host."""
    build = os.environ.get("CAMTURN_BUILD") or str(ROOT / "build" / "host")
    return Path(build).resolve() / "host_sim" / "camsim"


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
    """Where camsim is and where it works."""

    program: Path  # the executable
    folder: Path  # working folder: names of tables and results are relative to it
    table: str  # name of the table

    def command(self, words: Sequence[str]) -> list[str]:
        """Return the command line of a cut."""
        return [str(self.program), "run", self.table, *words]

    def run(self, words: Sequence[str], *, is_quiet: bool = False) -> int:
        """Cut; return camsim's exit status. Its messages go to our standard error.

        Raises
        ------
        CamtoolsError
            It cannot be started, or a signal ended it.
        """
        with self._begun(words, is_quiet=is_quiet) as process:
            return self._ended(process)

    def run_traced(
        self, words: Sequence[str], trace: str, *, is_quiet: bool = False, keeps_text: bool = False
    ) -> int:
        """Cut as `run` does, and write the trace as Parquet.

        Parameters
        ----------
        keeps_text : bool
            The text of camsim is kept beside it, with the suffix .csv.
        """
        if keeps_text:
            path = (self.folder / trace).with_suffix(".csv")
            status = self.run([*words, "--trace", path.name], is_quiet=is_quiet)
            if path.exists():
                with path.open("rb", buffering=_PIPE_BYTES) as text:
                    self._pack(text, trace)
            return status
        ours, theirs = os.pipe()
        with os.fdopen(ours, "rb", buffering=_PIPE_BYTES) as stream:
            try:
                words = [*words, "--trace", f"/dev/fd/{theirs}"]
                process = self._begun(words, is_quiet=is_quiet, pipe=theirs)
            finally:
                os.close(theirs)
            with process:
                try:
                    self._pack(stream, trace)
                except BaseException:
                    process.kill()
                    raise
                return self._ended(process)

    def _pack(self, stream: BinaryIO, trace: str) -> None:
        from camtools.sim.trace_file import pack_trace  # pyarrow, which making a table never needs

        try:
            pack_trace(stream, self.folder / trace)
        except OSError as error:
            raise cannot_write(self.folder.parent, error) from error

    def _begun(
        self, words: Sequence[str], *, is_quiet: bool, pipe: int | None = None
    ) -> subprocess.Popen[bytes]:
        silent = subprocess.DEVNULL
        try:
            return subprocess.Popen(
                self.command(words),
                cwd=self.folder,
                stdout=silent,
                stderr=silent if is_quiet else None,
                pass_fds=[] if pipe is None else [pipe],
            )
        except OSError as error:
            problem = f"{self.program}: cannot be started: {error.strerror}"
            raise CamtoolsError([f"{problem}; start tools/run, which builds it"]) from error

    def _ended(self, process: subprocess.Popen[bytes]) -> int:
        try:
            status = process.wait()
        except BaseException:
            process.kill()
            raise
        if status < 0:
            problem = f"{self.program}: ended by signal {-status}"
            raise CamtoolsError([f"{problem}; run it again, and report it when it comes back"])
        return status


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
) -> int:
    """Cut a part; write surface, summary and trace; return camsim's exit status.

    Parameters
    ----------
    window_turns : float or None
        The trace is of a second run that ends after so many turns; None: of the cut itself.
    every : int
        The overview of a longer cut holds one tick of so many.
    sections_mm : list of float
        Heights of sections, rising; none: those that camsim chooses.
    keeps_text : bool
        The traces are kept as CSV, too.
    shows_progress : bool
        Camsim tells on standard error how far it is.
    """
    results = ["--surface", SURFACE, "--summary", SUMMARY, "--sections", SECTIONS]
    results += ["--sections-mm", ",".join(map(repr, sections_mm))] if len(sections_mm) else []
    results += ["--progress"] if shows_progress else []
    if window_turns is None:
        return simulator.run_traced([*words, *results], TRACE, keeps_text=keeps_text)
    overview = [*words, *results, "--trace-every", str(every)]
    status = simulator.run_traced(overview, OVERVIEW, keeps_text=keeps_text)
    if status != 2:
        window = [*words, "--turns-limit", repr(window_turns)]
        simulator.run_traced(window, TRACE, is_quiet=True, keeps_text=keeps_text)
    return status


def variant_of(name: str, summary: Json) -> CutVariant | None:
    """Return what a comparison cut came to, nothing when it cut nothing.

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
        path = simulator.folder / "variant.json"
        status = simulator.run([*words, *switches, "--summary", path.name], is_quiet=True)
        if status == 2 or not path.exists():
            return None
        summary = read_summary(path)
        path.unlink()
        return variant_of(name, summary)

    found = [measured(*one) for one in _VARIANTS.items()]
    return tuple(variant for variant in found if variant is not None)
