# SPDX-License-Identifier: Apache-2.0
"""The generator refuses by the controller's rule: what it accepts is cut within all limits.

Parts are cut on machines of drawn strength at the highest speed that is accepted. The peaks of the
axes in the trace stay within the limits there, and those that the rule names first are reached. A
little more speed is refused by generator and controller for the same limit.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cut.verdict import RefusedError, check_table, judge_of, parameters_of
from camtools.judge.binding import PROTOTYPES, Judge, library_path
from camtools.lobe.generate import generate_lobes
from camtools.lobe.lobe_machine import lobe_machine_text
from camtools.part.common import MachineLimits, SwingLimits
from camtools.pipeline.load import parse
from camtools.sim.camsim import machine_text
from camtools.table.header import image_limits
from camtools.table.image import Table, pack, unpack
from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of
from tests.tools.cases.lobe_cases import cam
from tests.tools.cases.prototypes import declared_in, named

HEADER = ROOT / "host_sim" / "api" / "judge" / "judge_api.h"
SKIRT = {"u_speed_mm_s": 80.0, "u_acceleration_mm_s2": 4e4, "z_speed_mm_s": 50.0}
# What is changed of the machine of the part file, the feed, and the words of a shorter cut.
SHORT = ("--turns-limit", "1")
PARTS: dict[str, tuple[dict[str, float], float | None, tuple[str, ...]]] = {
    "perkins240": (SKIRT, 1.0, ()),
    "perkins240_ring_helix": (SKIRT, None, ()),
    "cam-disc": ({}, None, SHORT),
    "camshaft8": ({"swing_speed_deg_s": 300.0}, None, SHORT),
    "camshaft-plunge": ({}, None, SHORT),
}
DRAWN = (
    *("u_speed_mm_s", "u_acceleration_mm_s2", "z_speed_mm_s", "z_acceleration_mm_s2"),
    *("spindle_rpm", "swing_speed_deg_s", "swing_acceleration_deg_s2"),
)
N_MACHINES = 3
EVERY, XZ_ROWS = 16, 10  # ticks of a row of the trace, rows of a step: the noise is small in it
NOISE, REACHED = 0.01, 0.95  # of a limit: the angle is known to a count
FIELDS = {
    "u_speed": "u_speed_mm_s",
    "u_acceleration": "u_acceleration_mm_s2",
    "z_speed": "z_speed_mm_s",
    "z_acceleration": "z_acceleration_mm_s2",
    "spindle_speed": "spindle_rpm",
    "spindle_set_point": "spindle_rpm",
    "swing_speed": "swing_speed_deg_s",
    "swing_acceleration": "swing_acceleration_deg_s2",
}
TEXTS = dict(
    re.findall(
        r'X\((\w+), +-\d+, "([^"]+)"', (ROOT / "firmware" / "base" / "cam_err.h").read_text()
    )
)
DISC = (ROOT / "tools" / "parts" / "cam-disc.toml").read_text()


def limits_of(part: str) -> MachineLimits:
    """Return the machine of a part file, without ripple of its spindle."""
    data = (ROOT / "tools" / "parts" / f"{part}.toml").read_bytes()
    limits: MachineLimits = parse(data, part).part.machine.limits
    return limits.model_copy(update={"spindle_ripple": 0.0} | PARTS[part][0])


def drawn(limits: MachineLimits, seed: int) -> MachineLimits:
    """Return a weaker machine."""
    rng = np.random.default_rng(seed)
    update = {
        name: getattr(limits, name) * 10 ** rng.uniform(-0.8, 0)
        for name in DRAWN
        if name in type(limits).model_fields
    }
    return limits.model_copy(update=update)


def text_of(limits: MachineLimits) -> str:
    """Return the machine file of limits."""
    if isinstance(limits, SwingLimits):
        return lobe_machine_text(limits)
    return machine_text(limits)


def peaks_in(trace: Path, tick_hz: int) -> dict[str, float]:
    """Return the largest motions in a trace, by the names and in the units of the limits."""
    columns = columns_of(trace)
    in_cut = np.isin(columns["state"].astype(str), ("engaging", "cutting"))
    assert (np.diff(columns["tick"]) == EVERY).all()

    def derivative(column: str, order: int, rows: int = 1) -> float:
        place = columns[column][in_cut][::rows].astype(np.float64)
        return float(np.abs(np.diff(place, order)).max()) * (tick_hz / EVERY / rows) ** order

    found = {
        "u_stroke": float(np.abs(columns["u_set_nm"][in_cut]).max()),
        "u_speed": derivative("u_due_q6", 1) / 64e3,
        "u_acceleration": derivative("u_due_q6", 2) / 64e6,
        "spindle_speed": float(np.abs(columns["speed_q32"][in_cut]).max()) * tick_hz * 6e4 / 2**32,
        "spindle_set_point": float(np.abs(columns["out_spindle_mrpm"]).max()),
    }
    if "swing_set_deg" in columns:
        found["swing_speed"] = derivative("swing_set_deg", 1) * 1e3
        found["swing_acceleration"] = derivative("swing_set_deg", 2)
    for axis in "xz":  # both follow the angle in whole nanometres
        found[f"{axis}_speed"] = derivative(f"out_{axis}_nm", 1, XZ_ROWS) / 1e3
        found[f"{axis}_acceleration"] = derivative(f"out_{axis}_nm", 2, XZ_ROWS) / 1e6
    return found


def cut(
    folder: Path, table: Table, limits: MachineLimits, mrpm: int, *short: str
) -> tuple[str, Path]:
    """Cut at a speed; return what the simulator prints and where the trace is."""
    image, machine, trace = folder / "t.camtab", folder / "m.toml", folder / "t.csv"
    image.write_bytes(pack(table))
    machine.write_text(text_of(limits))
    words = ("--rpm", f"{mrpm / 1000:.3f}", *short)
    traced = ("--trace", trace, "--trace-every", str(EVERY))
    done = camsim("run", image, "--machine", machine, *words, *traced)
    return done.stderr, trace


@pytest.mark.parametrize("part", PARTS)
def test_what_is_accepted_is_cut_within_all_limits(
    part: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """At the highest speed; just above it generator and controller refuse for the same limit."""
    made, base = unpack(table_of(part).read_bytes()), limits_of(part)
    _, feed_mm, short = PARTS[part]
    feed_nm = round(feed_mm * 1e6) if feed_mm else made.feed_nm
    for seed in range(N_MACHINES):
        limits = drawn(base, seed)
        table = replace(made, limits=image_limits(limits), feed_nm=feed_nm)
        judge = judge_of(table, limits)
        highest = judge.highest_mrpm()
        beyond = replace(table, spindle_mrpm=highest + 1)
        text, trace = cut(tmp_path, table, limits, highest, *short)
        assert not re.search(r"infeasible|: fault", text), (seed, text)
        limit_of = {one.name: one.limit for one in judge.demands(highest)}
        shares = {
            name: peak / limit_of[name] for name, peak in peaks_in(trace, limits.tick_hz).items()
        }
        assert max(shares.values()) <= 1 + NOISE, (seed, shares)
        decides = judge.exceeded(highest + 1)[0].name
        assert shares[decides] > REACHED, (seed, decides, shares)
        text, _ = cut(tmp_path, beyond, limits, highest + 1)
        assert TEXTS[decides] in text
        with pytest.raises(RefusedError) as info:
            check_table(beyond, limits)
        assert any(
            line.startswith(f"machine.limits.{FIELDS[decides]} = ") for line in info.value.lines
        )


@pytest.mark.parametrize(("bandwidth_hz", "stroke_mm"), [(120, 0.33)])
def test_command_that_is_accepted_keeps_the_stroke(
    bandwidth_hz: float, stroke_mm: float, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The feed-forward takes U's command ahead of a set-point that fits the stroke."""
    limits = MachineLimits(u_stroke_mm=stroke_mm, u_speed_mm_s=1000, spindle_ripple=0.0)
    table = replace(unpack(table_of("perkins240").read_bytes()), feed_nm=1_000_000)
    table = replace(table, limits=image_limits(limits))
    machine, trace = tmp_path / "m.toml", tmp_path / "t.csv"
    text = machine_text(limits).replace("[u]", f"[u]\nbandwidth_hz = {bandwidth_hz}")
    machine.write_text(text)
    (tmp_path / "t.camtab").write_bytes(pack(table))
    omega = 2 * np.pi * bandwidth_hz
    gains = {"k1_ns": 1.4 / omega * 1e9, "k2_us2": 1e12 / omega**2}
    judge = Judge(pack(table), limits.tick_hz, parameters_of(limits) | gains)
    highest = judge.highest_mrpm()
    assert [one.name for one in judge.exceeded(highest + 1)] == ["u_command"]
    words = ("run", tmp_path / "t.camtab", "--machine", machine, "--trace", trace, "--rpm")
    done = camsim(*words, f"{(highest + 1) / 1000:.3f}")
    assert TEXTS["u_command"] in done.stderr
    done = camsim(*words, f"{highest / 1000:.3f}")
    assert not re.search(r"infeasible|: fault", done.stderr)
    columns = columns_of(trace)
    in_cut = columns["state"].astype(str) == "cutting"
    [limit] = [one.limit for one in judge.demands(highest) if one.name == "u_command"]
    assert 0.98 * limit < np.abs(columns["out_u_nm"][in_cut]).max() <= limit


@pytest.mark.parametrize("part", ["perkins240", "camshaft8"])
def test_parameters_are_those_of_the_simulated_machine(
    part: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The generator judges by what the simulator derives from the machine file of the part."""
    limits, machine = limits_of(part), tmp_path / "m.toml"
    machine.write_text(text_of(limits))
    done = camsim("params", table_of(part), "--machine", machine)
    assert done.returncode == 0, done.stderr
    told = dict(line.split(",") for line in done.stdout.splitlines())
    judged = parameters_of(limits)
    if not isinstance(limits, SwingLimits):
        judged.pop("swing_speed_mdeg_per_s")  # only lobes have a machine with a swing
    assert {name: int(told[name]) for name in judged} == {
        name: int(value + 0.5) for name, value in judged.items()
    }
    assert int(told["tick_hz"]) == limits.tick_hz


def test_prototypes_are_those_of_the_header() -> None:
    """Arguments and results of the library as ctypes is told, and the names of the limits."""
    words = {
        "const judge_api_demand_t *": "LP__Demand",
        "const judge_api_peaks_t *": "LP_TablePeaks",
    }
    assert declared_in(HEADER, words) == named(PROTOTYPES)


def test_library_that_is_missing_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The line names the file and who builds it."""
    monkeypatch.setattr("camtools.judge.binding.ROOT", tmp_path)
    assert not library_path().exists()
    with pytest.raises(CamtoolsError, match="cannot be loaded; start tools/mktables"):
        Judge(b"", 20_000, {})


def test_image_that_the_controller_refuses_is_one_line(table_of: Callable[[str], Path]) -> None:
    """The line is the controller's."""
    image = bytearray(table_of("perkins240").read_bytes())
    image[-1] ^= 1
    with pytest.raises(CamtoolsError, match=r"refuses the table: .* its CRC-32 differs"):
        Judge(bytes(image), 20_000, {})


@pytest.mark.parametrize("is_ring_helix", [False, True])
def test_feed_too_small_is_refused(table_of: Callable[[str], Path], *, is_ring_helix: bool) -> None:
    """More turns than the controller counts, at the edge of it; the feed is what helps."""
    made = unpack(table_of("perkins240_ring_helix" if is_ring_helix else "perkins240").read_bytes())
    span_nm, per_feed = made.z_last_nm - made.z_first_nm, 1 + is_ring_helix
    least_nm = -(-span_nm * per_feed // ((1 << 22) - 2 - per_feed))
    limits = MachineLimits()
    for feed_nm in (1, least_nm - 1):
        with pytest.raises(
            RefusedError, match=r"controller's turns = .* no speed helps: give a larger"
        ):
            check_table(replace(made, feed_nm=feed_nm, spindle_mrpm=1000), limits)
    check_table(replace(made, feed_nm=least_nm + 1, spindle_mrpm=1000), limits)


@pytest.mark.parametrize("offset_mm", [7.3, 7.4, 7.49, 7.6])
def test_disc_that_fits_its_stroke_is_accepted(offset_mm: float, tmp_path: Path) -> None:
    """A stroke of 30 mm has 15 to either side of the base circle: lifts up to 15 fit."""
    text = re.sub(r"offset_mm = [\d.]+", f"offset_mm = {offset_mm}", DISC)
    text = re.sub(r"base_radius_mm = [\d.]+", f"base_radius_mm = {25 - offset_mm:.12g}", text)
    text = re.sub(r"u_stroke_mm = [\d.]+", "u_stroke_mm = 30", text)
    if offset_mm > 7.5:
        with pytest.raises(CamtoolsError, match=r"u_stroke_mm = 30 mm: the part needs 30\.[4-6]"):
            generate_lobes(cam(text))
        return
    made = generate_lobes(cam(text))
    said, _ = cut(tmp_path, made.table, made.part.machine.limits, made.table.spindle_mrpm, *SHORT)
    assert "infeasible" not in said


def test_refusal_has_the_numbers_of_the_controller(table_of: Callable[[str], Path]) -> None:
    """In the units of the part file."""
    table = unpack(table_of("perkins240").read_bytes())
    weak = MachineLimits(u_acceleration_mm_s2=100.0)
    demands = judge_of(table, weak).exceeded(table.spindle_mrpm)
    [demand] = [one for one in demands if one.name == "u_acceleration"]
    with pytest.raises(CamtoolsError) as info:
        check_table(table, weak)
    assert any(
        line.startswith("machine.limits.u_acceleration_mm_s2 = 100 mm/s2: the part needs ")
        and f"{demand.needed:.9g} mm/s2" in line
        for line in info.value.lines
    )
