"""Many cuts at once, by Dask: on all cores of this computer, or on a cluster.

>>> batches(["a", "b", "c"], 2)
[['a', 'b'], ['c']]
"""

import logging
import os
import signal
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING

from camtools.base.errors import CamtoolsError
from camtools.forecast.cuts import CutOutcome, Task, cut_batch

if TYPE_CHECKING:
    from distributed import Client, LocalCluster

_BATCH = 8  # cuts: what is lost of a worker that dies, a second or two
_CONNECT_S = 10.0


def batches(machines: Sequence[str], size: int = _BATCH) -> list[list[str]]:
    """Return machines in groups of a size, the last one smaller."""
    return [list(machines[at : at + size]) for at in range(0, len(machines), size)]


def _local(n_workers: int, folder: str) -> "LocalCluster":
    """Return processes of this computer. Ctrl-C is not theirs: they inherit that it is blocked."""
    from distributed import LocalCluster  # slow to load

    resource_tracker.ensure_running()  # would unblock it when it starts between
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
    groups = batches(machines)
    workers = min(n_workers or len(os.sched_getaffinity(0)), len(groups))
    if scheduler is None and workers == 1:
        for group in groups:
            take(_checked(cut_batch(task, group)))
        return
    from distributed import as_completed  # slow to load

    with _client(scheduler, workers) as client:
        shared = client.scatter(task, broadcast=True)
        futures = [client.submit(cut_batch, shared, group, pure=False) for group in groups]
        for future in as_completed(futures):
            error = future.exception()
            if error is not None:
                problem = f"a worker failed: {type(error).__name__}: {error}"
                raise CamtoolsError([f"{problem}; run it again; finished cuts are kept"])
            take(_checked(future.result()))
            future.release()


def _checked(answer: list[CutOutcome] | str) -> list[CutOutcome]:
    if isinstance(answer, str):
        raise CamtoolsError([answer])
    return answer
