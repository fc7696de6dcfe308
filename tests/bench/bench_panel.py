# SPDX-License-Identifier: Apache-2.0
"""The panel beside a live lathe that cuts, in Chromium: update rate, latency, processor, memory.

The page's chart of the following error over the angle is what is looked at. Each update is told by
the page itself, with the newest sample in it; a link of the benchmark's own hears the same samples
on the bus, so the time from there to the page is known for each of them.

>>> gaps_ms([10.0, 10.1, 10.35])
(100, 250)
"""

import argparse
import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import CDPSession

from camtools.base.command import Parser
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.link.refusal_text import ask_done
from tests.browser.panel_session import PanelSession, panel_session
from tests.browser.windows import DESK, Window, chromium

MOST_GROWTH_MB = 50.0
MINUTE_S = 60.0
CHART = "error-unrolled"
MB = 1e6
# Notes when the chart is given an option and when it has drawn it, each with the last point of the
# newest series; a chart is that of NiceGUI's element, whose number is in its id.
WATCH = """(name) => {
  const element = document.querySelector(`[data-testid=${name}]`);
  const chart = getElement(Number(element.id.slice(1))).chart;
  const now = () => performance.timeOrigin + performance.now();
  const setOption = chart.setOption.bind(chart);
  window.told = []; window.drawn = [];
  let newest = null;
  chart.setOption = (option, ...more) => {
    const series = (option.series || []).filter((one) => one.data && one.id.startsWith("turns-"));
    const last = series.map((one) => [one.itemStyle.opacity, one.data.at(-1)]);
    newest = last.sort((a, b) => b[0] - a[0])[0]?.[1] ?? null;
    window.told.push([now(), newest]);
    setOption(option, ...more);
  };
  chart.on("rendered", () => { window.drawn.push([now(), newest]); newest = null; });
}"""
TAKE = "() => window.told ? [window.told.splice(0), window.drawn.splice(0)] : null"

Update = tuple[float, list[float] | None]


def gaps_ms(times_s: Sequence[float]) -> tuple[int, int]:
    """Return the median and the longest distance of neighbouring times [ms]."""
    gaps = np.diff(times_s) * 1e3
    return round(float(np.median(gaps))), round(float(np.max(gaps)))


@dataclass
class Witness:
    """Hears the samples on the bus, in a thread of its own, and keeps the lathe cutting.

    Attributes
    ----------
    heard_s : dict
        when samples came, by the clock of the day, by what the page shows of them: angle in tenths
        of a degree, error in nm
    """

    link: Link
    heard_s: dict[tuple[int, int], list[float]] = field(default_factory=dict)
    parts: int = 0
    problem: str = ""

    def take(self, data: bytes) -> None:
        """Note a sample."""
        angle_turn = int.from_bytes(data[1:3], "little") / 65536
        error_nm = int.from_bytes(data[4:7], "little", signed=True)
        tenths = round(float(np.round(angle_turn * 360.0, 1)) * 10)
        self.heard_s.setdefault((tenths, error_nm), []).append(time.time())

    def run(self, is_over: threading.Event) -> None:
        """Listen, and start the next part where one has ended."""
        try:
            while not is_over.is_set():
                self.link.pump(0.1)
                if self.link.status.state == "ready":
                    ask_done(self.link, "start")
                    self.parts += 1
                    self.link.wait(lambda: self.link.status.state != "ready", 2.0)
        except Refused as error:
            self.problem = str(error)


@contextmanager
def witnessed(link: Link) -> Iterator[Witness]:
    """Let a witness listen meanwhile."""
    witness, is_over = Witness(link), threading.Event()
    link.on_strobe = witness.take
    thread = threading.Thread(target=witness.run, args=(is_over,), daemon=True)
    thread.start()
    try:
        yield witness
    finally:
        is_over.set()
        thread.join()
    if witness.problem:
        raise SystemExit(f"bench_panel: {witness.problem}")


# Processes


def children() -> dict[int, list[int]]:
    """Return the children of every process of this computer."""
    found: dict[int, list[int]] = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = path.read_text("utf-8")
        except OSError:
            continue
        found.setdefault(int(text.rpartition(")")[2].split()[1]), []).append(int(path.parent.name))
    return found


def family(pid: int) -> list[int]:
    """Return a process and all that descend from it."""
    below, found = children(), [pid]
    for one in found:
        found += below.get(one, [])
    return found


def browser_pids() -> list[int]:
    """Return the processes of the browser that this program has started."""
    mine = family(os.getpid())
    return [pid for pid in mine if "chrom" in comm(pid)]


def comm(pid: int) -> str:
    """Return the name of a process, "" when it has ended."""
    try:
        return Path(f"/proc/{pid}/comm").read_text("utf-8")
    except OSError:
        return ""


def processor_s(pids: Sequence[int]) -> float:
    """Return the processor time of processes [s]."""
    ticks = 0
    for pid in pids:
        try:
            words = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
        except OSError:
            continue
        ticks += int(words[11]) + int(words[12])
    return ticks / 100.0


def resident_mb(pids: Sequence[int]) -> float:
    """Return the resident memory of processes [MB]; what they share counts in each."""
    total = 0.0
    for pid in pids:
        try:
            pages = int(Path(f"/proc/{pid}/statm").read_text("utf-8").split()[1])
        except OSError:
            continue
        total += pages * 4096 / MB
    return total


# What is measured


def watch(window: Window) -> None:
    """Begin to note the updates of the chart, in a page that is new."""
    window.page.wait_for_selector(f"[data-testid={CHART}] canvas")
    window.page.evaluate(WATCH, CHART)


def take(window: Window) -> list[list[Update]]:
    """Return the updates since the last call, told and drawn; a page that was loaded anew says so.

    A panel or a browser that had no processor for some seconds lets the page be loaded anew.
    """
    noted: list[list[Update]] | None = window.page.evaluate(TAKE)
    if noted is None:
        why = [line for line in window.console if "reloading" in line]
        print(f"the page was loaded anew; it said {why[-1:]}", flush=True)
        watch(window)
        return [[], []]
    return noted


def rates(window: Window, witness: Witness, seconds: float) -> None:
    """Print how often the chart is updated, and how old its newest sample is."""
    take(window)
    witness.heard_s.clear()
    begin = time.monotonic()
    window.page.wait_for_timeout(seconds * 1e3)
    told, drawn = take(window)
    took_s = time.monotonic() - begin
    for name, updates in (("told to the chart", told), ("drawn", drawn)):
        at_s = [update[0] / 1e3 for update in updates]
        median, worst = gaps_ms(at_s)
        rate_hz = len(at_s) / took_s
        ages = ages_ms(updates, witness.heard_s)
        age = f"{np.median(ages):.0f} ms, worst {np.max(ages):.0f} ms" if len(ages) else "unknown"
        print(
            f"{name}: {rate_hz:.1f} /s, gaps: median {median} ms, worst {worst} ms; age of the "
            f"newest sample: median {age} ({len(ages)} of {len(updates)})",
            flush=True,
        )


def ages_ms(updates: Sequence[Update], heard_s: dict[tuple[int, int], list[float]]) -> list[float]:
    """Return how long ago the newest samples of updates were on the bus [ms].

    >>> ages_ms([(5000.0, [90.0, 0.5]), (5080.0, None)], {(900, 500): [1.0, 4.9, 5.1]})
    [100.0]
    """
    found = []
    for at_ms, point in updates:
        if point is None:
            continue
        key = (round(point[0] * 10), round(point[1] * 1000))
        before = [at_s * 1e3 for at_s in heard_s.get(key, []) if at_s * 1e3 <= at_ms]
        found += [at_ms - before[-1]] if before else []
    return found


def loads(session: PanelSession, seconds: float, window: Window) -> None:
    """Print how much processor time panel, browser and lathe take."""
    groups = {
        "panel": family(session.panel.process.pid),
        "browser": browser_pids(),
        "lathe, controller and their bus": family(session.lathe.process.pid),
    }
    before = {name: processor_s(pids) for name, pids in groups.items()}
    begin = time.monotonic()
    window.page.wait_for_timeout(seconds * 1e3)
    took_s = time.monotonic() - begin
    told = [
        f"{name} {100 * (processor_s(pids) - before[name]) / took_s:.0f} %"
        for name, pids in groups.items()
    ]
    print(f"processor, of one core: {', '.join(told)}", flush=True)


def js_heap_mb(cdp: CDPSession) -> float:
    """Return the page's JavaScript heap after a collection of garbage [MB]."""
    for _ in range(2):
        cdp.send("HeapProfiler.collectGarbage")
    metrics: dict[str, Any] = cdp.send("Performance.getMetrics")
    by_name = {one["name"]: one["value"] for one in metrics["metrics"]}
    return float(by_name["JSHeapUsedSize"]) / MB


def memory(session: PanelSession, window: Window, witness: Witness, minutes: float) -> bool:
    """Print the memory at the start and each minute; return whether it stays within its bound."""
    cdp = window.page.context.new_cdp_session(window.page)
    cdp.send("Performance.enable")
    panel = [session.panel.process.pid]
    first = last = (resident_mb(panel), js_heap_mb(cdp))
    updates: list[Update] = []
    print("minute  panel RSS MB  page JS heap MB  browser RSS MB  parts  drawn /s")
    for minute in range(round(minutes) + 1):
        if minute:
            window.page.wait_for_timeout(MINUTE_S * 1e3)
            updates = take(window)[1]
            witness.heard_s.clear()
            last = (resident_mb(panel), js_heap_mb(cdp))
        browser = resident_mb(browser_pids())
        print(
            f"{minute:6d} {last[0]:13.1f} {last[1]:16.1f} {browser:15.1f} {witness.parts:6d}"
            f" {len(updates) / MINUTE_S:9.1f}",
            flush=True,
        )
    growth = [now - then for now, then in zip(last, first, strict=True)]
    print(f"growth: panel {growth[0]:+.1f} MB, page {growth[1]:+.1f} MB; at most {MOST_GROWTH_MB}")
    return max(growth) < MOST_GROWTH_MB


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(prog="tests/bench/panel", allow_abbrev=False)
    parser.add_argument("--seconds", type=float, default=20.0, help="of rate and processor time")
    parser.add_argument("--minutes", type=float, default=0.0, help="of memory")
    parser.add_argument("--machine", default="real", help="of the live lathe")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Run the benchmark; return 1 where the memory grows beyond its bound."""
    given = _arguments(words)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # lathe and panel must not outlive it
    with (
        tempfile.TemporaryDirectory(prefix="camturn-bench.") as folder,
        panel_session(Path(folder), ["--machine", given.machine]) as session,
        chromium() as browser,
        browser.window(viewport=DESK) as window,
    ):
        ask_done(session.witness, "home")
        session.wait_for_state("ready")
        window.page.goto(session.url)
        watch(window)
        with witnessed(session.witness) as witness:
            window.page.wait_for_timeout(5e3)
            print(f"Chromium {browser.version}, machine {given.machine}", flush=True)
            rates(window, witness, given.seconds)
            loads(session, given.seconds, window)
            is_good = given.minutes <= 0 or memory(session, window, witness, given.minutes)
        for problem in window.problems()[:20]:
            print(f"page: {problem}")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
