"""A cut on the simulator, in this process: `simulate` for studies and notebooks, `cut` for tools.

    from camtools.sim.simulate import simulate
    result = simulate("out/perkins240.camtab", "rough", rpm=2500, turns=20)
    result.surface["error_nm"].max(), result.summary["form_error_um"]["max"]

The numbers are those that `camsim run` writes into its files, bit for bit. One cut runs at a time
in a process; many at once take processes.

>>> _words(2500.0, None, 20)
['--rpm', '2500.0', '--turns-limit', '20']
"""

import json
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camtools.base.errors import CamtoolsError
from camtools.base.text import Json
from camtools.sim.binding import NO_ROWS, Rows, SimSession, Table
from camtools.sim.machine_file import Machine, emit_machine, find_machine

if TYPE_CHECKING:
    from camtools.sim.table_file import TableFile

TICKS_AT_A_TIME = 100_000  # then Python looks for signals: 0.05 s
GROUP_ROWS = 1 << 16  # of a table that are written at once
_OPTIONS = {  # of camsim, and what they are called here
    "--rpm": "rpm",
    "--feed": "feed",
    "--turns-limit": "turns",
    "--seed": "seed",
    "--set": "set",
    "--machine": "machine",
}
TABLES = ("trace", "surface", "removal", "scallop", "sections")
_ONE_AT_A_TIME = threading.Lock()  # other threads wait


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """What a cut came to."""

    # That of `camsim run`: 0 good; 1 fault, time-out, out of tolerance or not gauged; 2 a command
    # was refused by the controller.
    status: int
    message: str  # why it is not good, "" when it is
    summary_text: str  # the summary file of `camsim run`
    tables: Mapping[str, Table]  # those that were asked for, by name

    def __repr__(self) -> str:
        """Return how it ended."""
        error = "none" if self.form_error_um is None else f"{self.form_error_um:.4g} um"
        return f"<Result status {self.status}, {self.summary['end']}, form error {error}>"

    def _rows(self, table: str) -> Rows:
        return self.tables.get(table, NO_ROWS).rows()

    @cached_property
    def surface(self) -> Rows:
        """Return the worst sample of each gauged cell, shape (n,).

        Fields are turn (drawing's angle, 0 .. 1), z_mm, radius_mm, error_nm (above 0: metal left
        standing), and control_nm where the table plays a refit.
        """
        return self._rows("surface")

    @cached_property
    def trace(self) -> Rows:
        """Return every tick, shape (n,), fields as in `host_sim/results/sim_tables.c`.

        `state` is the number of the controller's state in `firmware/base/cam_state.h`, masks are
        numbers.
        """
        return self._rows("trace")

    @cached_property
    def scallop(self) -> Rows:
        """Return the map of the surface between the tracks: fields turn, z_mm and proud_um."""
        return self._rows("scallop")

    @cached_property
    def removal(self) -> Rows:
        """Return the metal removed in slices of time."""
        return self._rows("removal")

    @cached_property
    def sections(self) -> Rows:
        """Return the true radius at even places: fields section, turn, z_mm, radius_mm, ..."""
        return self._rows("sections")

    @cached_property
    def summary(self) -> Json:
        """Return the summary as data; its keys are those of `camsim run --summary`."""
        summary: Json = json.loads(self.summary_text)
        return summary

    @property
    def form_error_um(self) -> float | None:
        """Return the largest form error against the drawing [um], none when nothing was gauged."""
        value: float | None = self.summary["form_error_um"]["max"]
        return value


def _machine(machine: str | Path | Machine | Mapping[str, Any] | None) -> Machine | None:
    if machine is None or isinstance(machine, Machine):
        return machine
    if isinstance(machine, str | Path):
        return find_machine(machine)
    return Machine("machine", emit_machine(machine))


def _own_name(option: re.Match[str]) -> str:
    return _OPTIONS[option[1]] + (f" = {option[2].strip()}" if option[2] else "")


@contextmanager
def _in_own_words(options: Sequence[str]) -> Iterator[None]:
    """Name what was wrong as `simulate` calls it, where the option was not given as such."""
    try:
        yield
    except CamtoolsError as error:
        own = [name for name in _OPTIONS if name not in options]
        begin = re.compile(rf"^({'|'.join(own)})( [^:]*)?(?=:)")
        raise CamtoolsError([begin.sub(_own_name, line) for line in error.lines]) from error


def _words(rpm: float | None, feed: float | None, turns: float | None) -> list[str]:
    given = {"--rpm": rpm, "--feed": feed, "--turns-limit": turns}
    return [
        word for key, value in given.items() if value is not None for word in (key, f"{value!r}")
    ]


@contextmanager
def begun(words: Sequence[str], machine: Machine | None = None) -> Iterator[SimSession]:
    """Begin a cut of the words of `camsim run`, table included; other threads wait for its end."""
    name, text = machine or ("", None)
    with _ONE_AT_A_TIME, SimSession() as session:
        session.begin(words, text, name)
        yield session


def cut(
    words: Sequence[str],
    machine: Machine | None = None,
    *,
    tables: Sequence[str] = (),
    files: Mapping[str, str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Cut what the words of `camsim run` describe, table included.

    Those of TABLES in `tables` come back as arrays. `files` names the table of each file to write,
    Parquet for .parquet, else CSV; rows that do not come back are written as they come. `progress`
    is given the share that is done, 0 .. 1, now and then, and 1 at the end. A cut that ends in a
    fault is a result. Raises CamtoolsError: what `camsim run` would refuse with exit status 2;
    OSError: a file cannot be written.
    """
    files = files or {}
    asked = dict.fromkeys([*tables, *files.values()])
    words = [*words, *(word for name in asked for word in (f"--{name}", name))]
    begin_s = time.monotonic()
    with begun(words, machine) as session, ExitStack() as stack:
        writers: list[tuple[str, TableFile]] = []
        if files:
            from camtools.sim.table_file import table_file  # pyarrow is slow to load

            for file, name in files.items():
                writer = table_file(Path(file), session.columns(name))
                stack.enter_context(writer)
                writers.append((name, writer))

        def write(found: Mapping[str, Table]) -> None:
            for name, writer in writers:
                if name in found:
                    writer.write(found[name].numbers)

        while session.run(TICKS_AT_A_TIME):
            write({name: session.take(name, GROUP_ROWS) for name in asked if name not in tables})
            if progress is not None:
                progress(session.progress())
        ending = session.finish(time.monotonic() - begin_s)
        found = {name: session.take(name) for name in asked}
        write(found)
        if progress is not None:
            progress(1.0)
    kept = {name: found[name] for name in tables}
    return Result(ending.status, ending.message, ending.summary_text, kept)


def simulate(
    table: str | Path,
    machine: str | Path | Machine | Mapping[str, Any] | None = None,
    *,
    rpm: float | None = None,
    feed: float | None = None,
    turns: float | None = None,
    set: Mapping[str, int] | None = None,
    seed: int = 1,
    trace: bool = False,
    scallop: bool = False,
    options: Sequence[str] = (),
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Cut a part on the simulator and gauge it; a cut that ends in a fault is a result.

    The gauge compares with NAME.json beside the table NAME.camtab, or where there is none with the
    table itself. A machine is the name of one of the project ("real"), the path of a machine file,
    its text with a name, or its tables: `{"u": {"bandwidth_hz": 270}}`.

    Speed and feed [mm per turn] are those of the table unless given. The cut ends after so many
    `turns` of cutting; those in which the feed then falls are gauged, too, and the full feed is
    reached after `feed_ramp_turns`, 60 while learning. `set` gives parameters of the controller by
    their names in `firmware/param/cam_param.h`, `options` any others of `camsim run --help`, such
    as `["--inject", "estop@0.5"]`.

    `trace` keeps every tick, 300 bytes each. `scallop` maps the surface between the tracks, and
    needs `--nose-mm` among the options. `progress` is given the share that is done, 0 .. 1, now and
    then. Raises CamtoolsError: what `camsim run` would refuse with exit status 2.
    """
    outputs = {f"--{name}" for name in (*TABLES, "summary")}
    for word in options:
        if word.split("=")[0] in outputs:
            raise CamtoolsError([f"{word}: results come back in memory; leave the option out"])
    settings = [
        word for name, value in (set or {}).items() for word in ("--set", f"{name}={value}")
    ]
    words = [str(table), *_words(rpm, feed, turns), "--seed", str(seed), *settings, *options]
    asked = {"surface": True, "trace": trace, "scallop": scallop}
    with _in_own_words(options):
        tables = [name for name, is_asked in asked.items() if is_asked]
        return cut(words, _machine(machine), tables=tables, progress=progress)
