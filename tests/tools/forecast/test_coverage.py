# SPDX-License-Identifier: Apache-2.0
"""Machines that the forecast does not draw itself are as good as it forecasts."""

import json
from pathlib import Path

import numpy as np
import pytest

from camtools.base.quantities import Floats
from camtools.cli.forecast import main
from camtools.cli.mktables import main as mktables
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.part_cases import PERKINS

TURNS, DRAWN, MACHINES = 10, 128, 64
# The part's own machine: the limits of the part file, every other number by default.
KNOWN = {
    "spindle": {"limit_rpm": 3000, "ripple": 0.002},
    "u": {"speed_mm_per_s": 400, "acceleration_mm_per_s2": 250000, "stroke_mm": 1.2},
}
BELIEVED = """\
[believed.u]
bandwidth_hz = 300
damping = 0.7
delay_us = 75
mass_kg = 1.5
friction_m_per_s2 = 0
scale_latency_us = 0
scale_error_nm = 0
mode_2_hz = 0
[believed.spindle]
bandwidth_rad_per_s = 40
ripple = 0.002
ripple_2 = 0
runout_um = 0
runout_2_um = 0
[believed.encoder]
eccentricity_counts = 0
[believed.cut]
kc_n_per_mm2 = 0
tool_stiffness_n_per_um = 0
"""


def within_three(rng: np.random.Generator) -> float:
    """Draw a normal number until it is within three standard deviations."""
    while abs(drawn := rng.normal()) > 3:
        pass
    return float(drawn)


def machine(rng: np.random.Generator) -> str:
    """Return the machine file of a lathe as a builder may get it: what FORECAST.md calls usual."""
    numbers = {
        "spindle": {
            "bandwidth_rad_per_s": 40 * 1.5 ** within_three(rng),
            "ripple": 0.002 * 1.5 ** within_three(rng),
            "ripple_2": rng.uniform(0, 0.0005),
            "ripple_per_turn_2": rng.uniform(0.3, 3),
            "runout_um": rng.uniform(0, 0.1),
            "runout_2_um": rng.uniform(0, 0.03),
        },
        "encoder": {"eccentricity_counts": abs(0.1 * within_three(rng))},
        "u": {
            "bandwidth_hz": 300 * (1 + 0.05 * within_three(rng)),
            "damping": 0.7 * (1 + 0.05 * within_three(rng)),
            "delay_us": 75 * (1 + 0.05 * within_three(rng)),
            "mass_kg": 1.5 * (1 + 0.05 * within_three(rng)),
            "friction_m_per_s2": rng.uniform(0, 5),
            "scale_latency_us": abs(0.25 * within_three(rng)),
            "scale_error_nm": rng.uniform(0, 20),
            "mode_2_hz": rng.uniform(1500, 4000),
            "mode_2_share": rng.uniform(0.1, 0.5),
        },
        "cut": {
            "kc_n_per_mm2": rng.uniform(400, 900),
            "radial_share": rng.uniform(0.2, 0.5),
            "tool_stiffness_n_per_um": rng.uniform(50, 200),
        },
    }
    lines = []
    for table, keys in numbers.items():
        lines.append(f"[{table}]")
        lines += [f"{key} = {value}" for key, value in (KNOWN.get(table, {}) | keys).items()]
    return "\n".join(lines) + "\n" + BELIEVED


def errors_um(folder: Path) -> Floats:
    """Cut on independent machines; return their form errors."""
    assert mktables([str(PERKINS), "-o", str(folder)]) == 0
    rng, found = np.random.default_rng(31), []
    for _ in range(MACHINES):
        (folder / "m.toml").write_text(machine(rng))
        words = ("--machine", folder / "m.toml", "--summary", folder / "s.json")
        camsim("run", folder / "perkins240.camtab", *words, "--turns-limit", str(TURNS))
        found.append(json.loads((folder / "s.json").read_text())["form_error_um"]["max"])
    return np.array(found)


def test_independent_machines_are_as_forecast(tmp_path: Path) -> None:
    """Their median is that of the forecast, and nine of ten are below its 90 %.

    Of 64 machines 57.6 +- 2.4 are below the true quantile; that of 128 others is uncertain by 1.7.
    """
    words = ("--turns", str(TURNS), "--runs", str(DRAWN), "-o", str(tmp_path / "o"))
    assert main([str(PERKINS), *words]) == 0
    about = json.loads((tmp_path / "o" / "forecast.json").read_text())
    median, ninety, *_ = about["form_error_um"]
    found = errors_um(tmp_path)
    assert np.median(found) == pytest.approx(median["value_um"], rel=0.15)
    assert 51 <= np.count_nonzero(found <= ninety["value_um"]) <= 63
