# SPDX-License-Identifier: Apache-2.0
"""The picture of the frequency response."""

import numpy as np
import pytest

from camtools.identify.bode import bode_png, left_by_fit, measured_response
from camtools.identify.fit import FRICTION, K1, K2
from camtools.identify.identified import identify
from camtools.identify.multisine import Grid, multisine
from camtools.identify.recording import record_of
from tests.tools.cases.drive_plant import Plant, faded, played


def test_measured_response_is_that_of_the_drive_without_friction() -> None:
    """Within its noise, though the drive rubs."""
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
    assert bode_png(found, believed, "U").startswith(b"\x89PNG")


def test_what_the_fit_leaves_of_a_line_is_the_distance_of_the_curves() -> None:
    """The blue dots below are the gap between dots and curve above: of a drive with a mode, too."""
    grid, plant = Grid.of(10_000.0), Plant(friction_m_s2=0)
    u_nm = faded(multisine(grid, 25_000.0, 300_000.0), 4)
    y_nm = played([plant], u_nm, grid.tick_hz)[0]
    rung_nm = y_nm + 0.02 * np.roll(y_nm, 7)
    found = identify(
        record_of(grid, np.arange(u_nm.size), u_nm, rung_nm, plant.quantum_nm), with_mode=False
    )
    measured, _ = measured_response(found)
    s, friction = found.spectra.s, found.plain.values[FRICTION] * found.spectra.friction
    slide = 1 + found.plain.values[K1] * s + found.plain.values[K2] * s**2
    with_friction = measured - friction / slide / found.spectra.u
    gap = np.abs(found.plain.response(s) / measured - 1) * np.abs(measured / with_friction)
    assert left_by_fit(found) == pytest.approx(gap, rel=0.02, abs=1e-4)
