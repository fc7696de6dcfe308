"""tools/live: a session through camctl as an operator has it, and what is left when one dies."""

import io
import json
import os
import re
import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest

from camtools.cli.camctl import main as camctl
from camtools.cli.camctl_control import refuse_fault
from camtools.cli.live import main as live_main
from camtools.link.live_lathes import LiveLathe, live_lathes, only_lathe
from camtools.link.messages import Refused
from camtools.link.status_text import report
from checks.patience import until
from tests.tools.cases.background import Background, background, python
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.live_cases import live_case
from tests.tools.cases.part_cases import ROOT, Capture, TableOf

PART = ROOT / "tools" / "parts" / "perkins240.toml"


class Live(Background):
    """tools/live as a process."""

    def __init__(self, *words: str) -> None:
        super().__init__(python("camtools.cli.live", PART, *words), {})
        self.wait_for(" real time")
        self.wait_for("for your own programs with python-can: export CAN_INTERFACE=")
        self.wait_for("control-C ends")

    def do(self, word: str) -> None:
        """Type a line, and wait until it has happened."""
        self.type(word)
        self.wait_for(f"{word}: done")


@contextmanager
def living(*words: str) -> Iterator[Live]:
    """Run tools/live, which must leave neither process nor file behind."""
    live = Live(*words)
    lathes = [one for one in live_lathes() if one.facts["pid"] == live.process.pid]
    try:
        yield live
    finally:
        status = live.end()
    assert status == 0, live.text()
    for lathe in lathes:
        for role in ("lathe_pid", "controller_pid"):
            assert not Path(f"/proc/{lathe.facts[role]}").exists()


@pytest.fixture(autouse=True)
def folder(no_bus: Path) -> Iterator[Path]:
    """Return the folder of announcements, which must be empty at the end."""
    yield no_bus / "camturn"
    assert not list(no_bus.glob("camturn/*"))


@pytest.fixture
def live(folder: Path) -> Iterator[Live]:
    """Run a lathe."""
    with living() as one:
        yield one


def run(*words: str | Path) -> tuple[int, str]:
    """Run camctl without naming a bus."""
    out = io.StringIO()
    return camctl([str(word) for word in words], out), out.getvalue()


def do(*words: str | Path) -> str:
    """Run camctl, which must succeed."""
    status, text = run(*words)
    assert status == 0, text
    return text


def succeeds(*words: str | Path) -> bool:
    """Run camctl; return whether it succeeded."""
    return run(*words)[0] == 0


def named_lathe(name: str) -> LiveLathe:
    """Return a lathe that runs."""
    lathe = only_lathe(name)
    assert lathe is not None
    return lathe


def cutting() -> AbstractContextManager[Background]:
    """Start a cut, as an operator does in a terminal of its own."""
    return background(*python("camtools.cli.camctl", "start"))


def look_at_ticks(folder: Path) -> None:
    """Record ticks of the cut that another camctl of the same user has started."""
    rows = folder / "rows.csv"
    do("scope", rows, "--signals", "u_set_q6,u_actual_nm", "--every", "10", "--seconds", "0.1")
    assert len(rows.read_text("ascii").splitlines()) > 50


@pytest.mark.long
def test_a_session_as_an_operator_has_it(live: Live, tmp_path: Path, table_of: TableOf) -> None:
    """From the download to a fault and its reset by camctl without an option, at a slow feed."""
    assert "state             off" in do("status")
    assert "generation 2" in do("table", "download", table_of("perkins240"), "--select")
    assert do("home") == "home: ready\n"
    assert do("feed", "0.05") == "feed = 0.05 mm\n"
    with cutting() as cut:
        assert "r/min" in do("watch", "--seconds", "1.5", "--every", "0.5")
        until(lambda: "cutting" in do("status"), "cutting")
        look_at_ticks(tmp_path)
        live.do("estop")
        until(lambda: "faults            estop" in do("status"), "estop")
        cut.wait_for("camctl: fault: estop")
    until(lambda: succeeds("blackbox", tmp_path / "box.parquet"), "the black box")
    live.do("release")
    until(lambda: succeeds("reset"), "reset")
    assert do("home") == "home: ready\n"
    with cutting() as cut:
        cut.wait_for("cutting: ")
        do("stop")
        cut.wait_for("start: the cut was stopped ")
    gauged = re.search(r"form error max ([\d.]+) um", live.wait_for("part 2: "))
    assert gauged is not None and float(gauged[1]) < 1.0
    until(lambda: "state             ready" in do("status"), "ready")
    assert "error of U" in do("learned")
    # `start` may have been ended before it had given command back, which is then lost.
    until(lambda: run("disable") == (0, "disable: off\n"), "off")


@pytest.mark.long
def test_two_live_lathes_and_their_deaths(live: Live, capsys: Capture) -> None:
    """Without a name camctl says which there are; each bus is its own.

    A lathe that is killed is a fault of drives and bus, and the controller continues. When a
    controller is killed, the drives brake to rest; camctl has nobody to talk to.
    """
    with living("--name", "other") as other:
        assert run("status")[0] == 2
        assert (
            "2 live lathes are running: other, perkins240; give --live NAME"
            in capsys.readouterr().err
        )
        do("--live", "other", "home")
        assert "state             off" in do("--live", "perkins240", "status")
        assert run("--live", "third", "status")[0] == 2
        assert "there is other, perkins240" in capsys.readouterr().err
        assert run("--live", "other", "-i", "virtual", "status")[0] == 2
        assert "has its own bus; leave out interface" in capsys.readouterr().err
        first = ("--live", "perkins240")
        do(*first, "home")
        os.kill(named_lathe("perkins240").facts["lathe_pid"], signal.SIGKILL)
        live.wait_for("was ended by signal 9; the controller continues")
        until(lambda: "faults            drive, bus" in do(*first, "status"), "the fault")
        assert run(*first, "reset")[0] == 1 or run(*first, "enable")[0] == 1, "no drives"
        os.kill(named_lathe("other").facts["controller_pid"], signal.SIGKILL)
        other.wait_for("lathe: the controller is gone")
        other.wait_for("lathe: at rest")
        capsys.readouterr()
        assert run("--live", "other", "status")[0] == 1
        assert "live lathe other" in capsys.readouterr().err


def test_what_a_killed_one_left_behind_is_not_believed(folder: Path) -> None:
    """The process is gone, or its number has been given to another one."""
    folder.mkdir(mode=0o700)
    facts = {"bus": {"interface": "virtual"}, "node": 64, "pid": os.getpid(), "start": "1"}
    (folder / "old.json").write_text(json.dumps(facts), "ascii")
    (folder / "torn.json").write_text("{", "ascii")
    assert live_lathes() == []


def test_a_folder_of_others_is_refused(folder: Path, capsys: Capture) -> None:
    """An announcement tells programs where to send commands: others must not write one."""
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    assert run("status")[0] == 2
    assert "0700" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--", "--set", "k1_ns=-1"], "camsim: --set: k1_ns = -1: out of range"),
        (["--machine", "nosuch"], "live: --machine nosuch: no such machine; give one of "),
        (["-i", "socketcand"], "live: socketcand: needs channel, host, port; give --channel .. "),
        (["--speed-up", "1000"], "live: argument --speed-up: 1000: give 0.01 .. 100; see "),
    ],
)
def test_what_is_wrong_leaves_nothing(words: list[str], said: str, capfd: Capture) -> None:
    """Status 2, and no process was kept."""
    line = complaint(live_main, [str(PART), *words], capfd)
    assert line.startswith(said), line


def test_a_spindle_that_turns_backwards_is_named(tmp_path: Path) -> None:
    """Homing ends with its speed; the status has the keys that mend it."""
    with live_case(tmp_path, "--speed-up", "5") as case:
        case.lathe.type("reverse")
        case.order("home", "fault")
        link = case.link
        with pytest.raises(
            Refused, match=r"^fault: spindle_stopped \(the spindle turns at -\d+ r/m"
        ):
            refuse_fault(link)
        text = "\n".join(report(link.listen()))
    assert "spindle_stopped: The spindle does not turn in the sense of cutting. Check" in text
    assert "reverse its drive, or change encoder_sign, or process.direction of the part." in text
