"""The panel as one commander on the bus: beside another one, locked, and before the button."""

import asyncio
from collections.abc import Iterator

import can
import pytest

from camtools.link.controller import Link
from camtools.link.messages import COMMAND
from camtools.link.refusal_text import ask_done
from camtools.link.rights import sender_of, sender_text
from camtools.panel.views.availability import next_steps
from camtools.panel.views.wording import held_text, other_sender
from checks.patience import limit_s, until
from tests.tools.cases.camctl_bench import Bench
from tests.tools.cases.controller_cases import Seat

PANEL = sender_of("panel")


@pytest.fixture
def first(strict: Bench) -> Iterator[Seat]:
    """Return a panel whose boss commands."""
    one = Seat(strict.channel)
    one.connect()
    until(lambda: one.service.snapshot().has_command)
    yield one
    one.service.close()


@pytest.fixture
def second(strict: Bench, first: Seat) -> Iterator[Seat]:
    """Return another panel at the same controller, whose boss wants to command as well."""
    one = Seat(strict.channel)
    one.connect()
    yield one
    one.service.close()


@pytest.fixture
def stranger(strict: Bench) -> Iterator[Link]:
    """Return another program on the bus."""
    bus = can.Bus(interface="virtual", channel=strict.channel)
    one = Link(bus, "a stranger")
    one.rights.sender = 7
    yield one
    bus.shutdown()


def to_cut(strict: Bench, seat: Seat) -> None:
    """Bring the controller into the work, for some seconds."""
    strict.press()
    seat.do("set", name="engage_turns", value=100)
    until(lambda: seat.ask("home").is_done)
    seat.wait_for("ready")
    seat.do("start")
    seat.wait_for("engaging")


def test_two_panels_at_one_controller(strict: Bench, first: Seat, second: Seat) -> None:
    """The second sees who commands, may stop, and takes over; the first is told."""
    until(lambda: other_sender(second.service.snapshot()) == PANEL)
    assert held_text(second.service.snapshot()) == (
        f"{sender_text(PANEL)} commands the controller; take over, top right"
    )
    assert not second.service.snapshot().has_command
    assert "commands; wait until he gives it back, or take over" in second.refused("enable")
    to_cut(strict, first)
    assert asyncio.run(second.service.take_over(second.boss)).is_done
    assert second.service.snapshot().has_command
    until(lambda: first.commander.holder is None)
    assert "has taken it over; running motion continues" in first.commander.news(first.boss)
    assert "you do not command" in first.refused("hold")
    assert second.state == "engaging"
    assert first.do("stop").startswith("stop: ")
    second.wait_for("ready")


def test_a_panel_that_nobody_commands_leaves_command(first: Seat, stranger: Link) -> None:
    """Given back here it is free there; taken here it is taken there, where it is free."""
    first.commander.release(first.boss)
    until(lambda: not first.service.snapshot().has_command)
    stranger.rights.take()
    first.commander.take(first.boss)
    until(lambda: other_sender(first.service.snapshot()) == 7)
    stranger.rights.release()
    until(lambda: first.service.snapshot().has_command)


def test_stop_needs_no_command_on_the_bus(strict: Bench, first: Seat, stranger: Link) -> None:
    """Neither in the work of another, nor where it switches the drives off."""
    first.commander.release(first.boss)
    until(lambda: not first.service.snapshot().has_command)
    strict.press()
    ask_done(stranger, "home")
    assert stranger.wait(lambda: stranger.status.state == "ready", limit_s())
    stranger.rights.on_lost = lambda text, holder: lost.append(holder)
    lost: list[int] = []
    assert first.ask("disable", first.other).is_done
    # It takes command over for that, and gives it back at once.
    assert stranger.wait(lambda: len(lost) == 1 and stranger.status.state == "off", limit_s())
    assert lost[0] in (PANEL, 0)


def test_a_panel_that_dies_ends_the_cut(strict: Bench, first: Seat) -> None:
    """Its heartbeats do not arrive; when they do again, its commander reads what happened."""
    to_cut(strict, first)
    strict.drop = lambda frame: frame.arbitration_id == COMMAND.frame_id
    first.wait_for("ready")
    strict.drop = lambda frame: False
    until(lambda: "nobody has it now" in first.commander.news(first.boss))
    assert first.commander.holder is first.boss
    until(lambda: first.service.snapshot().has_command)
    assert first.service.snapshot().faults == ()


def test_what_is_locked_is_told_with_the_remedy(strict: Bench, first: Seat) -> None:
    """Limits are locked without the key, what an operator sets is not."""
    until(lambda: first.service.snapshot().signals.get("level") == 1)  # the key is on
    strict.turn_key(False)
    until(lambda: first.service.snapshot().signals.get("level") == 0)
    told = first.refused("set", name="u_stroke_nm", value=1_000_000)
    assert "refused: locked; turn the key switch at the machine off and on" in told
    assert first.do("speed", rpm=900.0) == "speed = 900 r/min"
    strict.turn_key(True)
    until(lambda: first.service.snapshot().signals.get("level") == 1)
    assert first.do("set", name="u_stroke_nm", value=1_000_000) == "u_stroke_nm = 1000000"
    assert first.do("lock").startswith("locked: limits, constants and tables do not change")


def test_the_button_is_asked_for_before_enable(strict: Bench, first: Seat) -> None:
    """What to do says it and the refusal does, until somebody at the machine has pressed."""

    def missing() -> list[str]:
        now = first.service.snapshot()
        return [item.key for item in next_steps(now.state, now.signals, {}).missing]

    until(lambda: missing() == ["acknowledge"])
    assert "press acknowledge at the machine for half a second" in first.refused("enable")
    strict.press()
    until(lambda: missing() == [])
    assert first.do("enable").startswith("enable: ")
    first.wait_for("ready")
