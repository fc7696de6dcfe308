"""Cuts of a forecast: made here or on a cluster by Dask, stored under the digest of their inputs.

A worker gets bytes, not paths: it keeps the table in a folder of its own, which ends with it. Every
batch becomes a file of its own, which appears complete or not at all; a forecast that was stopped
continues with the cuts that are missing.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     store = Store(Path(name))
...     store.add([CutOutcome("a", "done", 0, "", "", 0.1, 0.05, 0.1, 0.1, 1000, 0.2)])
...     Store(Path(name)).found["a"].form_max_um
0.1
"""

import atexit
import hashlib
import json
import logging
import os
import shutil
import signal
import tempfile
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from math import nan
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, get_type_hints

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camtools.base.command import no_warnings
from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import write_all
from camtools.base.parquet import parquet_bytes
from camtools.base.project import library_path
from camtools.pipeline.load import Made
from camtools.report.sheet import sizes_of
from camtools.sim.drawn_parts import part_bytes
from camtools.sim.machine_file import Machine
from camtools.sim.results import AnyCut, Cut, CutTrace, GaugedSurface, sections_of
from camtools.sim.simulate import Result, cut

if TYPE_CHECKING:
    from distributed import Client, LocalCluster

TABLE, DESIGN = "part.camtab", "part.json"
_BATCH = 8  # cuts; a worker that dies loses one batch, a second or two of work
_CONNECT_S = 10.0


class Task(NamedTuple):
    """What all cuts of a forecast share."""

    table: bytes  # content of the table
    design: bytes  # content of its report
    words: tuple[str, ...]  # options of camsim
    build: str  # digest of the simulator that all cuts are to be made by
    sheets: Made | None = None  # the part, if its features are to be gauged as on its sheets

    def key(self, machine: str) -> str:
        """Return what a cut depends on, as one digest."""
        parts = [self.table, self.design, "\0".join(self.words).encode(), self.build.encode()]
        parts += [] if self.sheets is None else [part_bytes(self.sheets.table.part)]
        digest = hashlib.sha256()
        for part in (*parts, machine.encode()):
            digest.update(len(part).to_bytes(8, "little"))
            digest.update(part)
        return digest.hexdigest()


class CutOutcome(NamedTuple):
    """What one cut came to; NaN where nothing was gauged."""

    key: str  # digest of all that it depends on
    end: str  # as in the summary; "refused" also where the simulator refused machine or speed
    status: int  # exit status of camsim
    faults: str  # names of the first faults, separated by blanks
    message: str  # why it is not good
    form_max_um: float
    form_rms_um: float
    roundness_um: float
    following_max_um: float
    ticks: int  # that the cut took
    wall_s: float  # computing time
    features: str = ""  # sizes of the sheets by their names, as JSON; empty: not asked for

    @property
    def is_gauged(self) -> bool:
        """Return whether the cut came to its end and was gauged."""
        return self.end in ("done", "stopped") and self.form_max_um == self.form_max_um


@cache
def build_of(path: Path) -> str:
    """Return the digest of a simulator's library. Raises `CamtoolsError`: it is not there."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    except OSError as error:
        problem = f"cannot be read: {error.strerror}; start tools/run, which builds it"
        raise CamtoolsError([f"{path}: {problem}"]) from error


@cache
def folder_of(table: bytes, design: bytes) -> Path:
    """Return a folder of this process with a table and its report."""
    folder = Path(tempfile.mkdtemp(prefix="camturn-forecast."))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / TABLE).write_bytes(table)
    (folder / DESIGN).write_bytes(design)
    return folder


def _features(made: Made, result: Result) -> str:
    """Return the sizes on the sheets of a cut."""
    nothing = np.empty(0)
    surface, trace = GaugedSurface(*[nothing] * 4), CutTrace(*[nothing] * 10)
    sections = sections_of(result.sections)
    seen: AnyCut = Cut(made.table, result.summary, surface, trace, sections=sections)
    return json.dumps(sizes_of(seen, made.kind.report().subject(seen)))


def _outcome(key: str, result: Result, made: Made | None) -> CutOutcome:
    summary = result.summary
    form, following = summary["form_error_um"], summary["following_error_um"]
    values = (form["max"], form["rms"], form["roundness"], following["max"])
    faults = " ".join(summary.get("first_faults", []))
    largest, rms, roundness, late = (nan if value is None else float(value) for value in values)
    outcome = CutOutcome(
        key, summary["end"], result.status, faults, result.message,
        largest, rms, roundness, late, int(summary["ticks"]), float(summary["wall_time_s"]),
    )  # fmt: skip
    if made is None or not outcome.is_gauged:
        return outcome
    return outcome._replace(features=_features(made, result))


def cut_one(task: Task, machine: str) -> CutOutcome:
    """Cut on one machine; what the simulator refuses is an outcome, too."""
    key = task.key(machine)
    words = [str(folder_of(task.table, task.design) / TABLE), *task.words]
    if task.sheets is not None:  # parts differ in the noise of the encoder, too
        words += ["--seed", str(int(key[:8], 16))]
    tables = ("surface",) if task.sheets is None else ("surface", "sections")
    try:
        result = cut(words, Machine("machine", machine), tables=tables)
    except CamtoolsError as error:
        return CutOutcome(key, "refused", 2, "", str(error), nan, nan, nan, nan, 0, 0.0)
    return _outcome(key, result, task.sheets)


def cut_batch(task: Task, machines: Sequence[str]) -> list[CutOutcome]:
    """Cut on some machines, one after the other; raise where the simulator is another build."""
    no_warnings()
    here = build_of(library_path("camsim"))
    if here != task.build:
        problem = f"a worker has another simulator ({here}, not {task.build})"
        raise CamtoolsError([f"{problem}; build the same version on every computer"])
    return [cut_one(task, machine) for machine in machines]


def _local(n_workers: int, folder: str) -> "LocalCluster":
    """Start workers on this computer; they inherit a blocked SIGINT: control-C ends only this."""
    from distributed import LocalCluster  # slow to load

    resource_tracker.ensure_running()  # started later, it would unblock SIGINT
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return LocalCluster(
            n_workers=n_workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            local_directory=folder,
            silence_logs=logging.CRITICAL,
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _client(scheduler: str | None, n_workers: int) -> Iterator["Client"]:
    """Connect to a cluster, or start one on this computer, which ends with it."""
    import dask  # slow to load
    from distributed import Client

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with ExitStack() as stack:
        stack.enter_context(dask.config.set({"logging.distributed": "critical"}))
        if scheduler is None:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="camturn-dask."))
            cluster = stack.enter_context(_local(n_workers, folder))
            yield stack.enter_context(Client(cluster))
            return
        try:
            client = stack.enter_context(Client(scheduler, timeout=_CONNECT_S))
        except (OSError, TimeoutError, ValueError) as error:
            problem = f"--scheduler {scheduler}: does not answer"
            raise CamtoolsError([f"{problem}; give tcp://HOST:PORT of a dask scheduler"]) from error
        if not client.scheduler_info()["workers"]:
            problem = f"--scheduler {scheduler}: has no worker"
            raise CamtoolsError([f"{problem}; start `dask worker {scheduler}` on a computer"])
        yield client


def cut_all(
    task: Task,
    machines: Sequence[str],
    take: Callable[[list[CutOutcome]], None],
    *,
    scheduler: str | None = None,
    n_workers: int | None = None,
) -> None:
    """Cut on every machine, here or on a Dask cluster; `take` gets outcomes, batch by batch."""
    if not machines:
        return
    groups = [list(machines[at : at + _BATCH]) for at in range(0, len(machines), _BATCH)]
    workers = min(n_workers or len(os.sched_getaffinity(0)), len(groups))
    if scheduler is None and workers == 1:
        for group in groups:
            take(cut_batch(task, group))
        return
    from distributed import as_completed  # slow to load

    with _client(scheduler, workers) as client:
        shared = client.scatter(task, broadcast=True)
        futures = [client.submit(cut_batch, shared, group, pure=False) for group in groups]
        for future in as_completed(futures):
            error = future.exception()
            if isinstance(error, CamtoolsError):
                raise error
            if error is not None:
                problem = f"a worker failed: {type(error).__name__}: {error}"
                raise CamtoolsError([f"{problem}; run it again; finished cuts are kept"])
            take(future.result())
            future.release()


_KINDS = {str: pa.string(), float: pa.float64(), int: pa.int64()}
_FIELDS = {name: _KINDS[kind] for name, kind in get_type_hints(CutOutcome).items()}
SCHEMA = pa.schema([*(_FIELDS | {"status": pa.int32()}).items()])


class Store:
    """Outcomes in a folder, created by the first batch; refuses foreign Parquet files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.found: dict[str, CutOutcome] = {}  # by key
        self._paths = sorted(folder.glob("*.parquet"))
        for path in self._paths:
            self.found |= {outcome.key: outcome for outcome in _read(path)}

    def add(self, outcomes: Sequence[CutOutcome]) -> None:
        """Keep outcomes; they are on the disk on return."""
        name = f"{uuid.uuid4().hex}.parquet"
        columns = {field: [getattr(outcome, field) for outcome in outcomes] for field in _FIELDS}
        write_all(self.folder, {name: parquet_bytes(columns, SCHEMA, {})})
        self._paths.append(self.folder / name)
        self.found |= {outcome.key: outcome for outcome in outcomes}

    def pick(self, keys: Iterable[str]) -> list[CutOutcome]:
        """Return the outcomes of these keys that are there."""
        return [self.found[key] for key in keys if key in self.found]

    def compact(self) -> None:
        """Make one file of many."""
        before = self._paths
        if len(before) > 1:
            self.add(list(self.found.values()))
            self._paths = self._paths[-1:]
            for path in set(before) - set(self._paths):
                with suppress(OSError):
                    path.unlink()


def _read(path: Path) -> list[CutOutcome]:
    try:
        rows = pq.read_table(path, schema=SCHEMA).to_pylist()
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        problem = f"not a result of tools/forecast: {reason}"
        remedy = "remove it; its cuts are repeated"
        raise InputError(str(path), "", None, problem, remedy) from error
    return [CutOutcome(**row | {"features": row["features"] or ""}) for row in rows]
