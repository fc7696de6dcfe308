"""The loop of a U that takes forces is measured and set from the panel."""

import asyncio
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest

from camtools.link.bus import open_bus
from camtools.link.controller import Link
from camtools.link.kept_values import INFOS
from camtools.link.live_lathes import live_lathes
from camtools.panel.views.parameter_rows import has_force_drive, loop_text
from checks.patience import until
from tests.browser.panel_session import WEAK_LOOP, weak_machine
from tests.tools.cases.camctl_bench import Bench
from tests.tools.cases.controller_cases import Seat
from tests.tools.cases.live_cases import LiveCase, live_case

_DEFAULTS = {name: info.default for name, info in INFOS.items()}
_REST_S = 0.5  # sooner than the controller's own patience with an excitation


class LiveSeat(Seat):
    """A service before a live lathe."""

    def __init__(self, folder: Path, live: LiveCase) -> None:
        (self._announced,) = live_lathes(folder / "camturn")
        self.live = live
        super().__init__("")

    def _open(self) -> Link:
        bus, where = open_bus(self._announced.bus)
        return Link(bus, where, self._announced.node)

    def parameters(self) -> dict[str, int]:
        """Return the parameters as the page gets them."""
        while (read := self.service.parameters()) is None:
            time.sleep(0.01)
        return dict(read.values)


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveSeat]:
    """Return a service before a lathe whose weak loop holds U."""
    folder = tmp_path_factory.mktemp("force")
    with live_case(folder, "--machine", weak_machine(folder)) as live:
        one = LiveSeat(folder, live)
        one.connect()
        yield one
        one.service.close()


@pytest.fixture
def live_seat(shared: LiveSeat) -> LiveSeat:
    """Return the service in ready, the boss in command."""
    shared.commander.take_over(shared.boss)
    shared.boss.is_here, shared.boss.was_connected, shared.boss.back_at_s = True, True, -1e9
    if shared.state == "off":
        until(lambda: shared.ask("enable").is_done, "enable")
    shared.wait_for("ready")
    return shared


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


@pytest.mark.long
def test_a_pulse_tells_mass_and_friction(live_seat: LiveSeat) -> None:
    """Apply sets both."""
    live_seat.do("push_u", force_n=15.0)
    found = live_seat.service.tuned()
    assert found is not None and found.text.startswith("a positive force moves the scale up")
    assert found.settings["servo_mass_g"] == pytest.approx(1500, rel=0.04)
    assert found.settings["servo_friction_mn"] == pytest.approx(4500, rel=0.1)
    before = live_seat.parameters()
    live_seat.do("apply_loop")
    wanted = before | dict(found.settings)
    until(lambda: live_seat.parameters() == wanted, "mass and friction are set")


@pytest.mark.long
def test_a_loop_without_the_margins_is_shown_and_not_applied(
    live_seat: LiveSeat, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The constants are there, and why no loop is proposed."""
    poor = "margins at 0.7 of the mass: unstable"
    monkeypatch.setattr("camtools.tune.judgement.refusal", lambda judged, *, is_proposal: poor)
    assert live_seat.refused("measure_loop") == poor
    tuned = live_seat.service.tuned()
    assert tuned is not None and tuned.problem == poor and not tuned.picture
    assert "mass_kg" in tuned.text and "proposed" not in tuned.text
    assert "nothing is proposed" in live_seat.refused("apply_loop")


def test_the_card_is_for_a_force_drive_and_says_what_is_to_be_set() -> None:
    """A U that takes positions has none; a mass without a loop leads to the first power-up."""
    assert not has_force_drive(_DEFAULTS) and not has_force_drive({})
    weighed = _DEFAULTS | {"servo_mass_g": 2100}
    assert has_force_drive(weighed)
    assert "servo_crossover_hz = 0" in loop_text(weighed)
    assert "hal/RETROFIT.md" in loop_text(weighed)
    text = loop_text(_DEFAULTS | WEAK_LOOP | {"servo_force_limit_mn": 345_000})
    assert "crossover 60 Hz" in text and " 345 N," in text
