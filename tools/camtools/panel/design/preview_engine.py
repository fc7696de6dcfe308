"""Previews in processes of their own: the newest change wins, and none can stall the panel.

Every page has a `Seat`. Its newest request is given to a process that is free, if possible the one
that served the seat last; a request that a newer one overtakes is dropped, also while it is
computed. A process that takes too long, too much memory, or dies is replaced; its page shows that.

>>> PreviewLimits().time_s
20.0
"""

import asyncio
import json
import signal
import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.project import child_environment

Answer = dict[str, Any]
OnAnswer = Callable[[Answer], None]

_LINE_BYTES = 64 << 20  # of an answer; a process that says more is broken
_MOST_WAITING = 20  # edits of one page
_WORKER = "camtools.panel.design.preview_worker"


class PreviewLimits(NamedTuple):
    """What computing a preview may take."""

    workers: int = 2  # processes that are kept ready: while one is replaced the others serve
    time_s: float = 20.0  # until a request is given up [s]
    memory_mb: int = 2048  # address space of a process [MB]
    start_s: float = 60.0  # until a new process is ready [s]


@dataclass(eq=False)
class _Job:
    seat: "Seat"
    request: Answer
    is_droppable: bool
    on_answer: OnAnswer
    is_overtaken: bool = False
    is_heard: bool = False  # the process has answered something
    is_second: bool = False  # the process of the first try had ended meanwhile


class Seat:
    """A page at the engine; made by `Engine.seat`."""

    def __init__(self, engine: "Engine", on_answer: OnAnswer) -> None:
        self._engine, self._on_answer = engine, on_answer
        self.waiting: deque[_Job] = deque()
        self.is_open = True

    def preview(self, text: str, folder: str, height_mm: float | None) -> None:
        """Ask for the preview of a text; one that is asked for earlier is dropped.

        Files are read from the folder alone; the section is in the middle by default.
        """
        request = {"do": "preview", "text": text, "folder": folder, "height_mm": height_mm}
        self._engine.submit(_Job(self, request, True, self._on_answer))

    async def edit(self, text: str, path: list[str | int], value: object) -> str:
        """Return the text with a field changed; raise CamtoolsError where the form cannot."""
        found: asyncio.Future[str] = asyncio.get_running_loop().create_future()

        def take(answer: Answer) -> None:
            if found.done():
                return
            if answer["stage"] == "text":
                found.set_result(answer["text"])
            elif answer["stage"] in ("problems", "lost", "done"):
                lines = [problem["text"] for problem in answer.get("problems", [])]
                found.set_exception(CamtoolsError(lines or ["the change was lost; try again"]))

        request = {"do": "edit", "text": text, "path": path, "value": value}
        self._engine.submit(_Job(self, request, False, take))
        return await found

    def close(self) -> None:
        """Give the seat back: nothing that it asked for is answered any more."""
        self.is_open = False
        self._engine.leave(self)


@dataclass(eq=False)
class _Worker:
    process: asyncio.subprocess.Process
    job: _Job | None = None
    last: Seat | None = None
    number: int = 0


class Engine:
    """Processes that compute previews."""

    def __init__(self, limits: PreviewLimits | None = None) -> None:
        self.limits = limits or PreviewLimits()
        self._seats: list[Seat] = []
        self._idle: list[_Worker] = []
        self._busy: list[_Worker] = []
        self._tasks: set[asyncio.Task[None]] = set()
        self._is_started = False
        self._is_closed = False

    def seat(self, on_answer: OnAnswer) -> Seat:
        """Return a new seat; answers come as calls of `on_answer` in the event loop that runs."""
        seat = Seat(self, on_answer)
        self._seats.append(seat)
        if not self._is_started:
            self._is_started = True
            for _ in range(self.limits.workers):
                self._begin(self._spawn())
        return seat

    def submit(self, job: _Job) -> None:
        """Take a request; for `Seat`."""
        if not job.seat.is_open or self._is_closed:
            return
        waiting = job.seat.waiting
        if job.is_droppable:
            for old in [old for old in waiting if old.is_droppable]:
                waiting.remove(old)
            self._overtake(job.seat)
        elif len(waiting) >= _MOST_WAITING:
            job.on_answer({"stage": "lost", "problems": []})
            return
        waiting.append(job)
        self._dispatch()

    def leave(self, seat: Seat) -> None:
        """Forget a seat; for `Seat`."""
        seat.waiting.clear()
        if seat in self._seats:
            self._seats.remove(seat)
        self._overtake(seat)

    async def close(self) -> None:
        """End all processes."""
        self._is_closed = True
        for worker in self._busy:  # their tasks hear that they are gone
            with suppress(ProcessLookupError):
                worker.process.kill()
        while self._tasks:
            await asyncio.gather(*self._tasks, return_exceptions=True)
        for worker in self._idle:
            await _killed(worker.process)

    def _overtake(self, seat: Seat) -> None:
        """Drop what is computed for a seat, where it may be dropped."""
        for worker in self._busy:
            job = worker.job
            if job is not None and job.seat is seat and job.is_droppable and not job.is_overtaken:
                job.is_overtaken = True
                with suppress(ProcessLookupError):
                    worker.process.send_signal(signal.SIGUSR1)

    def _dispatch(self) -> None:
        """Give waiting requests to idle processes, one at a time of each seat."""
        served = {worker.job.seat for worker in self._busy if worker.job is not None}
        for seat in list(self._seats):
            if not self._idle:
                return
            if seat.waiting and seat not in served:
                at = next((i for i, worker in enumerate(self._idle) if worker.last is seat), 0)
                worker = self._idle.pop(at)
                worker.job, worker.last = seat.waiting.popleft(), seat
                self._busy.append(worker)
                # a seat that was served goes to the end of the queue
                self._seats.remove(seat)
                self._seats.append(seat)
                self._begin(self._serve(worker))

    def _begin(self, work: Any) -> None:  # noqa: ANN401 (a coroutine)
        task: asyncio.Task[None] = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _spawn(self) -> None:
        environment = child_environment() | {"PYTHONDONTWRITEBYTECODE": "1"}  # it writes no file
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", _WORKER, str(self.limits.memory_mb)),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            limit=_LINE_BYTES,
            env=environment,
        )
        worker = _Worker(process)
        self._busy.append(worker)
        if self._is_closed:
            process.kill()
        answer: Answer | None = None
        with suppress(TimeoutError):
            answer = await asyncio.wait_for(_heard(worker), self.limits.start_s)
        self._busy.remove(worker)
        if answer is None or self._is_closed:
            await _killed(process)
            if not self._is_closed:
                await asyncio.sleep(1.0)  # a computer without memory is not asked again at once
                self._begin(self._spawn())
            return
        self._idle.append(worker)
        self._dispatch()

    async def _serve(self, worker: _Worker) -> None:
        """Let a process answer its request; replace it where it does not."""
        job = worker.job
        assert job is not None
        worker.number += 1
        problem = "the preview's process ended; it is started anew"
        try:
            assert worker.process.stdin is not None
            line = json.dumps(job.request | {"id": worker.number}).encode("ascii") + b"\n"
            worker.process.stdin.write(line)
            is_done = await asyncio.wait_for(self._listen(worker, job), self.limits.time_s)
        except TimeoutError:
            is_done = False
            problem = f"takes more than {self.limits.time_s:g} s; give fewer points, lobes or waves"
        except (OSError, ValueError):  # a pipe that is gone, a line too long or no JSON
            is_done = False
        self._busy.remove(worker)
        worker.job = None
        if is_done:
            self._idle.append(worker)
        else:
            if not job.is_heard and not job.is_second and problem.endswith("anew"):
                job.is_second = True  # nobody knew that this process was gone
                job.seat.waiting.appendleft(job)
            elif not job.is_overtaken and job.seat.is_open:
                shown = {"field": "", "line": None, "text": problem}
                job.on_answer({"stage": "lost", "problems": [shown]})
            await _killed(worker.process)
            if not self._is_closed:
                self._begin(self._spawn())
        self._dispatch()

    async def _listen(self, worker: _Worker, job: _Job) -> bool:
        """Pass answers on until the last one; return whether it came."""
        while True:
            answer = await _heard(worker)
            if answer is None:
                return False
            if answer["id"] != worker.number:
                continue
            job.is_heard = True
            if not job.is_overtaken and job.seat.is_open:
                job.on_answer(answer)
            if answer["stage"] == "done":
                return True


async def _heard(worker: _Worker) -> Answer | None:
    """Return the next line of a process; None where it has ended."""
    assert worker.process.stdout is not None
    line = await worker.process.stdout.readline()
    found: Answer | None = json.loads(line) if line else None
    return found


async def _killed(process: asyncio.subprocess.Process) -> None:
    with suppress(ProcessLookupError):
        process.kill()
    await process.communicate()
