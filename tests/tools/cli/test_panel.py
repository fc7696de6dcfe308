"""tools/panel as a program: what is wrong is one line, and its end leaves nothing behind."""

import signal
import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from camtools.cli.panel import main
from camtools.link.live_lathes import announced
from tests.tools.cases.background import background, python
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.part_cases import Capture
from tests.tools.cases.raw_page import ask, hear_until, open_page


@pytest.fixture(autouse=True)
def folder(no_bus: Path, tmp_path: Path) -> Iterator[Path]:
    """Return the test's folder; no lathe may be announced at the end."""
    yield tmp_path
    assert not list(no_bus.glob("camturn/*"))


def refused(capsys: Capture, folder: Path, *words: str | Path) -> str:
    """Return the one line of what must be refused."""
    first = ["--port", "0", "--log", str(folder / "a.jsonl")]
    line = complaint(main, [*first, *map(str, words)], capsys)
    assert line.startswith("panel: "), line
    return line.removeprefix("panel: ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--proxy-host", "*"], "*: give a name such as lathe.example, without port"),
        (["--proxy-host", "lathe.example:80"], "lathe.example:80: give a name such as"),
        (["--port", "70000"], "70000: give 0 .. 65535"),
        (["-i", "socketcand"], "socketcand: needs channel, host, port"),
        (["--live", "a", "-i", "virtual"], "--live a: has its own bus; leave out interface"),
        (["--log", "/proc/nosuch/a"], "/proc/nosuch/a: No such file or directory; give another"),
        (["--token-file", "/nosuch"], "--token-file /nosuch: No such file or directory"),
        (["--token-file", "/"], "--token-file /: Is a directory"),
    ],
)
def test_what_is_wrong_is_told(folder: Path, words: list[str], said: str, capsys: Capture) -> None:
    """It names the option and the remedy; nothing was started."""
    assert said in refused(capsys, folder, *words)


@pytest.mark.parametrize(
    ("mode", "text", "said"),
    [
        (0o644, "a" * 20, "others may read it; chmod 600"),
        (0o600, "short", "give 16 .. 200 letters, digits, - and _"),
        (0o600, "two words, both too long", "give 16 .. 200 letters"),
        (0o600, "a/path/of/a/token/", "give 16 .. 200 letters"),
        (0o600, "\u00e4" * 20, "not ASCII"),
    ],
)
def test_a_token_file_that_protects_nothing_is_refused(
    folder: Path, mode: int, text: str, said: str, capsys: Capture
) -> None:
    """The token itself is not printed."""
    path = folder / "token"
    path.write_text(text, "utf-8")
    path.chmod(mode)
    line = refused(capsys, folder, "--token-file", path)
    assert said in line and text not in line


def test_a_port_in_use_is_told(folder: Path, capsys: Capture) -> None:
    """With the remedy."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused(capsys, folder, "--port", str(port))
    assert line == f"127.0.0.1 port {port}: Address already in use; give another --port"


def test_of_two_live_lathes_one_must_be_named(folder: Path, no_bus: Path, capsys: Capture) -> None:
    """As for camctl."""
    runtime = no_bus / "camturn"
    runtime.mkdir(mode=0o700)
    facts = {"bus": {"interface": "virtual", "channel": "x"}, "node": 64}
    with ExitStack() as stack:
        for name in ("one", "two"):
            stack.enter_context(announced(runtime, name, facts))
        assert "2 live lathes are running: one, two; give --live NAME" in refused(capsys, folder)


def test_its_end_leaves_nothing_behind(folder: Path, no_bus: Path) -> None:
    """Without a controller it serves, says what to start, and ends at once with a page open."""
    token = folder / "token"
    token.write_text("sixteen-letters-or-more\n", "ascii")
    token.chmod(0o600)
    log = folder / "log" / "a.jsonl"
    words = python("camtools.cli.panel", "--port", "0", "--log", log, "--token-file", token)
    with background(*words, XDG_RUNTIME_DIR=str(no_bus)) as panel:
        line = panel.wait_for("/sixteen-letters-or-more/")
        url = line.split()[1]
        with open_page(url) as page:
            hear_until(page, "start tools/live")
            assert panel.end(signal.SIGTERM) == 0, panel.text()
        assert "Traceback" not in panel.text()
    assert [path.name for path in log.parent.iterdir()] == ["a.jsonl"]
    with pytest.raises(OSError, match="refused"):
        ask(url, "/")
