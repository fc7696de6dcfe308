"""What happens in each scenario; test_linux.py judges it. Runs inside the kernel (inside.py)."""

import signal
import sys
import time
from pathlib import Path

from tests.linux.inside import BLOCK_BYTES, Bus, Session, main


def cut_on(s: Session) -> None:
    """Cut until the machine has its end, whatever its words say goes wrong."""
    s.start_cut()
    s.wait_machine()
    s.seen["state"], s.seen["faults"] = s.state()
    s.stop_controller()


def flood(s: Session) -> None:
    """Fill the bus with foreign frames while cutting: eight of them in every millisecond."""
    bus = Bus("vcan0", 0x7FF)
    s.start_cut("--stay")
    until_s = time.monotonic() + 0.5
    n = 0
    while time.monotonic() < until_s:
        for _ in range(8):
            bus.send(0x555, b"\xff" * 8)
            n += 1
        time.sleep(1e-3)
    s.seen["n_foreign"] = n
    s.seen["state"], s.seen["faults"] = s.state()


def killed(s: Session) -> None:
    """Kill the controller while it cuts: nothing of it is left to stop the drives."""
    s.start_cut()
    time.sleep(s.setup["killed_after_s"])
    s.stop_controller(signal.SIGKILL)
    s.wait_machine()


def canopen_drive(s: Session) -> None:
    """Cut with a U drive that is not ours."""
    s.spawn("drive", sys.executable, str(Path(__file__).with_name("canopen_drive.py")))
    time.sleep(0.5)
    s.start_cut("--without", "u")
    s.wait_machine()
    s.stop_controller()


def download(s: Session) -> None:
    """Break a download off by a kill, at its ends and between; let camctl bring the table whole."""
    place = s.out / "table.camtab"
    before, other = place.read_bytes(), Path(s.setup["other_table"]).read_bytes()
    s.start_machine("--stay")
    n_most = -(-len(other) // BLOCK_BYTES)
    broken_off = (0, 1, n_most // 2, n_most - 1, n_most)
    for n_blocks in broken_off:
        s.start_controller()
        s.begin_download(other, n_blocks)
        s.stop_controller(signal.SIGKILL)
        assert place.read_bytes() == before, f"after {n_blocks} blocks"
    s.seen["n_broken_off"] = len(broken_off)
    s.start_controller()
    camctl = [sys.executable, "-m", "camtools.cli.camctl", "-i", "socketcan", "-c", "vcan0"]
    s.spawn("unlock", *camctl, "unlock")
    s.wait_said("unlock", "turn the key switch")
    s.turn_key()
    s.wait_said("unlock", "unlocked by the key switch")
    for words in (("table", "download", s.setup["other_table"]), ("select",), ("table", "info")):
        s.seen["camctl"] = s.spawn("camctl", *camctl, *words).wait(30)
        assert s.seen["camctl"] == 0, words
    assert place.read_bytes() == other
    s.stop_controller()


SCENARIOS = {f.__name__: f for f in (cut_on, flood, killed, canopen_drive, download)}

if __name__ == "__main__":
    sys.exit(main(SCENARIOS))
