"""What names the U of a drive on a command line: a controller, or a recording.

>>> UOptions(channel="can0").check(is_bus=False, machine=None)
Traceback (most recent call last):
    ...
camtools.base.arguments.UsageError: --channel: needs a bus: add --bus
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path

from camtools.base.arguments import UsageError
from camtools.base.files import utf8_text
from camtools.cli.bus import BusOptions
from camtools.identify.drives import ConnectedU
from camtools.identify.foreign_record import MAX_BYTES
from camtools.link.controller import Link
from camtools.link.rights import sender_of
from camtools.measured.correction_round import read_given


@dataclass(frozen=True)
class UOptions(BusOptions):
    """The options that name a bus and a controller on it."""

    def check(self, *, is_bus: bool, machine: str | None) -> None:
        """Refuse options of the bus without --bus."""
        given = [option.name for option in fields(self) if getattr(self, option.name)]
        if given and not is_bus:
            remedy = "use --bus instead of --machine" if machine else "add --bus"
            raise UsageError(f"--{given[0]}: needs a bus: {remedy}")


@contextmanager
def connected_u(options: UOptions) -> Iterator[tuple[ConnectedU, int]]:
    """Open U of the controller that the options name; give it and the controller's node.

    It uses camctl's sender number, so it shares command and level with a running `camctl unlock`.
    Raises CamtoolsError: the bus cannot be opened.
    """
    bus, where, node = options.opened()
    try:
        link = Link(bus, where, node)
        link.rights.sender = sender_of("camctl")
        link.rights.share(node)
        yield ConnectedU(link), node
    finally:
        bus.shutdown()


def record_text(csv: Path) -> str:
    """Return the text of a recording, which must be UTF-8."""
    return utf8_text(read_given(csv, "--record", MAX_BYTES), str(csv))
