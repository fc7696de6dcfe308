# SPDX-License-Identifier: Apache-2.0
"""How long the preview of each part takes after a change, as a page of the panel sees it.

Each change is one that somebody makes at the part: the shape (a diameter, an ovality, a lift) or
the process (the speed). The time runs from the request to the curves and to the table with its
size and verdict, through the engine and its warm processes; the browser's part is not in it.
"""

import argparse
import asyncio
import re
import statistics
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from camtools.panel.design.part_library import EXAMPLES
from camtools.panel.design.preview_engine import Engine

_LIMIT_S = 0.3
_SHAPE = re.compile(
    r"^(diameter_mm|ovality_mm|lift_mm|disc_radius_mm|z_mm|peak_diameter_mm)( *= *\[?)([-\d.]+)",
    re.MULTILINE,
)
_SPEED = re.compile(r"^(spindle_rpm)( *= *)([\d.]+)", re.MULTILINE)


def changed(text: str, pattern: re.Pattern[str], number: int) -> str:
    """Return a text whose first match of a pattern has a number that is a little different."""

    def other(found: re.Match[str]) -> str:
        value = float(found[3])
        step = 1e-4 if value else -1e-3
        return f"{found[1]}{found[2]}{value + number * step:.6f}"

    return pattern.sub(other, text, count=1)


class Times(NamedTuple):
    """Of one change [s]: by the clock, and by the processor of the process that computes."""

    curves_s: float
    curves_cpu_s: float
    table_s: float
    table_cpu_s: float


async def timed(seat: "_Listener", text: str) -> Times:
    """Return the times until the first curves and until the table."""
    done = asyncio.Event()
    begin_s = time.perf_counter()
    times: dict[str, tuple[float, float]] = {}

    def take(answer: dict[str, Any]) -> None:
        now_s = time.perf_counter() - begin_s
        times.setdefault(str(answer["stage"]), (now_s, float(answer.get("cpu_s", now_s))))
        if answer["stage"] in ("done", "lost"):
            done.set()

    seat.on_answer = take
    seat.preview(text, str(EXAMPLES), None)
    await done.wait()
    never = float("nan"), float("nan")
    return Times(*times.get("curves", never), *times.get("table", never))


class _Listener:
    """A page whose answers go to whoever waits for them now."""

    def __init__(self, engine: Engine) -> None:
        self.on_answer: Callable[[dict[str, Any]], None] = lambda _: None
        self._seat = engine.seat(lambda answer: self.on_answer(answer))

    def preview(self, text: str, folder: str, height_mm: float | None) -> None:
        """Ask for a preview."""
        self._seat.preview(text, folder, height_mm)


def row(name: str, kind: str, times: list[Times]) -> str:
    """Return a line of the table: median and worst of each time."""
    cells = [
        f"{statistics.median(values):5.3f} {max(values):5.3f}"
        for values in zip(*times, strict=True)
    ]
    mark = "" if max(one.table_cpu_s for one in times) <= _LIMIT_S else "  long"
    return f"{name:28s} {kind:6s} " + "  ".join(cells) + mark


async def measured(names: list[str], n: int) -> None:
    """Print the times of some parts."""
    engine = Engine()
    seat = _Listener(engine)
    print("median and worst of the times after a change [s]; long: the table takes more than 0.3")
    heads = ("curves", "processor", "table", "processor")
    print(f"{'part':28s} {'change':6s} " + "  ".join(f"{one:11s}" for one in heads))
    try:
        for name in names:
            text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
            await timed(seat, text)
            for kind, pattern in (("shape", _SHAPE), ("speed", _SPEED)):
                times = [await timed(seat, changed(text, pattern, i)) for i in range(1, n + 1)]
                print(row(name, kind, times), flush=True)
    finally:
        await engine.close()


def main() -> None:
    """Measure the parts that are named, or all."""
    parser = argparse.ArgumentParser(prog="tests/bench/preview")
    parser.add_argument("-n", type=int, default=7, metavar="CHANGES", help="of each kind")
    parser.add_argument("parts", nargs="*", metavar="PART", help="names of tools/parts")
    options = parser.parse_args()
    names = options.parts or sorted(path.stem for path in EXAMPLES.glob("*.toml"))
    asyncio.run(measured(names, options.n))


if __name__ == "__main__":
    main()
