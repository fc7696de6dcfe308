# SPDX-License-Identifier: Apache-2.0
"""Generator and controller judge alike: random tables, machines and speeds, to the last digit.

The controller's side is compiled firmware (tests/judge), with the parameters that the simulator
derives from the machine file of the part.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from camsim_cases import ROOT, camsim, columns_of
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cut.demand import Demand, JudgedCut, exceeded, highest_mrpm, largest_feed_nm
from camtools.cut.verdict import check_table, cut_of
from camtools.lobe.generate import generate_lobes
from camtools.lobe.machine import lobe_machine_text
from camtools.part.common import MachineLimits, SwingLimits
from camtools.sim.camsim import machine_text
from camtools.table.channel import (
    ANGLE_TURN,
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_WAY,
    KIND_X,
    RATIO_ONE,
    Bounds,
    Channel,
    ImageLimits,
)
from camtools.table.image import Table, pack
from camtools.table.modulation import moving_bounds, peaks_together
from camtools.table.quantise import quantise, with_bounds
from lobe_cases import cam

JUDGE = ROOT / os.environ.get("CAMTURN_BUILD", "build/host") / "tests" / "judge" / "judge"
CODES = {
    int(code): name
    for name, code in re.findall(
        r"X\((\w+), +(-\d+),", (ROOT / "firmware" / "base" / "cam_err.h").read_text()
    )
}
N_TABLES, N_MACHINES = 40, 6


class Verdict(NamedTuple):
    """What the controller says of a cut."""

    err: str
    needed: int
    limit: int
    highest_mrpm: int
    largest_feed_nm: int


def ours(cut: JudgedCut) -> Verdict:
    """Return the generator's verdict."""
    first = next(iter(exceeded(cut)), Demand("ok", 0, 0))
    return Verdict(first.name, first.needed, first.limit, highest_mrpm(cut), largest_feed_nm(cut))


def theirs(lines: list[str]) -> list[Verdict]:
    """Return the controller's verdicts on lines of image, machine and speed."""
    assert JUDGE.exists(), f"{JUDGE} is missing: build the preset host, or let tools/test do it"
    done = subprocess.run(
        [JUDGE], input="\n".join(lines), capture_output=True, text=True, check=True, timeout=60
    )
    rows = (tuple(map(int, line.split())) for line in done.stdout.splitlines())
    return [Verdict(CODES.get(row[0], "ok"), *row[1:]) for row in rows]


def waves(rng: np.random.Generator, size: float, n: int, phi: Floats, h: float) -> Floats:
    """Return a sum of n waves over the angle as (value, h f', h^2 f'' / 2)."""
    value, first, second = np.zeros((3, phi.size))
    for k in range(1, n + 1):
        a, b = rng.normal(size=2) * size / k**2
        value += a * np.cos(k * phi) + b * np.sin(k * phi)
        first += k * (b * np.cos(k * phi) - a * np.sin(k * phi))
        second -= k * k * (a * np.cos(k * phi) + b * np.sin(k * phi))
    return np.stack([value, h * first, h * h / 2 * second], axis=-1)


def surface(
    rng: np.random.Generator, kind: int, size: float, middle: float, span: tuple[int, int]
) -> Channel:
    """Return a channel over angle and height whose slices change smoothly, or hardly."""
    log2_knots, n_slices = int(rng.integers(4, 7)), int(rng.integers(2, 9))
    h = 2 * np.pi / (1 << log2_knots)
    phi = h * np.arange(1 << log2_knots, dtype=np.float64)
    ends = [waves(rng, size, int(rng.integers(1, 5)), phi, h) for _ in range(2)]
    share = rng.random() ** 4 * np.linspace(0, 1, n_slices)[:, None, None]
    slices = (1 - share) * ends[0] + share * ends[1]
    slices[..., 0] += middle
    return with_bounds(quantise(kind, slices, 0, span))


def profile(rng: np.random.Generator, span: tuple[int, int]) -> Channel:
    """Return a barrel of X."""
    n = int(rng.integers(2, 12))
    h = (span[1] - span[0]) / (n - 1)
    place = np.linspace(0, 1, n)
    bend = float(rng.normal()) * 10 ** float(rng.uniform(2, 6))
    height = span[1] - span[0]
    slope = 2 * bend * place / height
    rows = np.stack([46e6 + bend * place**2, slope * h, np.full(n, bend / height**2 * h * h)], -1)
    return with_bounds(quantise(KIND_X, rows[:, None], 0, span))


def way(rng: np.random.Generator, span: tuple[int, int]) -> Channel:
    """Return a feed that changes with the height: Z ahead of a plain helix, 0 at both ends."""
    n, height = int(rng.integers(8, 14)), span[1] - span[0]
    place, wave = np.linspace(0, 1, n), 2 * np.pi / height
    most = float(rng.uniform(0.01, 0.3)) / wave
    phase, h = 2 * np.pi * place, height / (n - 1)
    value = most * (1 - np.cos(phase))
    first, second = most * wave * np.sin(phase) * h, most * wave**2 * np.cos(phase) * h * h / 2
    knots = np.stack([value, first, second], -1)
    knots[[0, -1], 0] = 0.0
    return with_bounds(quantise(KIND_WAY, knots[:, None], 0, span))


def random_table(seed: int) -> Table:
    """Return a table that is one in form; nobody would cut most of them."""
    rng = np.random.default_rng(seed)
    span = (0, int(rng.integers(1_000_000, 16_000_000)))
    kind = (None, KIND_SWING, KIND_CONTACT)[seed % 3]
    u = surface(rng, KIND_U, 10 ** float(rng.uniform(4, 6.3)), 0.0, span)
    channels = [u, profile(rng, span)]
    if kind is not None:
        channels.append(surface(rng, kind, ANGLE_TURN * float(rng.uniform(0.001, 0.02)), 0.0, span))
    low, high = u.value_offset + (u.p_min >> u.frac_bits), u.value_offset + (u.p_max >> u.frac_bits)
    uniform = Bounds(int(low) - 1, int(high) + 2, *_uniform_peaks(u), 0)
    bounds = uniform
    is_modulated = seed % 5 in (1, 2)
    if is_modulated:
        speed = surface(rng, KIND_SPEED, 0.1 * RATIO_ONE, RATIO_ONE, span)
        channels.append(speed)
        bounds = moving_bounds(uniform, peaks_together(u, speed))
    is_ring_helix = not is_modulated and seed % 7 == 0
    if seed % 4 == 3 and kind is None and not is_ring_helix:
        channels.append(way(rng, span))
    limits = ImageLimits(*(int(10 ** rng.uniform(a, b)) for a, b in _LIMITS))
    return Table(
        *(f"random{seed}", *span, int(rng.choice([1, -1]))),
        int(10 ** rng.uniform(4, 6.5)),
        int(10 ** rng.uniform(3, 5.9)),
        *(100_000, limits, bounds, tuple(channels)),
        is_ring_helix=is_ring_helix,
    )


_LIMITS = ((6.5, 7.4), (4, 7), (3, 6.9), (5, 7))  # decades of the header's limits


def _uniform_peaks(u: Channel) -> tuple[int, int]:
    per_rad = (1 << u.log2_knots) / (2 * np.pi)
    first = 1.6 * u.v_max * u.lsb * per_rad + 2
    second = 2 * 1.6 * u.a_max * u.lsb * per_rad**2 + 2
    return int(first), int(second)


def random_limits(seed: int, *, is_lobe: bool) -> MachineLimits:
    """Return a machine of any strength."""
    rng = np.random.default_rng(1000 + seed)

    def decades(low: float, high: float) -> float:
        return float(10 ** rng.uniform(low, high))

    common = {
        "u_stroke_mm": min(30.0, decades(-0.5, 1.6)),
        "u_speed_mm_s": decades(0.5, 3.5),
        "u_acceleration_mm_s2": decades(2.5, 6.5),
        "z_speed_mm_s": decades(0, 2.5),
        "z_acceleration_mm_s2": decades(1.2, 4),
        "spindle_rpm": decades(2, 4),
        "tick_hz": int(decades(3, 4.9)),
        "spindle_acceleration_rad_s2": decades(1, 5),
        "spindle_bandwidth_rad_s": decades(0.5, 3),
    }
    if not is_lobe:
        return MachineLimits.model_validate(common)
    swing = {
        "swing_deg": float(rng.uniform(1, 80)),
        "swing_speed_deg_s": decades(1, 4),
        "swing_acceleration_deg_s2": decades(3, 7),
    }
    return SwingLimits.model_validate(common | swing)


def test_generator_and_controller_judge_alike(tmp_path: Path) -> None:
    """At the table's speed, and at and just beyond the highest one: verdict and all numbers."""
    lines, expected = [], []
    for seed in range(N_TABLES):
        table = random_table(seed)
        image = tmp_path / f"{seed}.camtab"
        image.write_bytes(pack(table))
        is_lobe = table.angle is not None
        for k in range(N_MACHINES):
            limits = random_limits(N_MACHINES * seed + k, is_lobe=is_lobe)
            text = lobe_machine_text(limits) if isinstance(limits, SwingLimits) else None
            machine = tmp_path / f"{seed}-{k}.toml"
            machine.write_text(text or machine_text(limits))
            cut = cut_of(table, limits)
            highest = highest_mrpm(cut)
            for mrpm in (table.spindle_mrpm, max(highest, 1), highest + 1):
                lines.append(f"{image} {machine} {mrpm}")
                expected.append(ours(cut._replace(mean_mrpm=mrpm)))
    found = theirs(lines)
    assert len(found) == len(expected) == 3 * N_TABLES * N_MACHINES
    for line, told, wanted in zip(lines, found, expected, strict=True):
        assert told == wanted, line
    said = Counter(one.err for one in found)
    assert said["ok"] > 50
    assert {"u_stroke", "u_speed", "u_acceleration", "z_speed", "spindle_speed"} <= set(said)
    assert {"swing_range", "swing_acceleration", "spindle_loop", "spindle_set_point"} <= set(said)


def test_stations_are_judged_alike(tmp_path: Path) -> None:
    """A plunge cut on machines of any strength: Z moves by the way, X by the turns."""
    text = (ROOT / "tools" / "parts" / "camshaft-plunge.toml").read_text()
    most = ImageLimits(1 << 25, (1 << 31) - 1, (1 << 31) - 1, 60_000_000)
    table = replace(generate_lobes(cam(text)).table, limits=most)
    image, lines, expected = tmp_path / "p.camtab", [], []
    image.write_bytes(pack(table))
    for seed in range(20):
        limits = random_limits(seed, is_lobe=True)
        if seed % 2 == 0:  # X or Z decide
            fast = {"u_stroke_mm": 30, "u_speed_mm_s": 1e5, "u_acceleration_mm_s2": 1e9}
            limits = limits.model_copy(update=fast | {"spindle_rpm": 6000, "tick_hz": 100_000})
        assert isinstance(limits, SwingLimits)
        machine = tmp_path / f"{seed}.toml"
        machine.write_text(lobe_machine_text(limits))
        cut = cut_of(table, limits)
        highest = highest_mrpm(cut)
        for mrpm in (table.spindle_mrpm, max(highest, 1), highest + 1):
            lines.append(f"{image} {machine} {mrpm}")
            expected.append(ours(cut._replace(mean_mrpm=mrpm)))
    found = theirs(lines)
    for line, told, wanted in zip(lines, found, expected, strict=True):
        assert told == wanted, line
    assert {"ok", "z_acceleration"} <= {one.err for one in found}


@pytest.mark.parametrize("is_ring_helix", [False, True])
def test_a_feed_too_small_is_refused_alike(tmp_path: Path, *, is_ring_helix: bool) -> None:
    """More turns than the controller counts, at the edge of it; the feed is what helps."""
    made = replace(random_table(0), is_ring_helix=is_ring_helix)
    limits = MachineLimits(u_stroke_mm=30)
    span_nm, per_feed = made.z_last_nm - made.z_first_nm, 1 + is_ring_helix
    least_nm = -(-span_nm * per_feed // ((1 << 22) - 2 - per_feed))
    lines, expected = [], []
    machine = tmp_path / "machine.toml"
    machine.write_text(machine_text(limits))
    for feed_nm in (1, least_nm - 1, least_nm + 1):
        table = replace(made, feed_nm=feed_nm, spindle_mrpm=1000)
        image = tmp_path / f"{feed_nm}.camtab"
        image.write_bytes(pack(table))
        lines.append(f"{image} {machine} 1000")
        expected.append(ours(cut_of(table, limits)))
    assert theirs(lines) == expected
    assert [one.err for one in expected] == ["turns", "turns", "ok"]


DISC = (ROOT / "tools" / "parts" / "cam-disc.toml").read_text()


@pytest.mark.parametrize("offset_mm", [7.3, 7.4, 7.49, 7.6])
def test_disc_that_fits_its_stroke_is_taken_by_both(offset_mm: float, tmp_path: Path) -> None:
    """A stroke of 30 mm has 15 to either side of the base circle: lifts up to 15 fit."""
    text = re.sub(r"offset_mm = [\d.]+", f"offset_mm = {offset_mm}", DISC)
    text = re.sub(r"base_radius_mm = [\d.]+", f"base_radius_mm = {25 - offset_mm:.12g}", text)
    text = re.sub(r"u_stroke_mm = [\d.]+", "u_stroke_mm = 30", text)
    limits = cam(text).machine.limits
    machine = tmp_path / "machine.toml"
    assert isinstance(limits, SwingLimits)
    machine.write_text(lobe_machine_text(limits))
    if offset_mm > 7.5:
        with pytest.raises(CamtoolsError, match=r"u_stroke_mm = 30 mm: the part needs 30\.[4-6]"):
            generate_lobes(cam(text))
        return
    table = generate_lobes(cam(text)).table
    image = tmp_path / "disc.camtab"
    image.write_bytes(pack(table))
    [told] = theirs([f"{image} {machine} {table.spindle_mrpm}"])
    assert told == ours(cut_of(table, limits))
    assert told.err == "ok"


def test_refusal_tells_the_numbers_of_the_controller() -> None:
    """In the units of the part file."""
    made = random_table(3)
    table = replace(made, spindle_mrpm=3_000_000)
    weak = MachineLimits(u_acceleration_mm_s2=100.0, u_stroke_mm=30)
    cut = cut_of(table, weak)
    [demand] = [one for one in exceeded(cut) if one.name == "u_acceleration"]
    with pytest.raises(CamtoolsError) as info:
        check_table(table, weak)
    assert any(
        line.startswith("machine.limits.u_acceleration_mm_s2 = 100 mm/s2: the part needs ")
        and f"{demand.needed:.9g} mm/s2" in line
        for line in info.value.lines
    )


@pytest.mark.slow
def test_limit_is_kept_and_reached_at_the_highest_speed(tmp_path: Path) -> None:
    """The set-points of a disc at the speed that both call highest, engaging included."""
    text = re.sub(r"u_acceleration_mm_s2 = \d+", "u_acceleration_mm_s2 = 1000", DISC)
    limits, table = cam(text).machine.limits, generate_lobes(cam(text)).table
    assert isinstance(limits, SwingLimits)
    image, machine, trace = tmp_path / "disc.camtab", tmp_path / "m.toml", tmp_path / "trace.csv"
    image.write_bytes(pack(table))
    quiet = limits.model_copy(update={"spindle_ripple": 0.0})
    machine.write_text(lobe_machine_text(quiet))
    mrpm = highest_mrpm(cut_of(table, limits))
    assert exceeded(cut_of(table, limits)._replace(mean_mrpm=mrpm + 1))[0].name == "u_acceleration"
    words = ("--rpm", f"{mrpm / 1000}", "--turns-limit", "4", "--trace", trace)
    done = camsim("run", image, "--machine", machine, *words)
    assert done.returncode in (0, 1), done.stderr
    columns = columns_of(trace)
    every, tick_s = 20, 1 / limits.tick_hz
    is_moving = np.isin(columns["state"].astype(str), ("engaging", "cutting", "disengaging"))
    motion = np.diff(columns["u_due_q6"][is_moving][::every] / 64e6, 2) / (every * tick_s) ** 2
    assert 970 < np.abs(motion).max() <= 1000
