"""The link's thread between two connections."""

import can
import pytest

from camtools.base.errors import CamtoolsError
from camtools.link.controller import Link
from camtools.panel.orders.commander import Visitor
from camtools.panel.orders.link_thread import Job, LinkThread
from camtools.panel.orders.snapshot import Snapshot
from checks.patience import limit_s, until
from tests.tools.cases.camctl_bench import Bench


@pytest.mark.parametrize("is_urgent", [False, True])
def test_what_was_given_as_a_connection_broke_is_not_carried_out_on_the_next(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, is_urgent: bool
) -> None:
    """The status was fresh still when the order was judged, the bus was closed when it waited."""
    is_there = False

    def open_link() -> Link:
        if not is_there:
            raise CamtoolsError(["no bus"])
        return Link(can.Bus(interface="virtual", channel=request.node.name), "the bench")

    bench, thread = (
        Bench(request.node.name),
        LinkThread(open_link, lambda: False, lambda text, holder: None),
    )
    try:
        until(lambda: thread.snapshot().problem == "no bus")
        job = Job("enable", {}, Visitor("v1"), is_urgent)
        with monkeypatch.context() as patch:
            patch.setattr(thread, "snapshot", lambda: Snapshot(is_connected=True))
            thread.give(job)
        is_there = True
        answer = job.outcome.result(limit_s())
        assert not answer.is_done and answer.text.startswith("not sent: ")
        until(lambda: thread.snapshot().is_connected)
        assert thread.snapshot().state == "off"
    finally:
        thread.close()
        bench.close()


def test_the_end_of_the_panel_while_nobody_answers_is_no_mistake(
    request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bus is there, a controller is not: nothing is printed when the panel ends."""
    is_opened: list[bool] = []

    def open_link() -> Link:
        is_opened.append(True)
        return Link(can.Bus(interface="virtual", channel=request.node.name), "nobody")

    thread = LinkThread(open_link, lambda: False, lambda text, holder: None)
    until(lambda: bool(is_opened))
    thread.close()
    assert capsys.readouterr().err == ""
