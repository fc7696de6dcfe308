# SPDX-License-Identifier: Apache-2.0
"""How fast mkgcode writes C-X-Z-U programs, and how much memory it takes; see README.md."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PARTS = Path(__file__).resolve().parents[2] / "tools" / "parts"
FEEDS_MM = ("0.01", "0.001")
MODES = (("uniform", "2500"), ("equal-volume", "200"))


def measure(folder: Path, mode: str, rpm: str, feed_mm: str) -> str:
    """Return a line about one program, written in a process of its own."""
    part, program = folder / "part.toml", folder / "part.ngc"
    text = (PARTS / "perkins240_equal_volume.toml").read_text()
    for old, new in (
        ('mode = "equal-volume"', f'mode = "{mode}"'),
        ("spindle_rpm = 230 ", f"spindle_rpm = {rpm} "),
        ("feed_mm = 0.1 ", f"feed_mm = {feed_mm} "),
    ):
        assert old in text
        text = text.replace(old, new)
    part.write_text(text)
    command = [sys.executable, "-m", "camtools.cli.mkgcode", str(part), "-o", str(program)]
    start_s = time.monotonic()
    child = subprocess.Popen([*command, "--axes", "cxzu"])
    _, status, usage = _wait(child)
    took_s = time.monotonic() - start_s
    assert status == 0
    with program.open("rb") as stream:
        n = sum(line.startswith(b"G1 C") for line in stream)
    rate, megabytes = n / took_s, program.stat().st_size / 1e6
    return (
        f"{mode:<13} {n:>9} blocks {megabytes:>6.0f} MB {took_s:>6.1f} s "
        f"{rate:>8.0f} blocks/s, memory {usage.ru_maxrss / 1024:.0f} MB"
    )


def _wait(child: subprocess.Popen[bytes]) -> tuple[int, int, resource.struct_rusage]:
    pid, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return pid, child.returncode, usage


def main() -> int:
    """Print a line per program."""
    with tempfile.TemporaryDirectory() as name:
        for mode, rpm in MODES:
            for feed_mm in FEEDS_MM:
                print(measure(Path(name), mode, rpm, feed_mm), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
