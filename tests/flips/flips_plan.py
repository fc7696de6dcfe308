# SPDX-License-Identifier: Apache-2.0
"""Chooses what is struck and when: strata, places in them, instructions of a tick."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from flips_image import CHECKPOINTS, MEMORY, PERIOD, REGISTER, STACK, Result, Strike
from flips_layout import Layout

ROOT = Path(__file__).resolve().parents[2]
TICKS = 16  # behind a checkpoint: two plans and what is between them
SHARES = {  # of all strikes
    "registers, interrupt": 0.30,
    "registers, main loop": 0.06,
    "stack": 0.08,
    "state": 0.22,
    "records": 0.03,
    "configuration": 0.12,
    "slow side": 0.05,
    "table": 0.06,
    "code": 0.06,
    "constants": 0.02,
}
RECORDS = ("state.gather", "state.trace")
REGISTERS = [*(f"r{i}" for i in range(13)), "sp", "lr", "pc", "xPSR"]
FLAG_BITS = (31, 30, 29, 28, 27, 24)  # of xPSR: N, Z, C, V, Q, and T


@dataclass(frozen=True)
class Place:
    """A piece of memory."""

    name: str
    address: int
    size: int


def _symbols(image: Path) -> list[tuple[int, int, str, str]]:
    """Return address, size, type and name of all symbols that have a size."""
    command = ["arm-none-eabi-nm", "-S", "-n", str(image)]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in said.splitlines())
    return [(int(r[0], 16), int(r[1], 16), r[2], r[3]) for r in rows if len(r) == 4]


def interrupt_places(image: Path) -> tuple[list[Place], list[Place]]:
    """Return functions and constants of firmware/tick and firmware/table's evaluator."""
    text = "".join(
        path.read_text()
        for folder in ("tick", "table", "base")
        for path in (ROOT / "firmware" / folder).glob("cam_*")
    )
    defined = set(re.findall(r"^[a-zA-Z_][^;{}=#\n]*?\b(\w+)\(", text, re.M))
    constants = set(re.findall(r"\bconst\b[^;{}=]*?\b(\w+)\[[^;]*?\]\s*=", text))
    code, data = [], []
    for address, size, kind, name in _symbols(image):
        plain = name.split(".")[0]
        if kind in "tT" and ((plain in defined and "_isr" in plain) or plain in HOT):
            code.append(Place(f"code.{plain}", address & ~1, size))
        elif kind in "rR" and plain in constants:
            data.append(Place(f"constants.{plain}", address, size))
    return code, data


HOT = {
    "surface", "move_u", "plan_isr", "rest", "cam_isr", "obey", "command", "cam_tick_isr",
    "cam_plan_isr", "flips_tick_isr",
}  # fmt: skip


class Sites:
    """Names what was struck: parts of the state, functions of the code."""

    def __init__(self, image: Path, told: dict[str, tuple[int, int]]) -> None:
        self.parts = [Place(n, a, s) for n, (a, s) in told.items() if not n.startswith("limit.")]
        self.layout = Layout(image, ("g_cam", "flips_machine"))
        self.functions = [
            Place(name, address & ~1, size)
            for address, size, kind, name in _symbols(image)
            if kind in "tT"
        ]

    def of_address(self, address: int) -> str:
        """Return the member of the state, or the part and the offset in it."""
        if (name := self.layout.of_address(address)) is not None:
            return name
        for place in self.parts:
            if place.address <= address < place.address + place.size:
                return f"{place.name}+{address - place.address}"
        return f"0x{address:08x}"

    def of_code(self, address: int) -> str:
        """Return the function."""
        for place in self.functions:
            if place.address <= address < place.address + place.size:
                return place.name
        return f"0x{address:08x}"


class Planner:
    """Draws strikes of a seed."""

    def __init__(
        self, image: Path, told: dict[str, tuple[int, int]], golden: Sequence[Result], seed: int
    ) -> None:
        self.golden = golden
        self.rng = np.random.default_rng(seed)
        code, constants = interrupt_places(image)
        parts = [Place(n, a, s) for n, (a, s) in told.items() if not n.startswith("limit.")]
        self.places = {
            "state": [p for p in parts if p.name.startswith("state.") and p.name not in RECORDS],
            "records": [p for p in parts if p.name in RECORDS],
            "configuration": [p for p in parts if p.name.startswith("config.")],
            "slow side": [p for p in parts if p.name.startswith("slow.")],
            "table": [p for p in parts if p.name.startswith("table.")],
            "code": code,
            "constants": constants,
        }

    def bytes_of(self, stratum: str) -> int:
        """Return how many bytes a stratum has, 0 where that is not told."""
        return sum(p.size for p in self.places.get(stratum, []))

    def when(self, *, is_main: bool) -> tuple[int, int, int]:
        """Return checkpoint, tick and place in the tick, uniform over the time at work."""
        while True:
            checkpoint = int(self.rng.integers(CHECKPOINTS))
            tick = int(self.rng.integers(1, TICKS + 1))
            ticks = self.golden[checkpoint].ticks
            begin, end = int(ticks[tick]["begin"]), int(ticks[tick]["end"])
            if is_main:
                idle = int(ticks[tick + 1]["idle"])
                begin, end = end, idle if idle > end + 500 else PERIOD
            at = int(self.rng.integers(PERIOD)) if is_main else int(self.rng.integers(6000))
            if begin <= at < end:
                return checkpoint, tick, at

    def _byte(self, stratum: str) -> int:
        places = self.places[stratum]
        ends = np.cumsum([p.size for p in places])
        at = int(self.rng.integers(ends[-1]))
        i = int(np.searchsorted(ends, at, side="right"))
        return places[i].address + places[i].size - (int(ends[i]) - at)

    def _register(self) -> tuple[int, int]:
        number = int(self.rng.integers(len(REGISTERS)))
        bit = int(self.rng.integers(32))
        if REGISTERS[number] == "xPSR":
            bit = int(self.rng.choice(FLAG_BITS))
        elif REGISTERS[number] == "sp":  # the lowest two read as 0
            bit = int(self.rng.integers(2, 32))
        elif REGISTERS[number] == "pc":  # so does the lowest
            bit = int(self.rng.integers(1, 32))
        return number, bit

    def draw(self, stratum: str) -> Strike:
        """Return one strike in a stratum."""
        checkpoint, tick, at = self.when(is_main=stratum == "registers, main loop")
        if stratum.startswith("registers"):
            number, bit = self._register()
            return Strike(checkpoint, tick, at, REGISTER, number, bit, stratum)
        bit = int(self.rng.integers(8))
        if stratum == "stack":
            share = int(self.rng.integers(1 << 32))
            return Strike(checkpoint, tick, at, STACK, share, bit, stratum)
        return Strike(checkpoint, tick, at, MEMORY, self._byte(stratum), bit, stratum)

    def plan(self, count: int) -> list[Strike]:
        """Return as many strikes, by the shares of the strata."""
        return [
            self.draw(stratum)
            for stratum, share in SHARES.items()
            for _ in range(max(1, round(count * share)))
        ]
