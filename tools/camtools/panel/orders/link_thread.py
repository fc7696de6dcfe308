"""The thread that owns the link: it keeps the status fresh and does one job after the other.

An urgent job breaks off the one that runs, wherever it waits for a frame, and those that wait are
dropped. A job that is attended ends likewise when its visitor may not give it any more.
While no controller is heard the bus is closed and opened again, once a second.

>>> job = Job("start", {}, Visitor("v1"))
>>> job.tell(False, "busy"); job.tell(True, "start: engaging")
>>> job.outcome.result()
Outcome(is_done=False, text='busy')
"""

import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from camtools.base.errors import CamtoolsError
from camtools.link.controller import SILENT_S, Link, Status
from camtools.link.kept_values import INFOS
from camtools.link.lessons import Convergence
from camtools.link.messages import NUMBERS, Refused
from camtools.link.refusal_text import ask_done
from camtools.link.rights import CommandHeld, May, sender_of
from camtools.panel.orders.commander import Visitor
from camtools.panel.orders.execute_order import ACTIONS
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.snapshot import SILENT, ParameterSet, Snapshot, parameter_set

LOOK_S = 0.02  # longest wait before the next job is looked for
SHOW_S = 0.05  # between two snapshots
GONE_S = 2.0  # without status: the bus is opened anew
AGAIN_S = 1.0
TAKE_S = 0.5  # between two tries to take command that another has
PATIENCE_S = 2.0  # longest time that a job waits for its turn
WATCHED_S = 2.0  # how long a page that asked for something is taken to look at it
PARAMETERS_AT_ONCE = 10
NOT_HEARD = "the controller does not answer; use the emergency stop at the machine"
OpenLink = Callable[[], Link]


class _Overtaken(Exception):  # noqa: N818 - no error: it ends what runs
    """An urgent job waits, or the running one may not continue; the text says which."""


@dataclass(eq=False)
class Job:
    """An order with checked arguments, on its way through the thread."""

    name: str
    arguments: Mapping[str, Any]
    visitor: Visitor
    is_urgent: bool = False  # whether it overtakes
    still_allowed: Callable[[], str] = lambda: ""  # when its turn comes; why not, or ""
    is_attended: bool = False  # whether it ends when that is no longer so
    outcome: Future[Outcome] = field(default_factory=Future)  # gets the outcome
    given_s: float = field(default_factory=time.monotonic)

    def leave(self) -> None:
        """Let it finish without its visitor, because nothing moves any more."""
        self.is_attended = False

    def tell(self, is_done: bool, text: str) -> None:
        """Say what came of it, once."""
        if not self.outcome.done():
            self.outcome.set_result(Outcome(is_done, text))


class LinkThread:
    """Owner of the link, with `open_link` as in ControllerService.

    While somebody at the panel wants command, the thread takes it over the controller when nobody
    has it, and keeps it by its heartbeats. `on_lost` is called with why it was lost and who has
    it, 0: nobody.
    """

    def __init__(
        self,
        open_link: OpenLink,
        wants_command: Callable[[], bool],
        on_lost: Callable[[str, int], None],
    ) -> None:
        self._open_link = open_link
        self._wants_command, self._on_lost = wants_command, on_lost
        self._has_command, self._take_again_s = False, 0.0
        self._snapshot, self._work = SILENT, ""
        self._jobs: deque[Job] = deque()
        self._urgent: deque[Job] = deque()
        self._is_breaking = False
        self._running: Job | None = None
        self._shown_s = 0.0
        self._convergence = Convergence()
        self.lessons = self._convergence.lessons  # how the error fell, as far as the status showed
        self._parameters_asked_s = -1e9
        self._parameters: ParameterSet | None = None
        self._partial: dict[str, int] = {}
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="link", daemon=True)
        self._thread.start()

    # From any thread

    def snapshot(self) -> Snapshot:
        """Return the newest status; never waits."""
        newest = self._snapshot
        if newest.is_connected and time.monotonic() - newest.at_s > SILENT_S + SHOW_S:
            problem = f"{newest.where}: the controller does not answer; check its power and the bus"
            return replace(newest, is_connected=False, state="unknown", problem=problem)
        return replace(newest, work=self._work, has_command=self._has_command)

    def parameters(self) -> ParameterSet | None:
        """Return all parameters; while this is called they are read, anew when one changes."""
        self._parameters_asked_s = time.monotonic()
        return self._parameters

    def give(self, job: Job) -> None:
        """Hand a job over; its future gets an outcome, whatever happens."""
        if not self.snapshot().is_connected:
            job.tell(False, f"not sent: {self.snapshot().problem}; {NOT_HEARD}")
        elif job.is_urgent:
            self._urgent.append(job)
        elif self._work:
            job.tell(False, f"busy with {self._work}; wait, or stop it")
        else:
            self._jobs.append(job)

    def close(self) -> None:
        """End the thread and close the bus."""
        self._is_over.set()
        self._thread.join()

    # In the thread

    def _run(self) -> None:
        while not self._is_over.is_set():
            try:
                link = self._open_link()
            except CamtoolsError as error:
                self._snapshot = replace(SILENT, problem=str(error))
            else:
                try:
                    self._serve(link)
                except Exception as error:  # whatever it is: stop must be possible again at once
                    self._snapshot = replace(SILENT, where=link.where, problem=str(error))
                    if not isinstance(error, Refused | CamtoolsError | OSError):
                        traceback.print_exc()
                finally:
                    self._end(link)
            self._is_over.wait(AGAIN_S)

    def _end(self, link: Link) -> None:
        """Give command back, as far as that is heard, and close the bus."""
        link.rights.on_lost = lambda text, holder: None
        if time.monotonic() - link.status.at_s < SILENT_S:
            link.on_wait = lambda: None
            with suppress(Exception):  # the bus may be gone
                link.rights.release()
        self._has_command = False
        self._work, self._parameters = "", None
        self._partial.clear()
        link.on_wait = lambda: None
        self._drop_all()
        with suppress(Exception):  # a driver of strangers raises what it likes
            link.bus.shutdown()

    def _drop_all(self) -> None:
        for waiting in (self._urgent, self._jobs):
            while waiting:
                waiting.popleft().tell(False, f"not sent: {NOT_HEARD}")

    def _serve(self, link: Link) -> None:
        """Work until the controller is silent, or the panel ends."""
        self._drop_all()  # given to the last connection in the moment in which it broke
        link.on_row, link.on_wait = (lambda status: self._show(link, status)), self._look
        self._begin_rights(link)
        with suppress(_Overtaken):
            link.listen()
        while not self._is_over.is_set():
            self._is_breaking = bool(self._urgent)
            with suppress(_Overtaken):
                if self._urgent:
                    while self._urgent:  # what waited after them is dropped
                        urgent = self._urgent.popleft()
                        while self._jobs:
                            self._jobs.popleft().tell(False, f"not done: {urgent.name} came first")
                        self._carry_out(link, urgent)
                elif self._jobs:
                    self._carry_out(link, self._jobs.popleft())
                else:
                    self._look_after(link)
                    link.pump(LOOK_S)
            if time.monotonic() - link.status.at_s > GONE_S:
                problem = "the controller does not answer; check its power and the bus"
                raise Refused(f"{link.where}: {problem}")

    def _why_over(self) -> str:
        """Return why the running job must end, "" when it may continue."""
        if self._urgent:
            return f"interrupted by {self._urgent[0].name}"
        if self._is_over.is_set():
            return "interrupted by the end of the panel"
        job = self._running
        why = job.still_allowed() if job is not None and job.is_attended else ""
        return why and f"interrupted: {why}"

    def _look(self) -> None:
        """End what runs when there is a reason."""
        if not self._is_breaking and (why := self._why_over()):
            self._is_breaking = True  # once: what brakes on its way out gets through
            raise _Overtaken(why)

    def _show(self, link: Link, status: Status) -> None:
        now_s = time.monotonic()
        if now_s - self._shown_s >= SHOW_S:
            self._shown_s = now_s
            self._snapshot = Snapshot(
                is_connected=True,
                where=link.where,
                signals=MappingProxyType(dict(status.signals)),
                state=status.state,
                faults=tuple(status.faults),
                table_name=status.table_name,
                at_s=status.at_s,
                problem="",
                work=self._work,
                has_command=self._has_command,
            )
            self._convergence.add(status.signals)

    def _carry_out(self, link: Link, job: Job) -> None:
        late = time.monotonic() - job.given_s > PATIENCE_S
        problem = "not done: the order waited too long; try again" if late else job.still_allowed()
        if problem and not job.is_urgent:
            job.tell(False, problem)
            return
        outcome = Outcome(False, "failed; see the terminal of tools/panel")
        self._running = job
        try:
            if job.is_urgent:
                link.rights.may = May.TAKE_OVER  # who stops asks nobody
            else:
                self._take_again_s = 0.0  # who commands waits for no next try
                self._look_after_command(link)
            outcome = Outcome(True, ACTIONS[job.name](link, job.arguments, self._say))
        except (Refused, CamtoolsError) as error:
            outcome = Outcome(False, str(error))
        except _Overtaken as overtaken:
            outcome = Outcome(False, str(overtaken))
            raise
        finally:
            self._running = None
            link.rights.may = May.NEVER
            self._work = ""
            job.tell(outcome.is_done, outcome.text)

    def _say(self, work: str) -> None:
        self._work = work

    def _begin_rights(self, link: Link) -> None:
        """Command is taken where somebody at the panel wants it, and by nothing else."""
        rights = link.rights
        rights.may, rights.sender = May.NEVER, sender_of("panel")

        def has_changed() -> None:
            self._has_command = rights.session != 0

        rights.on_change, rights.on_lost = has_changed, self._on_lost
        self._take_again_s = 0.0

    def _look_after_command(self, link: Link) -> None:
        """Take command for who commands at the panel, and give it back when nobody does."""
        now_s, wants = time.monotonic(), self._wants_command()
        if self._has_command and not wants:
            link.rights.release()
        elif wants and not self._has_command and now_s >= self._take_again_s:
            self._take_again_s = now_s + TAKE_S
            with suppress(CommandHeld):
                link.rights.take()

    def _look_after(self, link: Link) -> None:
        """Do what pages that look want to see, a little at a time."""
        with suppress(Refused):
            self._look_after_command(link)
        if time.monotonic() - self._parameters_asked_s < WATCHED_S:
            with suppress(Refused):
                self._read_parameters(link)

    def _read_parameters(self, link: Link) -> None:
        known = self._parameters
        signals = link.status.signals
        if known is not None and known.checksum == int(signals["params_checksum"]):
            if known.is_of(signals):
                return
            self._parameters = parameter_set(known.values, link.status)
            return
        for name in [name for name in INFOS if name not in self._partial][:PARAMETERS_AT_ONCE]:
            number = NUMBERS["parameter"][name]
            self._partial[name] = int(ask_done(link, "get_parameter", number).value)
        if len(self._partial) == len(INFOS):
            self._parameters = parameter_set(self._partial, link.status) or self._parameters
            self._partial.clear()
