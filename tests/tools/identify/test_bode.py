# SPDX-License-Identifier: Apache-2.0
"""The picture of the frequency response."""

from __future__ import annotations

import numpy as np

from camtools.identify.bode import bode_png, measured_response
from camtools.identify.identified import identify
from camtools.identify.multisine import Grid, multisine
from camtools.identify.recording import record_of
from drive_plant import Plant, faded, played


def test_measured_response_is_that_of_the_drive_without_friction() -> None:
    """Within its noise, though the drive rubs; the picture is the same every time."""
    grid, plant = Grid.of(10_000.0), Plant(friction_m_s2=5)
    u_nm = faded(multisine(grid, 25_000.0, 300_000.0), 4)
    y_nm = played([plant], u_nm, grid.tick_hz)[0]
    record = record_of(grid, np.arange(u_nm.size), u_nm, y_nm, plant.quantum_nm)
    found = identify(record, with_mode=False)
    measured, _ = measured_response(found)
    s = found.spectra.s
    exact = np.exp(-plant.lead_s(grid.tick_hz) * s) / (1 + plant.k1_s * s + plant.k2_s2 * s**2)
    assert np.max(np.abs(measured / exact - 1)) < 0.01
    believed = found.plain.values * 1.1
    first, second = (bode_png(found, believed, "U") for _ in range(2))
    assert first.startswith(b"\x89PNG") and first == second
