"""Estimate the cycles of a tick and the load of the processor.

The emulated core finds the longest tick of each session by an exact count, which is then stepped
through. Its instructions go through llvm-mca as one straight line, so conflicts in memory, cache
misses of the table, DMA and other interrupts are not included.

>>> load_percent(2400.0, STM32H743)
10.0
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from checks.mca import mca_cycles, straight_line, table_cycles, taken_branches
from checks.stepper import (
    InstructionTrace,
    Step,
    parse_listing,
    parse_symbols,
    run_tool,
    trace_calls,
)

ROOT = Path(__file__).resolve().parents[2]
HAL_HEADER = ROOT / "hal" / "include" / "hal" / "hal.h"
TICK_HZ = 20_000
# Arm, article 103489845, for the Cortex-M4; for the Cortex-M7 it gives 12 to 14 and no exit.
ENTRY_CYCLES, EXIT_CYCLES = 12, 10
_STATE_CYCLES = 2 * 17  # floating-point registers onto the stack and back
_ALLOWANCE = re.compile(r"<= (\d+)(?:\s|/)+cycles")
_HAL_FUNCTION = re.compile(r"^\w+ (hal_\w+_isr)\(", re.MULTILINE)


@dataclass(frozen=True)
class Processor:
    """A processor, and the emulated board that has its core.

    Attributes
    ----------
    name : str
    cpu : str
        Core, as llvm-mca calls it.
    preset, board : str
        Build preset, and the emulator's name of the board.
    clock_hz : int
    entry_late_cycles : int
        What an interrupt's entry may take above `ENTRY_CYCLES`.
    refill_cycles : int
        What a taken branch costs at most above llvm-mca's figure; 0: Arm publishes a table of
        cycles, which is taken instead.
    fetch_bytes, fetch_cycles : int
        Unit in which code comes from flash, and what the core waits for one.
    is_kept : bool
        A unit once fetched stays: it lies in a cache that is larger than a tick's code.
    """

    name: str
    cpu: str
    preset: str
    board: str
    clock_hz: int
    entry_late_cycles: int
    refill_cycles: int
    fetch_bytes: int
    fetch_cycles: int
    is_kept: bool


# 4 wait states at 240 MHz (RM0433, flash latency), then four beats of 64 bits, at two cycles of the
# core each: 18; the rest is an allowance for the bus. Refill: LLVM's note for the Cortex-M7.
STM32H743 = Processor(
    "STM32H743", "cortex-m7", "mcu-qemu", "mps2-an500", 480_000_000, 2, 6, 32, 28, True
)
# 4 wait states at 170 MHz, 64 bits wide with two banks (RM0440, flash latency).
STM32G474 = Processor(
    "STM32G474", "cortex-m4", "mcu-qemu-m4", "mps2-an386", 170_000_000, 0, 0, 8, 4, False
)


@dataclass(frozen=True)
class Span:
    """Cycles, least and most."""

    low: float
    high: float

    def __add__(self, other: Span) -> Span:
        return Span(self.low + other.low, self.high + other.high)

    def __str__(self) -> str:
        if self.low == self.high:
            return f"{self.low:.0f}"
        return f"{self.low:.0f} .. {self.high:.0f}"


@dataclass(frozen=True)
class Estimate:
    """What a tick takes; see `estimate`."""

    session: str
    instructions: int
    port_instructions: int
    branches: int
    core: Span
    port: Span
    interrupt: Span
    fetch: int

    @property
    def total(self) -> Span:
        """Return the sum for memory without wait states."""
        return self.core + self.port + self.interrupt


def load_percent(cycles: float, machine: Processor) -> float:
    """Return the share of a tick period, per cent."""
    return 100.0 * cycles * TICK_HZ / machine.clock_hz


def allowances(header: str) -> dict[str, int]:
    r"""Return the longest time of every HAL function of the interrupt, as hal.h states it.

    >>> allowances("/// <= 9 cycles\nvoid hal_x_isr(void);\n")
    {'hal_x_isr': 9}

    Raises
    ------
    CamtoolsError
        The header states none for a function.
    """
    found = {}
    begin = 0
    for function in _HAL_FUNCTION.finditer(header):
        stated = _ALLOWANCE.findall(header[begin : function.start()])
        if not stated:
            raise CamtoolsError([f"hal.h states no longest time for {function[1]}"])
        found[function[1]] = int(stated[-1])
        begin = function.end()
    return found


def fetch_cycles(executed: Sequence[Step], machine: Processor) -> int:
    """Return what the core waits for code that comes from flash, nothing fetched ahead.

    With a cache that holds a whole tick every unit is fetched once, else whenever the program
    enters another one.
    """
    units = [
        unit
        for i in executed
        for unit in range(
            i.address // machine.fetch_bytes, (i.address + i.size - 1) // machine.fetch_bytes + 1
        )
    ]
    if machine.is_kept:
        return len(set(units)) * machine.fetch_cycles
    entered = 1 + sum(a != b for a, b in pairwise(units))
    return entered * machine.fetch_cycles


def _hal_of(addresses: Sequence[int], symbols: Mapping[str, tuple[int, int]]) -> list[str]:
    """Return the HAL function that each address lies in, "" for the firmware's own code."""
    places = [(n, at, at + size) for n, (at, size) in symbols.items() if n.startswith("hal_")]
    name_of = {a: n for a in set(addresses) for n, begin, end in places if begin <= a < end}
    return [name_of.get(a, "") for a in addresses]


def _core_cycles(executed: Sequence[Step], machine: Processor) -> Span:
    low = mca_cycles(straight_line(executed), machine.cpu)
    if machine.refill_cycles:
        return Span(low, low + machine.refill_cycles * taken_branches(executed))
    return Span(low, max(low, table_cycles(executed)))


def estimate(
    trace: InstructionTrace,
    listing: Mapping[int, Step],
    symbols: Mapping[str, tuple[int, int]],
    machine: Processor,
    allowed: Mapping[str, int],
) -> Estimate:
    """Estimate the cycles of one tick.

    Parameters
    ----------
    trace : InstructionTrace
        What was executed.
    listing, symbols : mapping
        Instructions and functions of the image.
    machine : Processor
        Where it would run.
    allowed : mapping
        Longest times of the HAL functions, from `allowances`.

    Returns
    -------
    Estimate
        `core` is the firmware alone, `port` from the emulator's port as it stands to what hal.h
        allows, `interrupt` entry and exit; `fetch` comes on top when all code is in flash and
        none of it in a cache.

    Raises
    ------
    CamtoolsError
        The trace shows no HAL function, so port and firmware cannot be separated.
    """
    hal = _hal_of(trace.addresses, symbols)
    everything = [listing[a] for a in trace.addresses]
    firmware = [i for i, name in zip(everything, hal, strict=True) if not name]
    calls = Counter(
        n for n, i in zip(hal, everything, strict=True) if n and i.address == symbols[n][0]
    )
    if not calls:
        msg = "no HAL function was called by name: build without link-time optimisation"
        raise CamtoolsError([msg])
    core = _core_cycles(firmware, machine)
    port = mca_cycles(straight_line(everything), machine.cpu) - core.low
    uses_fpu = any(i.name.startswith("v") for i in everything)
    interrupt = ENTRY_CYCLES + EXIT_CYCLES
    late = machine.entry_late_cycles + (_STATE_CYCLES if uses_fpu else 0)
    return Estimate(
        session=trace.name,
        instructions=len(everything),
        port_instructions=len(everything) - len(firmware),
        branches=taken_branches(firmware),
        core=core,
        port=Span(port, max(port, sum(allowed[n] * count for n, count in calls.items()))),
        interrupt=Span(interrupt, interrupt + late),
        fetch=fetch_cycles(firmware, machine),
    )


def table(machine: Processor, estimates: Sequence[Estimate]) -> str:
    """Return the estimates of one machine as a table in Markdown."""
    heads = [f"{machine.name} at {machine.clock_hz / 1e6:.0f} MHz", *(e.session for e in estimates)]
    rows = [
        ("instructions of the longest tick", [str(e.instructions) for e in estimates]),
        ("of these the emulator's port", [str(e.port_instructions) for e in estimates]),
        ("branches taken by the firmware", [str(e.branches) for e in estimates]),
        ("cycles: firmware", [str(e.core) for e in estimates]),
        ("port", [str(e.port) for e in estimates]),
        ("interrupt entry and exit", [str(e.interrupt) for e in estimates]),
        ("sum, code in memory without wait states", [str(e.total) for e in estimates]),
        (f"load at {TICK_HZ // 1000} kHz, %", [_load(e.total, machine) for e in estimates]),
        ("cycles more, all code cold in flash", [str(e.fetch) for e in estimates]),
        (
            "load with these, at most, %",
            [f"{load_percent(e.total.high + e.fetch, machine):.1f}" for e in estimates],
        ),
    ]
    lines = [heads, ["---"] * len(heads), *([name, *cells] for name, cells in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _load(cycles: Span, machine: Processor) -> str:
    low, high = load_percent(cycles.low, machine), load_percent(cycles.high, machine)
    return f"{low:.1f} .. {high:.1f}"


def report(build: Path, machine: Processor) -> str:
    """Step through the image of a preset; return the table of ticks."""
    image = build / machine.preset / "tests" / "budget" / "trace_tick"
    symbols = parse_symbols(run_tool(["arm-none-eabi-nm", "-S", image]))
    listing = parse_listing(run_tool(["arm-none-eabi-objdump", "-d", image]))
    traces = trace_calls(image, machine.board, symbols)
    allowed = allowances(HAL_HEADER.read_text(encoding="utf-8"))
    ticks = [estimate(trace, listing, symbols, machine, allowed) for trace in traces]
    return f"{table(machine, ticks)}\n"


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="tests/bench/cycles",
        description="Estimate the cycles of a tick on both cores, and the load at 20 kHz.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "build",
        type=Path,
        nargs="?",
        default=ROOT / "build",
        metavar="BUILD",
        help="folder that holds the presets mcu-qemu and mcu-qemu-m4; default: build",
    )
    return parser


def _main(build: Path) -> int:
    for machine in (STM32H743, STM32G474):
        sys.stdout.write(report(build, machine))
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    _options = _parser().parse_args()
    sys.exit(run_command("cycles", lambda: _main(_options.build)))
