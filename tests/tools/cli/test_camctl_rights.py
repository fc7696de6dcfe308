"""Who commands, the level and acknowledge: tools/camctl against the firmware."""

import re
import threading
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from pytest import MonkeyPatch

from camtools.cli import camctl_control
from camtools.cli.drive_options import UOptions, connected_u
from camtools.link.controller import Link
from camtools.link.messages import COMMAND, NAMES, NUMBERS, Refused
from camtools.link.refusal_text import ask_done
from camtools.link.rights import CommandHeld, CommandLost, May, SharedSession, sender_of
from checks.patience import limit_s, until
from tests.tools.cases.camctl_bench import Bench, Refusal, keeping, linked, order
from tests.tools.cases.live_cases import live_case


@pytest.fixture
def other(bench: Bench) -> Iterator[Link]:
    """Return the link of another sender."""
    with linked(bench) as one:
        one.rights.sender = 7
        yield one


def commander(bench: Bench) -> str:
    """Return who commands by the newest page of the status."""
    return bench.do("who").splitlines()[0].removeprefix("command").strip()


def test_reading_needs_no_command_and_orders_give_it_back(bench: Bench, other: Link) -> None:
    """While another commands everything can be read; an order that is over leaves nothing."""
    assert commander(bench) == "nobody commands"
    given: list[str] = []

    def look(frame: can.Message) -> bool:
        given.append(NAMES["command"][frame.data[0]])
        return False

    bench.drop = look
    bench.do("home")
    assert [name for name in given if name in ("take_command", "home")] == ["take_command", "home"]
    assert commander(bench) == "nobody commands"
    other.rights.take()
    with keeping(other):
        for words in (("status",), ("get", "lead_ns"), ("where",), ("parts",), ("learned",)):
            bench.do(*words)
        assert commander(bench) == "sender 7 commands"


def test_an_order_is_refused_to_others(bench: Bench, other: Link, refusal: Refusal) -> None:
    """By his name, with the remedy; stop is obeyed all the same, and he who has it is obeyed."""
    bench.do("set", "engage_turns", "100")
    ask_done(other, "home")
    assert other.wait(lambda: other.status.state == "ready", limit_s())
    line = refusal(bench, 1, "start")
    assert line.endswith("sender 7 commands; wait until it is given back, or use --take-over")
    ask_done(other, "start")
    assert other.wait(lambda: other.status.state == "engaging", limit_s())
    assert bench.do("stop").startswith("stop: ")
    assert other.wait(lambda: other.status.state == "ready", limit_s())


def test_the_loser_of_a_cut_says_who_has_it_now(bench: Bench, other: Link) -> None:
    """Camctl start ends with status 1 and the new commander's number; the cut goes on under it."""
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    with bench.cutting("engaging") as cut:
        other.rights.take(over=True)
        assert other.wait(lambda: cut.rights.session == 0, limit_s())
        other.listen()
        assert other.status.state == "engaging"
        assert bench.do("--take-over", "--sender", "9", "phase", "5") == "phase = 5 deg\n"
        with pytest.raises(CommandLost, match="command is lost"):
            other.wait(lambda: False, 1.0)
        # On a slow computer the other one is silent for a second, and loses command before that.
        assert sum(map(int, re.findall(r"(?:over|lost) (\d+) times", commander(bench)))) == 2
    assert str(bench.ended[0]).endswith(
        "command is lost: sender 7 has taken it over; running motion continues"
    )


def test_a_second_camctl_of_the_same_user_shares_the_session(bench: Bench) -> None:
    """It may hold the feed of the cut, and does not give back what is not its own."""
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    with bench.cutting("engaging") as cut:
        session = cut.rights.session
        assert bench.do("phase", "3") == "phase = 3 deg\n"
        assert bench.do("override", "feed", "90") == "override feed = 90 %\n"
        assert cut.rights.session == session != 0
        assert commander(bench).startswith(f"sender {sender_of('camctl')} (camctl of this user)")
    assert commander(bench) == "nobody commands"


def test_a_session_that_is_over_is_not_joined(bench: Bench) -> None:
    """What a file tells of a session that the controller knows no more is left aside."""
    shared = SharedSession(f"virtual {bench.channel}", 64, sender_of("camctl"))
    shared.write(200)
    assert bench.do("phase", "3") == "phase = 3 deg\n"
    assert shared.read() == 0


def test_who_may_not_take_command_is_refused(other: Link) -> None:
    """A program that never commands gets the answer, and takes nothing."""
    other.rights.may = May.NEVER
    with pytest.raises(Refused, match="nobody commands; take command first"):
        ask_done(other, "enable")
    other.rights.take()
    again = Link(other.bus, "again")
    again.rights.sender = 8
    with pytest.raises(CommandHeld) as held:
        again.rights.take()
    assert held.value.holder == 7


def test_unlock_awaits_the_key(bench: Bench, refusal: Refusal, monkeypatch: MonkeyPatch) -> None:
    """Which counts for the commander in whose time it is turned, and for what he does meanwhile."""
    bench.turn_key(False)
    assert "refused: locked; turn the key switch" in refusal(bench, 1, "set u_stroke_nm 1000000")
    threading.Timer(0.6, bench.turn_key, [True]).start()
    told = bench.do("unlock", on="unlocked by", act=lambda: bench.turn_key(False))
    assert told.startswith("unlock: turn the key switch at the machine off and on, within 60 s\n")
    assert "\nunlock: unlocked by the key switch, for " in told
    assert told.endswith("unlock: locked again\n")
    monkeypatch.setattr(camctl_control, "_KEY_S", 0.3)
    assert "unlock: nobody turned the key switch" in refusal(bench, 1, "unlock")


def test_what_is_proposed_is_applied_during_unlock(bench: Bench) -> None:
    """The commands identify and tune share camctl's session, whose level they need."""
    bench.do("home")
    bench.turn_key(False)
    words = UOptions(interface="virtual", channel=bench.channel, node=bench.node)

    def apply() -> None:
        try:
            with connected_u(words) as (u, _):
                u.apply({"lead_ns": 150_000})
        finally:
            order(bench, "lock")

    threading.Timer(0.6, bench.turn_key, [True]).start()
    assert "locked again" in bench.do("unlock", on="unlocked by", act=apply)
    assert bench.do("get", "lead_ns").startswith("lead_ns = 150000")


def test_enable_waits_for_the_button(strict: Bench, refusal: Refusal) -> None:
    """The refusal says what to do, and where."""
    assert "acknowledge       needed: press acknowledge at the machine" in strict.do("who")
    line = refusal(strict, 1, "enable")
    assert "enable: refused: acknowledge; press acknowledge at the machine" in line
    strict.press()
    assert "acknowledge       acknowledged; enable within" in strict.do("who")
    assert strict.do("home") == "home: ready\n"


def test_a_camctl_that_is_not_heard_loses_the_cut(bench: Bench) -> None:
    """As one that is stopped: the cut ends as by stop, and it says so when it is heard again."""
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    with bench.cutting("engaging") as cut:
        bench.drop = lambda frame: frame.arbitration_id == COMMAND.frame_id
        until(lambda: cut.status.state == "ready", "the end of the cut")
        bench.drop = lambda frame: False
    assert "nobody has it now, so a running cut ends" in str(bench.ended[0])
    assert "faults            none" in bench.do("status")


@pytest.mark.long
def test_nothing_moves_before_somebody_presses_the_button(tmp_path: Path) -> None:
    """Nobody at the live lathe: enable waits for the press that is typed, limits for the key."""
    with live_case(tmp_path, "--operator", "absent") as case:
        with pytest.raises(Refused, match="press acknowledge at the machine"):
            ask_done(case.link, "home")
        with pytest.raises(Refused, match="locked; turn the key"):
            case.set(u_stroke_nm=1_100_000)
        signals, unlocked = case.link.status.signals, NUMBERS["level"]["key"]
        case.lathe.type("key:1")
        assert case.link.wait(lambda: signals.get("level") == unlocked, limit_s())
        case.set(u_stroke_nm=1_100_000)
        case.lathe.type("acknowledge:0.5")
        given = NUMBERS["acknowledge"]["given"]
        assert case.link.wait(lambda: signals.get("acknowledge") == given, limit_s())
        case.order("home", "ready")
