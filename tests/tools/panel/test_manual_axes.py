"""Axes that the service moves by hand: held buttons, steps, homes, what stops them."""

import asyncio
import time

import pytest

from checks.patience import until
from tests.tools.cases.controller_cases import Seat


async def hold(seat: Seat, press: int, seconds: float) -> None:
    """Send heartbeats for a time."""
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        await seat.order("jog_hold", press=press)
        await asyncio.sleep(0.05)


def test_an_axis_moves_while_the_button_is_held(seat: Seat) -> None:
    """It stands when it is let go; meanwhile another order is refused with the reason."""
    seat.do("manual")
    before = seat.place()

    async def press() -> tuple[str, str]:
        jog = asyncio.create_task(seat.order("jog_begin", press=1, axis="x", mm_per_s=5.0))
        await hold(seat, 1, 0.4)
        busy = (await seat.order("zero", axis="x", mm=1.0)).text
        await seat.order("jog_end", press=1)
        return (await jog).text, busy

    text, busy = asyncio.run(press())
    assert text.endswith("; released") and text.startswith("x ")
    assert busy == "busy with jog x; wait, or stop it"
    after = seat.place()
    assert 0.5 < after - before < 10
    assert seat.place() == after


# By what ends a press: its number and the words of its outcome.
ENDS = {
    "page lost": (20, "the page was closed"),
    "taken over": (21, "you do not command"),
    "stop by another": (22, "interrupted by stop"),
}


@pytest.mark.parametrize("what", ENDS)
def test_a_held_button_dies_with_its_right(seat: Seat, what: str) -> None:
    """Heartbeats go on, but the page is gone, commands no more, or somebody stops."""
    seat.do("manual")
    number, wanted = ENDS[what]

    async def press() -> str:
        jog = asyncio.create_task(seat.order("jog_begin", press=number, axis="x", mm_per_s=1.0))
        await hold(seat, number, 0.3)
        if what == "page lost":
            seat.service.page_lost(seat.boss)
        elif what == "taken over":
            seat.commander.take_over(seat.other)
        else:
            stop = await seat.order("stop", seat.other)
            assert stop.is_done, stop.text
        await hold(seat, number, 0.3)
        return (await jog).text

    assert wanted in asyncio.run(press())
    there = seat.place()
    assert seat.place() == there


def test_steps_homes_tools_and_zero(seat: Seat) -> None:
    """By hand, to the places that were wanted."""
    seat.do("manual")
    before = seat.place()
    assert seat.do("step", axis="x", mm=0.25).startswith("x ")
    assert seat.place() - before == pytest.approx(0.25, abs=1e-6)
    seat.do("set", name="z_home", value=1)
    assert seat.do("home", axis="z").startswith("home z ")
    assert seat.do("tool_offset", number=2, axis="x", mm=0.5) == "tool 2: x 0.500000 mm"
    assert seat.do("tool", number=2) == "tool 2 is in use"
    until(lambda: seat.service.snapshot().signals["tool"] == 2)
    assert seat.do("tool", number=0) == "no tool is in use"
    until(lambda: seat.service.snapshot().signals["tool"] == 0)
    assert seat.do("zero", axis="x", mm=120.0).startswith("zero x: diameter 120 mm here, datum ")
    assert 2 * (seat.place() - seat.place("u")) == pytest.approx(120.0, abs=1e-5)


def test_stop_brakes_a_step_at_once(seat: Seat) -> None:
    """From any page; the axis is not where the step would have ended."""
    seat.do("manual")
    before = seat.place()

    async def session() -> tuple[str, str]:
        step = asyncio.create_task(seat.order("step", axis="x", mm=50.0))
        while not step.done() and "step" not in seat.service.snapshot().work:
            await asyncio.sleep(0.01)
        stop = await seat.order("stop", seat.other)
        return (await step).text, stop.text

    step, stop = asyncio.run(session())
    assert step == "interrupted by stop" and stop == "stop: manual"
    there = seat.place()
    assert there < before + 49 and seat.place() == there
