"""What reaches a panel that runs: its own pages with the token, and nothing else."""

import asyncio
import socket
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Mount, Route

from camtools.cli.panel import token_of
from camtools.panel.pages.runs import reports
from camtools.panel.runs.store import RunOptions, RunStore
from camtools.panel.server import middleware
from tests.browser.panel_session import Panel, panel_alone
from tests.tools.cases.raw_page import SOCKET, ask

PROXY = "lathe.example"
UPGRADE = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
UPGRADE |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
# What is asked for below the token: a page, an order as a form would send it, and the websocket.
ASKED = {
    "page": ("GET", "", {}),
    "post": ("POST", "", {"Content-Length": "0"}),
    "websocket": ("GET", f"{SOCKET}?EIO=4&transport=websocket", UPGRADE),
}
PASSED = {"page": 200, "post": 405, "websocket": 101}  # no page takes a POST
# Host and Origin, with {host} for what the panel is called; None: the header is missing.
OWN = [
    ("{host}", "http://{host}"),
    ("localhost:{port}", "http://localhost:{port}"),
    (f"{PROXY}", f"https://{PROXY}"),
]
REBOUND = ["evil.example", "evil.example:{port}", "127.0.0.1.evil.example:{port}", "{port}", ""]
FOREIGN = [
    *("http://evil.example", "null", "", "file://", "https://127.0.0.1", "http://127.0.0.1:1"),
    *("http://localhost:{port}", "http://{host}.evil.example", "http://evil.example/{host}"),
]
NO_TOKEN = [
    *("/", "//", "//{token}/", "/panel/panel.js", "/design", "/_nicegui/{token}/", "/{short}/"),
    *("/{token}x/", "/{swapped}/", "/*/", "/None/"),
]
VISITS = [
    *((kind, host, origin, "/{token}/", PASSED[kind]) for kind in ASKED for host, origin in OWN),
    ("page", "{host}", None, "/{token}/", 200),
    *((kind, host, f"http://{host}", "/{token}/", 400) for kind in ASKED for host in REBOUND),
    *((kind, "{host}", origin, "/{token}/", 403) for kind in ASKED for origin in FOREIGN),
    *((kind, "{host}", None, "/{token}/", 403) for kind in ("post", "websocket")),
    *((kind, "{host}", "http://{host}", path, 404) for kind in ASKED for path in NO_TOKEN),
]


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Panel]:
    """Run a panel for a proxy, which is not there."""
    with panel_alone(tmp_path_factory.mktemp("panel"), "--proxy-host", PROXY.title()) as alone:
        yield alone


@pytest.mark.parametrize(("kind", "host", "origin", "path", "wanted"), VISITS)
def test_only_own_pages_with_the_token_get_in(
    panel: Panel, kind: str, host: str, origin: str | None, path: str, wanted: int
) -> None:
    """DNS rebinding, pages of other sites, and users without the token are refused."""
    place = urlsplit(panel.url)
    token = place.path.strip("/")
    names = {"host": place.netloc, "port": place.port, "token": token}
    names |= {"short": token[:-1], "swapped": token.swapcase()}
    method, below, more = ASKED[kind]
    headers = more | {"Host": host.format(**names)}
    if origin is not None:
        headers["Origin"] = origin.format(**names)
    base = f"http://{place.netloc}"
    status, answer, content = ask(base, path.format(**names) + below, method, headers)
    assert status == wanted, content
    if wanted == 200:
        policy = answer["content-security-policy"].split("; ")
        assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
        assert answer["referrer-policy"] == "no-referrer"
    else:
        assert token not in content


def got_from(served: Starlette, path: str, headers: dict[str, str] | None = None) -> httpx.Response:
    """Return what an application answers."""

    async def got() -> httpx.Response:
        transport = httpx.ASGITransport(served)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            return await client.get(path, headers=headers)

    return asyncio.run(got())


@pytest.mark.parametrize(
    ("path", "origin", "wanted"),
    [
        ("/key/report", None, 200),
        ("/key/report", "null", 403),  # of the report's own scripts
        ("/token/", None, 200),
        ("/token/", "null", 403),
        ("/keys/report", None, 404),
        ("/", None, 404),
    ],
)
def test_a_key_opens_what_is_below_it(path: str, origin: str | None, wanted: int) -> None:
    """The token the pages, the key of reports nothing but these."""

    async def text(request: Request) -> PlainTextResponse:
        return PlainTextResponse(request.url.path)

    below = [Mount(f"/{key}", routes=[Route("/{rest:path}", text)]) for key in ("token", "key")]
    served = Starlette(routes=below, middleware=middleware(("token", "key"), []))

    assert got_from(served, path, {"Origin": origin} if origin else {}).status_code == wanted


def test_a_page_that_is_not_there_is_a_line(panel: Panel) -> None:
    """NiceGUI's page of it would stay in memory, and its address in the log."""
    place = urlsplit(panel.url)
    status, _, content = ask(f"http://{place.netloc}", f"{place.path}nowhere")
    assert (status, content) == (404, "no such page\n")


def test_it_listens_on_the_loopback_alone(panel: Panel) -> None:
    """A socket for all addresses would take this one, too."""
    port = urlsplit(panel.url).port
    with socket.create_connection(("127.0.0.1", port)):
        pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", port))


def test_tokens_are_not_to_be_guessed() -> None:
    """192 bits each."""
    tokens = {token_of(None) for _ in range(1000)}
    assert len(tokens) == 1000 and {len(token) for token in tokens} == {32}


@pytest.mark.long
def test_a_report_runs_its_scripts_in_no_origin(tmp_path: Path) -> None:
    """It reaches no network, only pages of the panel frame it, and nothing else is served."""
    store = RunStore(tmp_path / "runs", tmp_path / "run")
    folder = store.new("skirt", "[part]\n", RunOptions(), at_s=0.0, files={"a.csv": b"secret"})
    designs: Any = SimpleNamespace(store=store)
    get = partial(got_from, reports(designs))
    assert get("/own/skirt-001/report.html").status_code == 404
    (folder / "report.html").write_text("<p>report</p>")
    answer = get("/own/skirt-001/report.html")
    assert answer.text == "<p>report</p>"
    policy = answer.headers["content-security-policy"].split("; ")
    assert "default-src 'none'" in policy and "sandbox allow-scripts" in policy
    assert "frame-ancestors 'self'" in policy
    for path in ("/own/skirt-001/a.csv", "/own/..%2fruns/report.html", "/", "/own/skirt-001/"):
        assert get(path).status_code == 404
    (folder / "report.html").unlink()
    (folder / "report.html").symlink_to(folder / "a.csv")
    assert get("/own/skirt-001/report.html").status_code == 404
