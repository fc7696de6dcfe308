"""A live lathe beside a test, with a link to its controller."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from camtools.link.bus import open_bus
from camtools.link.controller import PERIOD_S, WANTED, Link
from camtools.link.live_lathes import live_lathes
from camtools.link.messages import NUMBERS
from camtools.link.refusal_text import ask_done
from checks.patience import limit_s
from tests.tools.cases.background import Background, background, python


class LinkCase:
    """A link to a controller, by which orders are given."""

    def __init__(self, link: Link) -> None:
        self.link = link

    def until(self, *states: str) -> None:
        """Wait for one of some states."""
        status = self.link.status
        is_there = self.link.wait(lambda: status.state in states, limit_s())
        assert is_there, f"{status.state} {status.faults}"

    def order(self, command: str, *states: str) -> None:
        """Give an order and wait for a state that it leads to."""
        ask_done(self.link, command)
        self.until(*states)

    def set(self, **values: int) -> None:
        """Set parameters."""
        for name, value in values.items():
            ask_done(self.link, "set_parameter", NUMBERS["parameter"][name], value=value)


class LiveCase(LinkCase):
    """A live lathe, to which faults are typed, and a link to its controller."""

    def __init__(self, lathe: Background, link: Link) -> None:
        super().__init__(link)
        self.lathe = lathe

    @property
    def now_s(self) -> float:
        """Time [s] of the controller's own clock, by the rows of its status."""
        return self.link.status.n_rows * PERIOD_S


@contextmanager
def live_case(folder: Path, *words: str | Path) -> Iterator[LiveCase]:
    """Run tools/live with some words; no other lathe announces itself in the empty folder."""
    live = python("camtools.cli.live", *words)
    with background(*live, XDG_RUNTIME_DIR=str(folder)) as lathe:
        lathe.wait_for("control-C ends")
        (announced,) = live_lathes(folder / "camturn")
        bus, where = open_bus(announced.bus)
        try:
            link = Link(bus, where, announced.node)
            # Who waits for the lathe's words sends no heartbeats; the next order takes command.
            link.rights.on_lost = lambda text, holder: None
            is_heard = link.wait(lambda: link.status.signals.keys() >= WANTED, limit_s())
            assert is_heard, lathe.text()
            yield LiveCase(lathe, link)
        finally:
            bus.shutdown()
