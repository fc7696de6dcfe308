"""A live lathe and the panel of its controller, as two programs, for tests and benchmarks.

    with panel_session(folder) as session, chromium() as browser, browser.window() as window:
        window.page.goto(session.url)
        session.lathe.type("estop")
        session.wait_for_state("fault")

The folder must be empty; lathe and panel see no other live lathe of this computer.
"""

import json
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camtools.base.project import ROOT
from camtools.link.controller import Link, Status
from camtools.link.live_lathes import LiveLathe, live_lathes
from camtools.link.rights import May
from checks.patience import limit_s
from tests.tools.cases.background import Background, background, python
from tests.tools.cases.live_cases import live_case

WEAK_LOOP = {
    "servo_crossover_hz": 60,
    "servo_lead_percent": 2000,
    "servo_pole_hz": 1000,
    "servo_integral_mHz": 3000,
}
_FORCE = ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml"
_ENDS = {"fault": "reset", "homing": "disable", "ready": "disable", "manual": "disable"}
_CALM_S = 0.1
_ADDRESS = re.compile(r"http://\S+/")


@dataclass
class Panel:
    """A panel while it runs."""

    panel: Background
    url: str  # of the operator's page, with the token; those of other pages begin with it
    log: Path  # of its commands; beside it are the folders parts and runs

    def logged(self) -> list[dict[str, Any]]:
        """Return the lines of the log of commands."""
        lines = self.log.read_text("utf-8").splitlines() if self.log.exists() else []
        return [json.loads(line) for line in lines]


@dataclass
class PanelSession(Panel):
    """Lathe and panel while both run."""

    lathe: Background  # tools/live, to which faults are typed
    witness: Link  # the test's own: what it hears the panel has not touched
    live: LiveLathe  # by which others of this user find the controller

    def status(self) -> Status:
        """Return the controller's status, not older than this call."""
        while self.witness.pump(0):
            pass  # what has come meanwhile
        assert self.witness.next_row(limit_s()), f"no status:\n{self.lathe.text()}"
        return self.witness.status

    def wait_for(self, is_so: Callable[[Status], bool]) -> Status:
        """Return the first status of which something is so."""
        status = self.status()
        is_done = self.witness.wait(lambda: is_so(status), limit_s())
        assert is_done, f"{status.state} {status.faults}\n{self.lathe.text()}"
        return status

    def wait_for_state(self, *states: str) -> Status:
        """Return the first status in one of some states."""
        return self.wait_for(lambda status: status.state in states)

    def calm(self) -> None:
        """Bring the lathe into off without a fault, past the panel."""
        while (state := self.status().state) != "off" or self.witness.status.faults:
            if state == "fault":
                self.lathe.type("release")
            self.witness.rights.may = May.TAKE_OVER  # whoever commands by a page
            self.witness.ask(_ENDS.get(state, "stop"))
            self.witness.rights.release()
            self.witness.wait(lambda: False, _CALM_S)

    def text(self) -> str:
        """Return all that lathe and panel have said."""
        return f"--- lathe\n{self.lathe.text()}\n--- panel\n{self.panel.text()}\n"


def weak_machine(folder: Path) -> Path:
    """Write the machine whose U takes forces, with a weak loop that holds it; return its file."""
    keys = "\n".join(f"{name} = {value}" for name, value in WEAK_LOOP.items())
    machine = folder / "weak.toml"
    machine.write_text(f"{_FORCE.read_text('utf-8')}[controller]\n{keys}\n", "utf-8")
    return machine


@contextmanager
def panel_alone(folder: Path, *words: str | Path) -> Iterator[Panel]:
    """Run tools/panel with some options on a free port; it finds the live lathe of a folder."""
    log = folder / "commands.jsonl"
    command = python("camtools.cli.panel", "--port", "0", "--log", log, "--keep", folder, *words)
    with background(*command, XDG_RUNTIME_DIR=str(folder)) as panel:
        address = _ADDRESS.search(panel.wait_for("http://"))
        assert address is not None, panel.text()
        yield Panel(panel, address[0], log)


@contextmanager
def panel_session(
    folder: Path, live_words: Sequence[str | Path] = (), panel_words: Sequence[str | Path] = ()
) -> Iterator[PanelSession]:
    """Run both with some options, on free ports; they announce and keep all in the folder."""
    with live_case(folder, *live_words) as case, panel_alone(folder, *panel_words) as one:
        (announced,) = live_lathes(folder / "camturn")
        yield PanelSession(one.panel, one.url, one.log, case.lathe, case.link, announced)
