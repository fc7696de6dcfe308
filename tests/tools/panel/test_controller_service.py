"""The controller service and the firmware on an ideal machine: orders, rights, parameters."""

import asyncio
import random
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import can
import pytest

from camtools.link.controller import Link
from camtools.link.kept_values import INFOS
from camtools.link.messages import COMMAND, Answer, Refused
from camtools.link.refusal_text import ask_done
from camtools.panel.orders.snapshot import ParameterSet
from checks.patience import until
from tests.tools.cases.camctl_bench import Bench, named
from tests.tools.cases.controller_cases import Seat

LEAD = "lead_ns"


def last(seat: Seat) -> tuple[str, str, bool]:
    """Return visitor, order and result of the newest line of the log."""
    newest = seat.log.newest(1)[0]
    return newest["visitor"], newest["order"], newest["is_done"]


def test_a_part_is_cut_with_overrides(seat: Seat) -> None:
    """Each order comes back with what is so now, and the status shows it."""
    assert seat.do("speed", rpm=1500) == "speed = 1500 r/min"
    assert seat.do("feed_per_turn", mm=0.01) == "feed = 0.01 mm"  # a cut that outlasts the orders
    assert seat.do("parts", number=41) == "parts = 41"
    assert seat.do("home").startswith("home: ")
    seat.wait_for("ready")
    assert seat.do("start").startswith("start: ")
    seat.wait_for("cutting")
    assert seat.do("feed", percent=90) == "override feed = 90 %"
    assert seat.do("spindle", percent=95) == "override spindle = 95 %"
    assert seat.do("amplitude", percent=101) == "amplitude = 101 %"
    assert seat.do("phase", deg=-2.5) == "phase = -2.5 deg"
    trim = seat.do("trim", measure="diameter", mm=0.002)
    assert trim == "trim: diameter 0.002 mm, radius 0.001 mm"
    seat.do("hold")
    until(lambda: bool(seat.service.snapshot().signals["is_held"]))
    seat.do("resume")
    until(lambda: not seat.service.snapshot().signals["is_held"])
    seat.do("stop")
    seat.wait_for("ready")
    shown = seat.service.snapshot()
    assert shown.signals["override_of_feed"] == pytest.approx(90)
    assert shown.signals["trim_of_x"] == pytest.approx(0.001)
    assert shown.table_name == "short skirt"
    for name, value in (("feed", 100), ("spindle", 100), ("amplitude", 100)):
        seat.do(name, percent=value)
    seat.do("phase", deg=0)
    seat.do("trim", measure="radius", mm=0)


def test_rights_are_checked_by_the_service(seat: Seat) -> None:
    """Stop and drives off for every page, the rest for the commander alone."""
    assert "do not command" in seat.refused("enable", seat.other)
    assert last(seat) == ("other", "enable", False)
    assert seat.state == "off"
    seat.do("home")
    seat.wait_for("ready")
    assert seat.ask("disable", seat.other).is_done
    seat.wait_for("off")
    assert last(seat) == ("other", "disable", True)


def test_everything_tried_is_in_the_log(seat: Seat) -> None:
    """Done and refused, by whom, with arguments; of a file its size and checksum."""
    seat.refused("download", image=b"no table" * 30, name="<img src=x onerror=alert(1)>")
    newest = seat.log.newest(1)[0]
    told = newest["arguments"]
    assert told["image"] == f"240 bytes, CRC-32 {zlib.crc32(b'no table' * 30):08x}"
    assert "not a cam table" in newest["outcome"] and newest["time"].endswith(" UTC")
    seat.commander.take_over(seat.other)
    assert last(seat) == ("other", "take_over", True)
    assert seat.commander.news(seat.boss).startswith("page other took over command at")
    assert "do not command" in seat.refused("enable")
    seat.commander.lose(seat.other)
    assert last(seat) == ("other", "lose", True) and seat.commander.holder is None


def test_an_order_just_after_command_was_given_back_reaches_the_controller(seat: Seat) -> None:
    """Whoever takes it again need not wait until the service tries to take it the next time."""
    for _ in range(3):
        seat.commander.release(seat.boss)
        until(lambda: not seat.service.snapshot().has_command, "command given back")
        seat.commander.take(seat.boss)
        assert "refused: state off" in seat.refused("start")


@pytest.mark.parametrize(
    ("name", "words", "why"),
    [
        ("fly", {}, "no such order"),
        ("start", {"x": 1}, "start: give nothing"),
        ("step", {"axis": "x"}, "step: give axis, mm"),
        ("step", {"axis": "y", "mm": 1.0}, "give one of u, x, z"),
        ("step", {"axis": "x", "mm": float("nan")}, "give a finite number"),
        ("step", {"axis": "x", "mm": True}, "give a value of type float"),
        ("step", {"axis": ["x"], "mm": 1.0}, "give a value of type str"),
        ("zero", {"axis": "u", "mm": 1.0}, "give one of x, z"),
        ("tool", {"number": 9}, "give one of 0, 1, 2, 3, 4"),
        ("trim", {"measure": "area", "mm": 1.0}, "give one of diameter, radius"),
        ("trim", {"measure": "radius", "mm": 2.0}, "out of range; give -1 .. 1 mm"),
        ("feed", {"percent": 151}, "out of range; give 0 .. 150 %"),
        ("set", {"name": "nosuch", "value": 1}, "no such parameter"),
        ("set", {"name": "lead_ns", "value": -1}, "out of range; give "),
        ("set", {"name": "x" * 201, "value": 1}, "longer than 200 characters"),
        ("params_load", {"text": b"\xff", "name": "a.toml"}, "a.toml: no parameters"),
        ("start", {}, "refused: state off"),
    ],
)
def test_what_is_wrong_is_one_line(
    seat: Seat, name: str, words: dict[str, object], why: str
) -> None:
    """The service or the controller refuses, and nothing has changed."""
    text = seat.refused(name, **words)
    assert why in text and "\n" not in text
    assert seat.state == "off"


def test_what_comes_with_a_connection_that_was_lost_is_refused(seat: Seat) -> None:
    """A browser keeps back what is pressed meanwhile; only stop is wanted still."""
    seat.service.page_connected(seat.boss)
    seat.service.page_lost(seat.boss)
    assert "connection was lost" in seat.refused("enable")
    seat.service.page_connected(seat.boss)
    assert "connection was lost" in seat.refused("home")
    assert seat.ask("stop").text.startswith("stop: refused: state")  # it reached the controller
    seat.boss.back_at_s -= 1.0
    seat.do("home")
    seat.wait_for("ready")


def test_commands_that_get_lost_are_told_and_leave_nothing_behind(
    seat: Seat, shared_bench: Bench
) -> None:
    """The status comes, but no command arrives: each order says so, and none comes later."""
    seat.do("manual")
    before = seat.place()
    shared_bench.drop = lambda frame: frame.arbitration_id == COMMAND.frame_id
    try:
        assert "no answer, though status comes" in seat.refused("step", axis="x", mm=1.0)
        assert "no answer, though status comes" in seat.refused("stop", seat.other)
        press = seat.refused("jog_begin", press=30, axis="x", mm_per_s=1.0)
        assert "no answer, though status comes" in press
    finally:
        shared_bench.drop = lambda frame: False
    assert seat.state == "manual" and seat.place() == before
    assert seat.service.snapshot().work == ""


def test_a_busy_controller_is_asked_again_and_then_told() -> None:
    """Two hundred milliseconds long; the line says what to do."""
    answers = [Answer("get_parts", "busy", 0.0, 0), Answer("get_parts", "done", 7.0, 0)]
    link = Link(can.Bus(interface="virtual", channel="nobody"), "nobody")
    link.next_answer = lambda *_: answers.pop(0)  # type: ignore[method-assign]
    assert link.ask("get_parts").value == 7.0
    answers += [Answer("enable", "busy", 0.0, 0)] * 30
    with pytest.raises(Refused, match="busy; try again"):
        ask_done(link, "enable")
    link.bus.shutdown()


@pytest.mark.parametrize("urgent", ["disable", "stop"])
def test_what_is_urgent_overtakes_a_download(seat: Seat, urgent: str) -> None:
    """From any page; the download breaks off, the old table is in use."""
    seat.do("home")
    seat.wait_for("ready")

    async def session() -> tuple[str, str, str]:
        image = b"CAMTAB" + random.Random(1).randbytes(60_000)
        download = asyncio.create_task(seat.order("download", image=image, name="big"))
        while not download.done() and "download of big" not in seat.service.snapshot().work:
            await asyncio.sleep(0.01)
        busy = (await seat.order("trim", measure="radius", mm=0.0)).text
        told = (await seat.order(urgent, seat.other)).text
        return (await download).text, busy, told

    download, busy, told = asyncio.run(session())
    assert download == f"interrupted by {urgent}"
    assert busy.startswith("busy with download of big")
    assert told == "disable: off" if urgent == "disable" else "stop: refused: state ready" in told
    until(lambda: seat.service.snapshot().work == "")
    assert seat.service.snapshot().table_name == "short skirt"


def test_a_table_is_downloaded_and_taken_into_use(
    seat: Seat, table_of: Callable[[str], Path]
) -> None:
    """Its progress is shown; a damaged one is refused and the old one stays."""
    shown, table = set(), named(table_of("perkins240").read_bytes(), "other part")

    async def session(image: bytes) -> tuple[bool, str]:
        download = asyncio.create_task(seat.order("table_next", image=image, name="other"))
        while not download.done():
            shown.add(seat.service.snapshot().work)
            await asyncio.sleep(0.005)
        outcome = await download
        return outcome.is_done, outcome.text

    damaged = table[:-1] + bytes([table[-1] ^ 1])
    assert not asyncio.run(session(damaged))[0]
    assert seat.service.snapshot().table_name == "short skirt"
    is_done, text = asyncio.run(session(table))
    assert is_done and text.startswith("table other part; ")
    until(lambda: seat.service.snapshot().table_name == "other part")
    assert any(work.startswith("download of other, ") for work in shown)


def test_parameters_are_read_set_saved_loaded_and_kept(seat: Seat) -> None:
    """The page has them all, with the checksum of the controller; a change is seen."""
    seat.do("defaults")

    def read_with(value: int | None = None) -> ParameterSet:
        """Return the parameters when they are read, with a lead if one is given."""
        while (now := seat.service.parameters()) is None or value not in (None, now.values[LEAD]):
            time.sleep(0.01)
        return now

    read = read_with()
    assert set(read.values) == set(INFOS)
    saved, old, value = read.text().encode(), read.values[LEAD], read.values[LEAD] + 1000
    assert seat.do("set", name=LEAD, value=value) == f"lead_ns = {value}"
    assert read_with(value).differences(saved, "a.toml") == {LEAD: (old, value)}
    seat.do("keep")
    head = f"a.toml: 1 of {len(INFOS)} parameters changed"
    assert seat.do("params_load", text=saved, name="a.toml") == f"{head}: {LEAD} {value} -> {old}"
    assert seat.do("revert").startswith("revert: done")
    read_with(value)
    assert seat.do("defaults").startswith("defaults: done")


def test_a_controller_that_falls_silent_is_seen_and_comes_back(
    request: pytest.FixtureRequest,
) -> None:
    """Orders are refused with the reason meanwhile; there is no order left over when it is back."""
    channel = request.node.name
    seat = Seat(channel)
    try:
        until(lambda: "no answer" in seat.service.snapshot().problem)
        assert "emergency stop at the machine" in seat.refused("stop")
        for _ in range(2):
            bench = Bench(channel)
            seat.connect()
            # An order in the session of the controller of before is refused; a new one is taken.
            until(lambda: seat.ask("home").is_done)
            bench.close()
            until(lambda: not seat.service.snapshot().is_connected)
            assert "does not answer" in seat.service.snapshot().problem
            assert seat.refused("start").startswith("not sent: ")
        seat.is_bus_there = False
        until(lambda: seat.service.snapshot().problem == "no bus: start tools/live")
    finally:
        seat.service.close()
