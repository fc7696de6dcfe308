# SPDX-License-Identifier: Apache-2.0
"""One rig, three controllers: camturn, an expert's HAL component, LinuxCNC's eoffset_per_angle.

The rig is the simulator's spindle with its encoder, as the trace of a cut tells it, and a drive of
U that is integrated here. All controllers see the same counts in the same ticks; U is compared with
the exact ellipse at the true angle every 12.5 us, between the ticks, too. See
hal/linuxcnc/README.md.
"""

import csv
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.signal import lfilter, ss2tf

from camtools.base.quantities import Floats
from camtools.cli.mktables import main as mktables
from tests.tools.cases.camsim_cases import camsim

SPEEDS_RPM = (100, 300, 500, 1000, 2000, 2500, 3000)
RATES_HZ = (1000, 5000, 10000)
OVALITIES_MM = (0.3, 2.0)
LONG_MM = 50.0  # half of the long axis
STEP_S = 12.5e-6
COUNTS = 10000
OMEGA, DAMPING, DEAD_S = 2 * np.pi * 300.0, 0.7, 75e-6
FILTERS_S = (0.002, 0.005, 0.02)  # of the expert's speed; the best one of each cell counts
EOFFSET_CYCLES = 3  # from the angle to the set-point: component, planner, output
CUT_TURNS, SETTLED_TURNS = 40, 10
LEARNING = {
    "learn_harmonics": 16,
    "ripple_turns": 8,
    "rehearse_turns": 40,
    "following_limit_nm": 200000,
}
WITHOUT = {"learn_harmonics": 0, "ripple_turns": 0, "rehearse_turns": 0}

PART = """
[part]
name = "oval"
kind = "piston"
source = "An elliptic cylinder."
[piston.profile]
height_mm = [0, 30]
diameter_mm = [100.0, 100.0]
[piston.ovality]
height_mm = [0, 30]
ovality_mm = [{ovality}, {ovality}]
[piston.section]
shape = "ellipse"
[process]
spindle_rpm = 3000
feed_mm = 0.1
depth_mm = 0.1
direction = 1
form_error_um = 0.5
[machine.limits]
u_stroke_mm = 3
u_speed_mm_s = 800
u_acceleration_mm_s2 = 500000
spindle_rpm = 3000
"""
MACHINE = """
[machine]
tick_hz = {hz}
[u]
stroke_mm = 3
speed_mm_per_s = 800
acceleration_mm_per_s2 = 500000
[believed.u]
bandwidth_hz = {bandwidth}
damping = {damping}
delay_us = {delay}
"""


@dataclass(frozen=True)
class Belief:
    """What a controller is told of the drive."""

    bandwidth_hz: float
    damping: float
    delay_us: float

    @property
    def k1_s(self) -> float:
        """Return the velocity term of the inverse."""
        return 2 * self.damping / (2 * np.pi * self.bandwidth_hz)

    @property
    def k2_s2(self) -> float:
        """Return its acceleration term."""
        return 1 / (2 * np.pi * self.bandwidth_hz) ** 2


KNOWN = Belief(300.0, 0.7, 75.0)
WRONG = Belief(270.0, 0.77, 65.0)


@dataclass(frozen=True)
class Cell:
    """One place of the table."""

    hz: int
    ovality_mm: float
    rpm: int


@dataclass(frozen=True)
class Run:
    """What a cut of the simulator left: times, true angles, counts, U's set-points, what counts."""

    cell: Cell
    t_s: Floats
    theta: Floats
    counts: Floats
    u_nm: Floats
    is_judged: np.ndarray[tuple[int], np.dtype[np.bool_]]


def ellipse(theta: Floats, ovality_mm: float) -> tuple[Floats, Floats, Floats]:
    """Return the exact reduction and its two derivatives by the angle, in nm."""
    a, b = LONG_MM, LONG_MM - ovality_mm / 2
    q = (b * np.cos(theta)) ** 2 + (a * np.sin(theta)) ** 2
    first, second = (a * a - b * b) * np.sin(2 * theta), 2 * (a * a - b * b) * np.cos(2 * theta)
    u = a - a * b * q**-0.5
    u1 = a * b * q**-1.5 * first / 2
    u2 = a * b * (q**-1.5 * second / 2 - 0.75 * q**-2.5 * first**2)
    return u * 1e6, u1 * 1e6, u2 * 1e6


def observer_mhz(cell: Cell) -> int:
    """Return the bandwidth that the HAL component derives, MATHS.md (188)."""
    turns_per_s = cell.rpm / 60
    return min(int(turns_per_s * (8 + turns_per_s) * 1000), cell.hz * 80)


def cut(folder: Path, cell: Cell, belief: Belief, learning: dict[str, int]) -> Run:
    """Let the firmware cut on the simulated machine; return what it sensed and commanded."""
    machine, trace = folder / "machine.toml", folder / "trace.csv"
    machine.write_text(
        MACHINE.format(
            hz=cell.hz, bandwidth=belief.bandwidth_hz, damping=belief.damping, delay=belief.delay_us
        )
    )
    wanted = learning | {"observer_bandwidth_mHz": observer_mhz(cell), "feed_ramp_turns": 2}
    table = folder / f"{cell.ovality_mm}" / "oval.camtab"
    done = camsim(
        "run", table, "--machine", machine, "--rpm", str(cell.rpm), "--trace", trace,
        "--turns-limit", str(CUT_TURNS), "--tolerance-um", "10000",
        *(word for name, value in wanted.items() for word in ("--set", f"{name}={value}")),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return _read(trace, cell)


def _read(trace: Path, cell: Cell) -> Run:
    with trace.open() as lines:
        rows = csv.reader(lines)
        names = next(rows)
        at = [names.index(n) for n in ("t_s", "true_turn", "in_counts", "out_u_nm", "state")]
        kept = [[row[i] for i in at] for row in rows]
    numbers = np.array([row[:4] for row in kept], dtype=np.float64)
    is_cutting = np.array([row[4] == "cutting" for row in kept])
    first = int(np.argmax(is_cutting)) + round(SETTLED_TURNS * 60 * cell.hz / cell.rpm)
    is_judged = is_cutting & (np.arange(len(kept)) >= first)
    is_judged[-3:] = False
    t_s, turn, counts, u_nm = numbers.T
    moved = np.cumsum(np.r_[0.0, (np.diff(counts) + 2**31) % 2**32 - 2**31])
    counted = (np.floor(turn[0] * COUNTS) + 0.5 + moved) / COUNTS
    return Run(cell, t_s, 2 * np.pi * turn, 2 * np.pi * counted, u_nm, is_judged)


def expert(run: Run, belief: Belief, filter_s: float) -> Floats:
    """Return the set-points of twelve lines: filtered speed, lead, exact ellipse, feed-forward."""
    hz = run.cell.hz
    share = 1 - np.exp(-1 / (filter_s * hz))
    speed = np.r_[0.0, np.diff(run.counts)] * hz
    speed = lfilter([share], [1, share - 1], speed)
    lead_s = belief.delay_us * 1e-6 + 0.5 / hz
    u, u1, u2 = ellipse(run.counts + speed * lead_s, run.cell.ovality_mm)
    wanted: Floats = u + belief.k1_s * speed * u1 + belief.k2_s2 * speed**2 * u2
    return _rounded(wanted, 10)


def eoffset(run: Run) -> Floats:
    """Return LinuxCNC's set-points: a sinusoid in steps of 0.1 um, some periods late."""
    u = run.cell.ovality_mm / 4 * (1 - np.cos(2 * run.counts)) * 1e6
    stepped = _rounded(u, 100)
    return _later(stepped, EOFFSET_CYCLES)


def _rounded(value_nm: Floats, step_nm: float) -> Floats:
    return np.asarray(np.round(value_nm / step_nm) * step_nm, dtype=np.float64)


def _later(value: Floats, n: int) -> Floats:
    return np.concatenate([np.full(n, value[0]), value[:-n]])


def _drive(command_nm: Floats, hz: int) -> Floats:
    """Return U every 12.5 us: held set-points, dead time, second order; exact."""
    held = np.repeat(command_nm, round(1 / hz / STEP_S))
    late = _later(held, round(DEAD_S / STEP_S)) - held[0]
    a = np.zeros((3, 3))
    a[0, 1] = 1
    a[1] = [-(OMEGA**2), -2 * DAMPING * OMEGA, OMEGA**2]
    flow = expm(a * STEP_S)
    up, down = ss2tf(flow[:2, :2], flow[:2, 2:3], np.array([[1.0, 0.0]]), np.zeros((1, 1)))
    moved: Floats = np.asarray(lfilter(up[0], down, late), dtype=np.float64)
    moved += held[0]
    return moved


def errors_um(run: Run, command_nm: Floats) -> tuple[float, float]:
    """Return the largest error of U and its rms, over all instants that are judged."""
    n = round(1 / run.cell.hz / STEP_S)
    t_s = run.t_s[0] + np.arange(len(run.t_s) * n) * STEP_S
    theta = CubicSpline(run.t_s, run.theta)(np.minimum(t_s, run.t_s[-1]))
    due = ellipse(theta, run.cell.ovality_mm)[0]
    off = (_drive(command_nm, run.cell.hz) - due)[np.repeat(run.is_judged, n)] * 1e-3
    return float(np.abs(off).max()), float(np.sqrt(np.mean(off**2)))


def row(folder: Path, cell: Cell) -> list[tuple[float, float]]:
    """Return all columns of a cell."""
    known = cut(folder, cell, KNOWN, WITHOUT)
    wrong = cut(folder, cell, WRONG, WITHOUT)
    return [
        errors_um(known, eoffset(known)),
        min(errors_um(known, expert(known, KNOWN, f)) for f in FILTERS_S),
        errors_um(known, known.u_nm),
        _learned(folder, cell, KNOWN),
        min(errors_um(wrong, expert(wrong, WRONG, f)) for f in FILTERS_S),
        _learned(folder, cell, WRONG),
    ]


def _learned(folder: Path, cell: Cell, belief: Belief) -> tuple[float, float]:
    run = cut(folder, cell, belief, LEARNING)
    return errors_um(run, run.u_nm)


def main() -> int:
    """Print the table, a line as soon as it is known: largest error / rms, in um."""
    print("| G [mm] | tick [kHz] | r/min | eoffset_per_angle | expert | camturn | camturn, learning"
          " | expert, drive 10 % wrong | camturn, drive 10 % wrong, learning |")  # fmt: skip
    print("|---" * 9 + "|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for ovality_mm in OVALITIES_MM:
            part = folder / "oval.toml"
            part.write_text(PART.format(ovality=ovality_mm))
            assert mktables([str(part), "-o", str(folder / f"{ovality_mm}")]) == 0
            for hz in RATES_HZ:
                for rpm in SPEEDS_RPM:
                    columns = row(folder, Cell(hz, ovality_mm, rpm))
                    told = " | ".join(f"{most:.3g} / {rms:.2g}" for most, rms in columns)
                    print(f"| {ovality_mm:g} | {hz / 1000:g} | {rpm} | {told} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
