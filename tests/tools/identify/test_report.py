# SPDX-License-Identifier: Apache-2.0
"""The report: numbers, settings, doubts."""

from functools import cache

import numpy as np

from camtools.identify.configured_drive import Believed
from camtools.identify.identified import Identified, Limits, identify
from camtools.identify.multisine import Grid, multisine
from camtools.identify.part_error import ToolMotion
from camtools.identify.recording import record_of
from camtools.identify.report import report
from tests.tools.cases.drive_plant import Plant, faded, played

BELIEVED = Believed(10_000.0, 800_000, 300_000, 120_000, 4000, 10, 1_200_000, 400_000, 250_000)
MOTION = ToolMotion(500_000 * np.cos(4 * np.pi * np.arange(256) / 256), 3000.0)


@cache
def found(plant: Plant) -> Identified:
    """Identify a drive at 10 kHz."""
    grid = Grid.of(10_000.0)
    u_nm = faded(multisine(grid, 25_000.0, 300_000.0), 4)
    y_nm = played([plant], u_nm, grid.tick_hz)[0]
    return identify(record_of(grid, np.arange(u_nm.size), u_nm, y_nm, plant.quantum_nm))


def test_settings_are_the_drive() -> None:
    """What would be set, with the latency of the scale taken off the lead."""
    lines = report(found(Plant(friction_m_s2=5)), BELIEVED, Limits(), MOTION, "oval", is_good=True)
    said = dict(line.split()[2:] for line in lines if line.startswith("tools/camctl set"))
    plant = Plant()
    assert abs(int(said["k1_ns"]) / (plant.k1_s * 1e9) - 1) < 0.003
    assert abs(int(said["k2_us2"]) / (plant.k2_s2 * 1e12) - 1) < 0.003
    assert abs(int(said["lead_ns"]) - (plant.lead_s(10_000.0) * 1e9 - 4000)) < 1000
    keys = dict(line.split(" = ") for line in lines if " = " in line)
    assert abs(float(keys["bandwidth_hz"]) - 300) < 1
    assert abs(float(keys["damping"]) - 0.7) < 0.003
    assert abs(float(keys["delay_us"]) - 71) < 1
    assert any(line.startswith("friction adds up to 1.") for line in lines)
    text = "\n".join(lines)
    assert "oval at 3000 r/min: U moves at up to 314 mm/s and 197 m/s2" in text
    assert (
        "lead: dead time and half a tick of hold; the latency of the scale cannot be separated"
        in text
    )
