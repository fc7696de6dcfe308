"""A controller of another version: what it does not know or tell is said, with the remedy."""

from collections.abc import Callable

import can
import pytest

from camtools.link import scope
from camtools.link.controller import Link
from camtools.link.messages import ANSWER, DATABASE, NUMBERS, Refused
from camtools.link.refusal_text import ask_done

DETAIL = DATABASE.get_message_by_name("Detail").frame_id
LAST_PAGE = 22
UNKNOWN = (-30).to_bytes(2, "little", signed=True)


def through(link: Link, change: Callable[[can.Message], None]) -> None:
    """Let every frame of the controller be changed before the link has it."""
    whole = link.bus.recv

    def recv(timeout: float | None = None) -> can.Message | None:
        frame = whole(timeout)
        if frame is not None:
            change(frame)
        return frame

    link.bus.recv = recv  # type: ignore[method-assign]


def test_pages_that_an_older_controller_lacks_are_named(link: Link) -> None:
    """Not silence, and no word of other programs or a busy bus."""

    def leave_out(frame: can.Message) -> None:
        if frame.arbitration_id == DETAIL and frame.data[0] > LAST_PAGE:
            frame.arbitration_id = 0

    through(link, leave_out)
    with pytest.raises(Refused) as told:
        link.listen()
    assert str(told.value).endswith(
        "the status lacks Detail page 23, Detail page 24, "
        "Detail page 25: the controller is older than this "
        "program; give it the firmware of this version"
    )


def test_pages_of_a_newer_controller_are_left_aside(link: Link) -> None:
    """What this program does not know is no harm."""

    def make_newer(frame: can.Message) -> None:
        if frame.arbitration_id == DETAIL and frame.data[0] == 0 and link.status.n_rows % 2:
            frame.data[0] = 99

    through(link, make_newer)
    assert link.listen().state == "off"


def test_a_command_that_is_not_known_tells_the_remedy(link: Link) -> None:
    """By whichever way a command is refused."""

    def forget(frame: can.Message) -> None:
        if frame.arbitration_id == ANSWER.frame_id:
            frame.data[2:4] = UNKNOWN

    through(link, forget)
    assert NUMBERS["result"]["command"] == int.from_bytes(UNKNOWN, "little", signed=True)
    for order in (
        lambda: ask_done(link, "home"),
        lambda: scope.start(link),
    ):
        with pytest.raises(Refused, match="the controller is older than this program"):
            order()
