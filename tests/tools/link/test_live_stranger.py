# SPDX-License-Identifier: Apache-2.0
"""A stranger on the bus of the live lathe: what he hears he replays, guesses and floods."""

import random
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from camtools.link.bus import open_bus
from camtools.link.controller import Link
from camtools.link.live_lathes import live_lathes
from camtools.link.messages import NUMBERS, Refused, command_bytes
from camtools.link.refusal_text import ask_done
from camtools.link.rights import May
from tests.tools.cases.background import PATIENCE_S
from tests.tools.cases.live_cases import LiveCase, live_case

STROKE = NUMBERS["parameter"]["u_stroke_nm"]
COMMAND_ID = 0x640


@contextmanager
def stranger_at(folder: Path) -> Iterator[Link]:
    """Another program on the bus, who takes command only when he is told to."""
    (announced,) = live_lathes(folder / "camturn")
    bus, where = open_bus(announced.bus)
    link = Link(bus, where, announced.node)
    link.rights.sender, link.rights.may = 66, May.NEVER
    yield link
    bus.shutdown()


@contextmanager
def lathe_of(folder: Path, people: str) -> Iterator[tuple[LiveCase, Link]]:
    """Run a lathe with somebody at it or nobody, and a stranger beside its commander."""
    with live_case(folder, "--operator", people) as case, stranger_at(folder) as stranger:
        yield case, stranger


def forge(stranger: Link, command: str, as_whom: Link, session: int, **value: float) -> None:
    """Send a frame in the name of another."""
    stamp = {"sender": as_whom.rights.sender, "session": session}
    stranger.send_frame(COMMAND_ID, command_bytes(command, 0, value, **stamp))


def wait_for_press(case: LiveCase) -> None:
    """Wait until somebody has pressed the button."""
    signals, given = case.link.status.signals, NUMBERS["acknowledge"]["given"]
    assert case.link.wait(lambda: signals.get("acknowledge") == given, PATIENCE_S)


def test_a_key_that_was_left_on_gives_a_stranger_nothing(tmp_path: Path) -> None:
    """He takes over from whom the key was turned for, and plays back what he heard of him."""
    with lathe_of(tmp_path, "absent") as (case, stranger):
        link = case.link
        link.rights.take()
        case.lathe.type("key:1")
        unlocked = NUMBERS["level"]["key"]
        assert link.wait(lambda: link.status.signals.get("level") == unlocked, PATIENCE_S)
        case.set(u_stroke_nm=1_100_000)
        session = link.rights.session
        stranger.rights.take(over=True)
        assert (
            stranger.ask_once("set_parameter", parameter=STROKE, value=900_000).result == "locked"
        )
        assert stranger.ask_once("begin_download", timeout_s=4544).result == "locked"
        assert stranger.ask_once("select_table").result == "locked"
        for _ in range(20):
            forge(stranger, "set_parameter", link, session, value=900_000)
        assert stranger.ask_once("get_parameter", parameter=STROKE).value == 1_100_000
        stranger.rights.release()


def test_a_cut_outlives_a_stranger(tmp_path: Path) -> None:
    """Frames of wrong sessions, a storm of heartbeats and orders, two takes a tick; then a lock."""
    with lathe_of(tmp_path, "present") as (case, stranger):
        wait_for_press(case)
        case.order("home", "ready")
        case.order("start", "cutting")
        draw = random.Random(1)
        for _ in range(2000):
            session = draw.choice([0, 1, 77, 254, 255])
            forge(stranger, draw.choice(["heartbeat", "disable", "lock"]), stranger, session)
        assert stranger.ask("take_command", is_take_over=0).result == "not_commander"
        with pytest.raises(Refused, match="commands"):
            ask_done(stranger, "disable")
        assert case.link.listen().state == "cutting"
        assert not case.link.status.faults
        ask_done(case.link, "lock")  # ends nothing
        assert case.link.listen().state == "cutting"
        ask_done(stranger, "stop")  # which everybody may
        case.until("disengaging", "ready")
        assert not case.link.status.faults
