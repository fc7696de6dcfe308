# SPDX-License-Identifier: Apache-2.0
"""A page of another site, open in the same browser, can do nothing with the panel."""

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from tests.browser.overheard import Overheard
from tests.browser.panel_session import PanelSession
from tests.browser.windows import OpenWindow

# Every way that a page has to reach another server; what it learns is a line each.
ATTACK = """async ([origin, host, hasFrames]) => {
    const path = "/_nicegui_ws/socket.io/?EIO=4&transport=";
    const told = {};
    const tries = {
        read: () => fetch(origin + "/").then(r => r.text()),
        post: () => fetch(origin + "/", {method: "POST", body: "x=1"}).then(r => r.status),
        poll: () => fetch(origin + path + "polling").then(r => r.text()),
    };
    for (const [name, run] of Object.entries(tries)) {
        told[name] = await run().then(String, () => "nothing");
    }
    // What no answer is wanted of is sent without asking the server before.
    await fetch(origin + "/", {method: "POST", mode: "no-cors", body: "x=1"}).catch(() => {});
    told.socket = await new Promise(done => {
        const socket = new WebSocket("ws://" + host + path + "websocket");
        socket.onmessage = event => done(String(event.data));
        socket.onclose = socket.onerror = () => done("nothing");
    });
    if (!hasFrames) return told;
    const frame = document.createElement("iframe");
    frame.src = origin + "/";
    const loaded = new Promise(done => (frame.onload = frame.onerror = done));
    document.body.append(frame);
    await loaded;
    told.frame = (() => {
        try { return frame.contentDocument === null ? "nothing" : frame.contentDocument.title; }
        catch { return "nothing"; }
    })();
    const form = document.createElement("form");
    Object.assign(form, {action: origin + "/", method: "post", target: "sink"});
    const sink = Object.assign(document.createElement("iframe"), {name: "sink"});
    document.body.append(sink, form);
    const posted = new Promise(done => (sink.onload = done));
    form.submit();
    await posted;
    return told;
}"""


class _Silent(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture
def other_site(tmp_path: Path) -> Iterator[str]:
    """Serve a page from another port: another origin."""
    (tmp_path / "index.html").write_text("<!doctype html><title>bait</title>", "utf-8")
    handler = partial(_Silent, directory=str(tmp_path))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()
        thread.join()


def test_another_site_reads_nothing_and_does_nothing(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow, other_site: str
) -> None:
    """Neither by requests, forms and sockets nor in a frame; what it tries works from the panel."""
    window = open_window()
    window.expected += [r"^error: "]  # the browser tells what it was denied
    n_logged = len(session.logged())
    window.page.goto(other_site)
    where = [session.origin, session.origin.removeprefix("http://")]
    told = window.page.evaluate(ATTACK, [*where, True])
    assert told == dict.fromkeys(("read", "post", "poll", "socket", "frame"), "nothing")
    for frame in window.page.frames[1:]:
        assert frame.locator("[data-testid]").count() == 0, frame.url
    assert overheard.status().state == "off"
    assert not any(line["is_done"] for line in session.logged()[n_logged:])
    window.page.goto(session.origin)
    told = window.page.evaluate(ATTACK, [*where, False])
    assert "<html" in told["read"]
    assert told["socket"].startswith("0{"), "socket.io says hello"
