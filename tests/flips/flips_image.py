# SPDX-License-Identifier: Apache-2.0
"""Runs the image in the emulator: strikes go in by a file, what happened comes back by another."""

from __future__ import annotations

import shutil
import struct
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NOTHING, REGISTER, MEMORY, STACK = range(4)
RAN, EXCEPTION, WATCHDOG, HALT, LOCKUP = range(5)
CHECKPOINTS = 6
PERIOD = 20000  # counts of the ticker in a tick
MOST_STRIKES = 16000  # of one start of the emulator
PATIENCE_S = 20.0  # of real time without a result: the core is caught where no timer reaches it
EMULATOR = "qemu-system-arm -M mps2-an500 -icount shift=7 -nographic -monitor none -serial none"
SEMIHOSTING = ["-semihosting-config", "enable=on,target=native"]
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
        _, end, detail, pc, address, struck, n, idle, digest, _, first, told = HEAD.unpack_from(
            data, at
        )
        stop = at + HEAD.size + told * TICK.itemsize
        if stop > len(data):
            break
        ticks = np.frombuffer(data, TICK, told, at + HEAD.size)
        results.append(
            Result(end, detail, pc, address, bool(struck), n, idle, digest, first, ticks)
        )
        at = stop
    return results


def _emulate(image: Path, folder: Path) -> str:
    """Run to the end, or until nothing comes any more. Return what the emulator said."""
    emulator = shutil.which("qemu-system-arm")
    if emulator is None:
        raise ImageError("qemu-system-arm is missing: install the package qemu-system-arm")
    out = folder / "flips.out"
    out.unlink(missing_ok=True)
    command = [emulator, *EMULATOR.split()[1:], *SEMIHOSTING, "-kernel", str(image)]
    with (folder / "flips.log").open("w+") as log:
        process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        size, since = -1, time.monotonic()
        while process.poll() is None:
            time.sleep(0.02)
            now = out.stat().st_size if out.exists() else -1
            if now != size:
                size, since = now, time.monotonic()
            elif time.monotonic() - since > PATIENCE_S:
                process.kill()
                process.wait()
                return "no answer"
        log.seek(0)
        return log.read()


def run_strikes(image: Path, folder: Path, strikes: Sequence[Strike]) -> list[Result]:
    """Return the result of each strike. One that ends the emulator itself is a lock-up."""
    folder.mkdir(parents=True, exist_ok=True)
    golden = [Strike(c) for c in range(CHECKPOINTS)]
    results: list[Result] = []
    while len(results) < len(strikes):
        left = strikes[len(results) : len(results) + MOST_STRIKES]
        (folder / "flips.in").write_bytes(_pack([*golden, *left]))
        said = _emulate(image, folder)
        out = folder / "flips.out"
        parsed = _parse(out.read_bytes()) if out.exists() else []
        if len(parsed) < CHECKPOINTS:
            raise ImageError(f"{image}: the cut was not cut: {said.strip()[-300:]}")
        results += parsed[CHECKPOINTS:]
        if len(parsed) - CHECKPOINTS < len(left):
            nothing = parsed[0]
            results.append(replace(nothing, end=LOCKUP, ticks=nothing.ticks[:0], n_ticks=0))
    return results


def golden_runs(image: Path, folder: Path) -> list[Result]:
    """Return the runs in which nothing was struck, after a proof that they repeat."""
    folder.mkdir(parents=True, exist_ok=True)
    first = [Strike(c) for c in range(CHECKPOINTS)]
    again = [Strike(c, bit=1) for c in range(CHECKPOINTS)]
    (folder / "flips.in").write_bytes(_pack([*first, *again]))
    said = _emulate(image, folder)
    out = folder / "flips.out"
    parsed = _parse(out.read_bytes()) if out.exists() else []
    if len(parsed) != 2 * CHECKPOINTS:
        raise ImageError(f"{image}: the cut was not cut: {said.strip()[-300:]}")
    for a, b in zip(parsed[:CHECKPOINTS], parsed[CHECKPOINTS:], strict=True):
        if b.first != b.n_ticks or a.digest != b.digest:
            raise ImageError(f"{image}: two runs without a strike differ")
    return parsed[:CHECKPOINTS]
