"""The same controller on the host, fed with the senses of the one in the image (replay.c)."""

import os
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.stm32.board import FULL, STEP_PM
from tests.stm32.tick_trace import Record

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / os.environ.get("CAMTURN_BUILD", "build/host")
REPLAY = BUILD / "tests" / "stm32" / "stm32_replay"
IMAGE = ROOT / "build" / "mcu-stm32h743" / "hal" / "stm32h743" / "firmware.elf"
TICK_HZ, CLOCK_HZ = 20_000, 240_000_000
# stm_port.h: steps of a train of 3/4 tick, each at least 500 ns high and 500 ns low
STEPS_MOST = 37
MOST_UM_PER_S = {axis: (STEPS_MOST - 1) * pm * TICK_HZ // 10**6 for axis, pm in STEP_PM.items()}
SENSES = (
    "clock", "counts", "index_counts", "n_index", "edge_clock", "u_nm", "x_nm", "z_nm", "inputs",
)  # fmt: skip


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="camturn-stm32-")


@cache
def short_table() -> Path:
    """Return the table of the short part, made once."""
    path = Path(_folder().name) / "short.camtab"
    subprocess.run([REPLAY, "image", path], check=True)
    return path


def build_with(setting: str, value: str) -> Path:
    """Build the firmware with a setting of board_config.h; return the .elf."""
    folder = ROOT / "build" / f"mcu-stm32h743-{setting.lower()}-{value}"
    flag = f"-DCMAKE_C_FLAGS=-D{setting}={value}"
    configure = ["cmake", "--preset", "mcu-stm32h743", "-B", str(folder), flag]
    subprocess.run(configure, cwd=ROOT, check=True, capture_output=True)
    command = ["cmake", "--build", str(folder), "--target", "firmware"]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "hal" / "stm32h743" / "firmware.elf"


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
        [REPLAY, *map(str, (TICK_HZ, CLOCK_HZ, MOST_UM_PER_S["X"], MOST_UM_PER_S["Z"]))],
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


def steps(axis: str, value_nm: int) -> int:
    """Return the nearest whole number of steps, by stm_convert.h and board_config.h."""
    steps_q32 = ((1000 << 32) + STEP_PM[axis] // 2) // STEP_PM[axis]
    return (value_nm * steps_q32 + (1 << 31)) >> 32


def positions(axis: str, setpoints: Iterable[int], enabled: Iterable[int]) -> list[int]:
    """Return where a drive stands after every tick, by the rules of stm_port.h.

    Parameters
    ----------
    axis : str
        "X" or "Z"
    setpoints : iterable of int
        [nm] of every tick
    enabled : iterable of int
        the enable line of every tick
    """
    position = sent = direction = 0
    result = []
    for value_nm, is_on in zip(setpoints, enabled, strict=True):
        missing = steps(axis, value_nm) - sent
        sense = 1 if missing > 0 else -1
        if not is_on:
            sent += missing
        elif missing and sense != (1 if direction else -1):
            direction = int(sense > 0)
        elif missing:
            way = sense * min(abs(missing), STEPS_MOST)
            sent, position = sent + way, position + way
        result.append(position)
    return result
