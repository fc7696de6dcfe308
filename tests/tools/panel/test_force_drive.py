"""The loop of a U that takes forces is measured and set from the panel."""

import asyncio
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import cast

import can
import pytest

from camtools.identify.drives import ConnectedU
from camtools.link.controller import Link
from camtools.link.kept_values import INFOS
from camtools.link.messages import Refused
from camtools.panel.orders import loop_tuner
from camtools.panel.orders.loop_tuner import LoopTuner, Tuned
from camtools.panel.views.parameter_rows import has_force_drive, loop_text
from checks.patience import until
from tests.browser.panel_session import WEAK_LOOP
from tests.tools.cases.camctl_bench import Bench
from tests.tools.cases.controller_cases import Seat

_DEFAULTS = {name: info.default for name, info in INFOS.items()}
_REST_S = 0.5  # sooner than the controller's own patience with an excitation


@pytest.fixture
def link_of(shared_bench: Bench) -> Iterator[Link]:
    """Return a link of the test's own to the bench."""
    bus = can.Bus(interface="virtual", channel=shared_bench.channel)
    yield Link(bus, shared_bench.channel)
    bus.shutdown()


_ENDS: dict[str, tuple[Callable[[Seat], object], str]] = {
    "stop": (lambda seat: seat.order("stop", seat.other), "interrupted by stop"),
    "page closed": (lambda seat: seat.service.page_lost(seat.boss), "interrupted: the connection"),
    "command lost": (lambda seat: seat.commander.lose(seat.boss), "interrupted: you do not"),
}


@pytest.mark.parametrize("end", _ENDS)
def test_u_comes_to_rest_with_its_visitor(
    shared_bench: Bench, seat: Seat, link_of: Link, end: str
) -> None:
    """STOP, a page that closes and command that is lost end the excitation; no loop is kept.

    No force, and one above the limit, do not begin.
    """
    act, says = _ENDS[end]
    shared_bench.take_forces()
    for name, value in WEAK_LOOP.items():
        seat.do("set", name=name, value=value)
    seat.do("home")
    seat.wait_for("ready")
    assert "give a force above 0 N" in seat.refused("push_u", force_n=0.0)
    assert "servo_force_limit_mn" in seat.refused("push_u", force_n=700.0)
    signals = link_of.listen().signals

    async def session() -> str:
        measured = asyncio.create_task(seat.order("measure_loop"))
        while seat.state != "identifying":
            assert not measured.done(), (await measured).text
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.3)
        done = act(seat)
        if asyncio.iscoroutine(done):
            await done
        return (await measured).text

    assert asyncio.run(session()).startswith(says)
    assert link_of.wait(lambda: link_of.status.state == "ready", _REST_S)

    def stands() -> bool:
        link_of.next_row(1.0)
        rest = signals["u_set"]
        link_of.wait(lambda: False, 0.3)
        return bool(signals["u_set"] == rest)

    until(stands, "U has gone back and rests")
    assert seat.service.tuned() is None


def test_a_pulse_is_shown_and_set_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """What tools/tune --pulse finds is set by apply, and no second time; a reversed U is not."""
    found, given = SimpleNamespace(sign=1), list[object]()
    monkeypatch.setattr(loop_tuner, "measure_pulse", lambda u, force_n: found)
    monkeypatch.setattr(loop_tuner, "pulse_lines", lambda one: ["first", "second"])
    monkeypatch.setattr(loop_tuner, "pulse_settings", lambda one: {"servo_mass_g": 1500})
    monkeypatch.setattr(ConnectedU, "apply", lambda u, settings: given.append(settings))
    link, tuner = cast(Link, SimpleNamespace(where="here")), LoopTuner()
    tuner.push(link, 15.0, print)
    assert tuner.newest == Tuned("first\nsecond", b"", {"servo_mass_g": 1500})
    assert tuner.apply(link, print).startswith("1 parameters are set, the drives are off")
    assert given == [{"servo_mass_g": 1500}]
    with pytest.raises(Refused, match="nothing is proposed"):
        tuner.apply(link, print)
    found.sign = -1
    with pytest.raises(Refused, match="first"):
        tuner.push(link, 15.0, print)
    assert tuner.newest == Tuned("first\nsecond", b"", {}, "first")


def test_a_loop_without_the_margins_is_shown_and_not_applied(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The constants are there, and why no loop is proposed."""
    subject = SimpleNamespace(lines=["mass_kg 1.5"])
    monkeypatch.setattr(loop_tuner, "recorded", lambda u, where: None)
    monkeypatch.setattr(loop_tuner, "fitted", lambda record: None)
    monkeypatch.setattr(loop_tuner, "subject_of", lambda *_: subject)
    monkeypatch.setattr(loop_tuner, "proposed", lambda one: SimpleNamespace(problem="unstable"))
    link = cast(Link, SimpleNamespace(where="here", wait=lambda is_done, s: is_done()))
    tuner = LoopTuner()
    with pytest.raises(Refused, match="unstable"):
        tuner.measure(link, print)
    assert tuner.newest == Tuned("mass_kg 1.5", b"", {}, "unstable")
    with pytest.raises(Refused, match="nothing is proposed"):
        tuner.apply(link, print)


def test_the_card_is_for_a_force_drive_and_says_what_is_to_be_set() -> None:
    """A U that takes positions has none; a mass without a loop leads to the first power-up."""
    assert not has_force_drive(_DEFAULTS) and not has_force_drive({})
    weighed = _DEFAULTS | {"servo_mass_g": 2100}
    assert has_force_drive(weighed)
    assert "servo_crossover_hz = 0" in loop_text(weighed)
    assert "hal/RETROFIT.md" in loop_text(weighed)
    text = loop_text(_DEFAULTS | WEAK_LOOP | {"servo_force_limit_mn": 345_000})
    assert "crossover 60 Hz" in text and " 345 N," in text
