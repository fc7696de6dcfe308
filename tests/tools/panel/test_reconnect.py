"""A page that returns, and a measurement on a slow computer, continue where they were."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest
from nicegui import Client, core, ui
from nicegui.page import page

from camtools.link import excitation
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.link.scope import EXCITED
from camtools.panel import pieces
from camtools.panel.orders import loop_tuner
from camtools.panel.orders.commander import Commander, CommandLog, Visitor
from camtools.panel.orders.execute_order import ACTIONS
from camtools.panel.orders.loop_tuner import LoopTuner, Tuned
from camtools.panel.page_frame import repeat_newest
from tests.tools.cases.controller_cases import Seat

Sent = list[tuple[str, dict[Any, Any]]]


async def question_on(client: Client, sent: Sent, *, repeats: Callable[[Client], None]) -> None:
    """Close a question, lose its last update, open the next one, and connect again."""
    client._connected.set()
    client.tab_id = "tab"
    outbox = asyncio.create_task(client.outbox.loop())

    async def all_sent() -> None:
        while client.outbox.updates or client.outbox.messages:
            await asyncio.sleep(0)
        await asyncio.sleep(0)

    with client:
        first = ui.dialog(value=True)
    await all_sent()
    seen = client.outbox.next_message_id
    first.delete()
    await all_sent()
    with client, ui.dialog(value=True):
        ui.label("next")
    client.outbox.try_rewind(seen)
    repeats(client)
    await all_sent()
    client.outbox.stop()
    await outbox


@pytest.mark.parametrize(
    ("repeats", "is_open"), [(repeat_newest, True), (lambda client: None, False)]
)
def test_a_question_stays_open_over_a_reconnect(
    monkeypatch: pytest.MonkeyPatch, repeats: Callable[[Client], None], *, is_open: bool
) -> None:
    """NiceGUI by itself repeats an older list of the page's elements after the newest one."""
    sent: Sent = []

    async def emit(kind: str, data: dict[Any, Any], room: str) -> None:
        sent.append((kind, dict(data)))

    monkeypatch.setattr(core.sio, "emit", emit)
    config = SimpleNamespace(reconnect_timeout=10.0, message_history_length=10)
    monkeypatch.setattr(core.app, "config", config)
    client = Client(page("/"), request=None)
    try:
        asyncio.run(question_on(client, sent, repeats=repeats))
        shown: dict[int, Any] = {}
        for _, update in (one for one in sent if one[0] == "update"):
            shown |= update
        last = shown[client.layout.id]["children"]
        are_open = [(shown[i] or {}).get("props", {}).get("model-value") for i in last]
        assert any(are_open) is is_open
    finally:
        client.delete()


def test_a_page_loaded_anew_keeps_command_and_asks_again() -> None:
    """Only while the page before it is gone."""
    commander = Commander(CommandLog(None))
    before, after = Visitor("v1"), Visitor("v2")
    commander.take(before)
    commander.pass_on(before, after)
    assert commander.holder is before
    before.is_here = False
    commander.pass_on(Visitor("v3", is_here=False), after)
    assert commander.holder is before
    commander.pass_on(before, after)
    assert commander.holder is after
    commander.lose(after, "the page was away for 10 s")
    assert commander.holder is None and "away for 10 s" in commander.news(after)


def test_an_open_question_is_asked_again() -> None:
    """By its name on the new page; other names ask nothing."""
    client, asked = Client(page("/"), request=None), []

    async def ask() -> None:
        asked.append("start")

    try:
        with client:
            pieces.asks("start", ask)
        for name in ("None", "stop", "start"):
            asyncio.run(pieces.ask_again(client, name))
        assert asked == ["start"]
    finally:
        client.delete()


@pytest.mark.parametrize("rests", [True, False])
def test_a_measurement_needs_its_page_only_while_u_moves(
    seat: Seat, monkeypatch: pytest.MonkeyPatch, *, rests: bool
) -> None:
    """The record is read and the loop is computed although the page's connection is lost."""

    def measure(link: Link, arguments: Any, _say: object) -> str:  # noqa: ANN401
        if rests:
            arguments["rests"]()
        seat.service.page_lost(seat.boss)
        link.wait(lambda: False, 0.05)
        return "measured"

    monkeypatch.setitem(cast(Any, ACTIONS), "measure_loop", measure)
    outcome = seat.ask("measure_loop")
    assert outcome.is_done is rests
    assert outcome.text.startswith("measured" if rests else "interrupted: the connection was lost")


def test_u_rests_when_its_record_is_read_and_the_loop_may_take_its_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Computing has no limit; the link is served meanwhile."""
    told: list[str] = []

    def recorded(u: Any, _where: str) -> None:  # noqa: ANN401
        assert not told
        u._progress(1, 2)
        told.append("read")

    monkeypatch.setattr(loop_tuner, "recorded", recorded)
    monkeypatch.setattr(loop_tuner, "tuned", lambda one, where: Tuned("report", b"", {"a": 1}))
    looks = iter([False, False, True])
    link = cast(Link, SimpleNamespace(where="here", wait=lambda is_done, s: next(looks)))
    tuner = LoopTuner()
    tuner.measure(link, lambda work: None, lambda: told.append("rests"))
    assert told == ["rests", "read"] and tuner.newest is not None and tuner.newest.settings


def test_an_excitation_is_waited_for_in_the_controllers_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A status that comes late counts as 10 ms; one that does not come ends the wait."""
    status, looks = SimpleNamespace(n_rows=0), iter(["runs"] * 90 + ["done"])
    is_heard = True

    def next_row(_timeout_s: float) -> bool:
        status.n_rows += is_heard
        return is_heard

    link = cast(Any, SimpleNamespace(status=status, where="here", next_row=next_row))
    link.ask = link.wait = lambda *given: None
    monkeypatch.setattr(excitation, "require", lambda *given: None)
    monkeypatch.setattr(excitation, "phase", lambda link: "done")
    monkeypatch.setattr(excitation, "get", lambda link, name: EXCITED.index(next(looks, "runs")))
    assert excitation._follow(link, 1.0) == "done"
    with pytest.raises(Refused, match="not ended after 1 s"):
        excitation._follow(link, 1.0)
    is_heard = False
    with pytest.raises(Refused, match="status ended"):
        excitation._follow(link, 1.0)
