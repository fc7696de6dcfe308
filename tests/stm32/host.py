# SPDX-License-Identifier: Apache-2.0
"""The same controller on the host, fed with the senses of the one in the image (replay.c)."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from board import FULL
from tick_trace import Record

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / os.environ.get("CAMTURN_BUILD", "build/host")
REPLAY = BUILD / "tests" / "stm32" / "stm32_replay"
IMAGE = ROOT / "build" / "mcu-stm32h743" / "hal" / "stm32h743" / "firmware.elf"
TICK_HZ, CLOCK_HZ = 20_000, 240_000_000
SENSES = (
    "clock", "counts", "index_counts", "n_index", "edge_clock", "u_nm", "x_nm", "z_nm", "inputs",
)  # fmt: skip


def make_table(path: Path) -> bytes:
    """Write the table of the short part; return its bytes."""
    subprocess.run([REPLAY, "image", path], check=True)
    return path.read_bytes()


@dataclass(frozen=True)
class Done:
    """What the host did in a tick."""

    setpoints: tuple[int, int, int, int]
    outputs: int
    state: int
    faults: int


def replay(records: Iterable[Record], changes: Iterable[str], n_before: int) -> list[Done]:
    """Let the host repeat the ticks of the image.

    Parameters
    ----------
    records : iterable of Record
        every tick since the start
    changes : iterable of str
        lines "table FILE" and "set PARAMETER VALUE" that made new configurations, in their order
    n_before : int
        how many of them were in force at the first tick
    """
    waiting = iter(changes)
    lines: list[str] = []
    config: int | None = None
    request = 0
    for record in records:
        n_new = n_before if config is None else record["config"] - config
        lines += [next(waiting) for _ in range(n_new)]
        config = record["config"]
        if record["request"] != request:
            request = record["request"]
            lines.append(f"request {request & 0xFF}")
        lines.append("tick " + " ".join(str(record[name]) for name in SENSES))
    left = list(waiting)
    assert not left, f"changes that never came into force: {left}"
    done = subprocess.run(
        [REPLAY, str(TICK_HZ), str(CLOCK_HZ)],
        input="\n".join(lines) + "\n",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [_decode(line) for line in done.stdout.splitlines()]


def _decode(line: str) -> Done:
    u_nm, x_nm, z_nm, spindle_mrpm, outputs, state, faults = (int(word) for word in line.split())
    return Done((u_nm, x_nm, z_nm, spindle_mrpm), outputs, state, faults)


def word(value: int, full: int) -> int:
    """Return the AD5754R's word for a set-point, by stm_convert.h and board_config.h.

    Two's complement, 2^15 codes for the value at +10 V, rounded to nearest, clamped.
    """
    codes_q32 = ((1 << 47) + full // 2) // full
    code = (value * codes_q32 + (1 << 31)) >> 32
    return max(-0x8000, min(0x7FFF, code)) & 0xFFFF


def words(done: Done) -> tuple[int, ...]:
    """Return the words of channels A .. D for a tick of the host."""
    return tuple(word(value, full) for value, full in zip(done.setpoints, FULL, strict=True))


def internal_word(u_nm: int) -> int:
    """Return the word of the chip's own DAC for U: offset binary, 12 bits."""
    return ((word(u_nm, FULL[0]) ^ 0x8000) & 0xFFFF) >> 4
