# SPDX-License-Identifier: Apache-2.0
"""Runs the image in the emulator: strikes go in by a file, what happened comes back by another."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event

import numpy as np
from numpy.typing import NDArray

NOTHING, REGISTER, MEMORY, STACK = range(4)
RAN, EXCEPTION, WATCHDOG, HALT, LOCKUP = range(5)
CHECKPOINTS = 6
PERIOD = 20000  # counts of the ticker in a tick
PATIENCE_S = 4.0  # of the emulator's own time without a result: the core is caught somewhere
EMULATOR = [
    *("qemu-system-arm", "-M", "mps2-an500", "-icount", "shift=7", "-nographic"),
    *("-monitor", "none", "-serial", "none"),
    *("-semihosting-config", "enable=on,target=native"),
]
HEAD = struct.Struct("<12I")
TICK = np.dtype(
    [
        ("nm", "<i4", 3),
        ("spindle_mrpm", "<i4"),
        ("outputs", "<u4"),
        ("faults", "<u4"),
        ("begin", "<u4"),
        ("end", "<u4"),
        ("idle", "<u4"),
    ]
)


@dataclass(frozen=True)
class Strike:
    """One bit that flips: when, where."""

    checkpoint: int
    tick: int = 0
    at: int = 0
    kind: int = NOTHING
    place: int = 0
    bit: int = 0
    stratum: str = ""


@dataclass(frozen=True)
class Result:
    """What happened; `ticks` is the trace from tick `first` on."""

    number: int  # among the strikes of its start of the emulator
    end: int
    detail: int
    pc: int
    address: int
    is_struck: bool
    n_ticks: int
    idle_tick: int
    digest: int
    first: int
    ticks: NDArray[np.void]


class ImageError(RuntimeError):
    """The image did not do its part."""


class StoppedError(RuntimeError):
    """Somebody wants the campaign to end."""


def read_map(folder: Path) -> dict[str, tuple[int, int]]:
    """Return address and size of every part of the state, as the image told them."""
    lines = (folder / "flips.map").read_text().split("\n")
    return {n: (int(a), int(s)) for n, a, s in (line.split() for line in lines if line)}


def _pack(strikes: Sequence[Strike]) -> bytes:
    words = struct.Struct("<8I")
    return b"".join(
        words.pack(i, s.checkpoint, s.tick, s.at, s.kind, s.place, s.bit, 0)
        for i, s in enumerate(strikes)
    )


def _parse(data: bytes) -> list[Result]:
    results, at = [], 0
    while at + HEAD.size <= len(data):
        number, end, detail, pc, address, struck, n, idle, digest, _, first, told = (
            HEAD.unpack_from(data, at)
        )
        stop = at + HEAD.size + told * TICK.itemsize
        if stop > len(data):
            break
        ticks = np.frombuffer(data, TICK, told, at + HEAD.size)
        results.append(
            Result(number, end, detail, pc, address, bool(struck), n, idle, digest, first, ticks)
        )
        at = stop
    return results


def _cpu_seconds(pid: int) -> float:
    """Return how long a process has run, which a busy computer does not change."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def _watch(process: subprocess.Popen[bytes], out: Path, stop: Event) -> bool:
    """Wait for the end. Return False where nothing comes any more."""
    size, since_s = -1, 0.0
    while process.poll() is None:
        if stop.wait(0.02):
            raise StoppedError
        now = out.stat().st_size if out.exists() else -1
        if now != size:
            size, since_s = now, _cpu_seconds(process.pid)
        elif _cpu_seconds(process.pid) - since_s > PATIENCE_S:
            return False
    return True


def _emulate(image: Path, folder: Path, strikes: Sequence[Strike], stop: Event) -> list[Result]:
    """Return the results of the strikes up to the end, or to one after which nothing comes."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "flips.in").write_bytes(_pack(strikes))
    out = folder / "flips.out"
    out.unlink(missing_ok=True)
    # The kernel ends the emulator with the thread that started it, however that ends.
    command = ["setpriv", "--pdeathsig", "KILL", *EMULATOR, "-kernel", str(image)]
    if missing := [name for name in (command[0], EMULATOR[0]) if shutil.which(name) is None]:
        raise ImageError(f"{missing[0]} is missing: install util-linux and qemu-system-arm")
    with (folder / "flips.log").open("w+") as log:
        process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        try:
            said = "no answer" if not _watch(process, out, stop) else ""
        finally:
            process.kill()
            process.wait()
        log.seek(0)
        said = said or log.read()
    results = _parse(out.read_bytes()) if out.exists() else []
    if len(results) < CHECKPOINTS:
        raise ImageError(f"{image}: the cut was not cut: {said.strip()[-300:]}")
    return results


def _is_intact(results: Sequence[Result], first: int) -> bool:
    """Return whether results are in their order, and unstruck runs at their end as at first."""
    in_order = all(r.number == i for i, r in enumerate(results))
    return in_order and all(r.first == r.n_ticks for r in results[first:])


def _some_results(
    image: Path, folder: Path, strikes: Sequence[Strike], stop: Event
) -> list[Result]:
    """Return at least one result, up to a strike that ended the emulator: the next start tries it.

    What a strike has broken in the rig's own memory is seen by the unstruck runs behind them: then
    each half of the strikes gets an emulator of its own.
    """
    first = [Strike(c) for c in range(CHECKPOINTS)]
    again = [Strike(c, bit=1) for c in range(CHECKPOINTS)]
    told = _emulate(image, folder, [*first, *strikes, *again], stop)
    results = told[CHECKPOINTS : CHECKPOINTS + len(strikes)]
    if not results:  # a fresh emulator that ends at its first strike is a lock-up of the core
        return [replace(told[0], end=LOCKUP, ticks=told[0].ticks[:0], n_ticks=0, first=0)]
    if len(strikes) > 1 and not _is_intact(told, CHECKPOINTS + len(strikes)):
        return _some_results(image, folder, strikes[: len(strikes) // 2], stop)
    return results


def run_strikes(image: Path, folder: Path, strikes: Sequence[Strike], stop: Event) -> list[Result]:
    """Return the result of each strike."""
    results: list[Result] = []
    while len(results) < len(strikes):
        results += _some_results(image, folder, strikes[len(results) :], stop)
    return results


def golden_runs(image: Path, folder: Path) -> list[Result]:
    """Return the runs in which nothing was struck, after a proof that they repeat."""
    first = [Strike(c) for c in range(CHECKPOINTS)]
    again = [Strike(c, bit=1) for c in range(CHECKPOINTS)]
    told = _emulate(image, folder, [*first, *again], Event())
    if len(told) != 2 * CHECKPOINTS or not _is_intact(told, CHECKPOINTS):
        raise ImageError(f"{image}: two runs without a strike differ")
    return told[:CHECKPOINTS]
