# SPDX-License-Identifier: Apache-2.0
"""Crossover and margins of points of an open loop, and where a picture shows the points."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from camtools.tune import plots
from camtools.tune.judgement import judge
from camtools.tune.loop_design import Loop, Plant
from camtools.tune.measured_loop import OpenLoop, figures, text_of


def double(last_hz: float) -> OpenLoop:
    """Return K (1 + s T) exp(-s d) / s^2 at every 10 Hz; |L| = 1 at 200 Hz."""
    hz = np.arange(5.0, last_hz, 10.0)
    s, cross = 2j * np.pi * hz, 2j * np.pi * 200.0
    lead_s, delay_s = 2e-3, 0.2e-3
    gain = abs(cross**2 / (1 + cross * lead_s))
    return OpenLoop(hz, gain * (1 + s * lead_s) * np.exp(-s * delay_s) / s**2)


def test_figures_are_those_of_the_formula() -> None:
    """Phase: the lead's minus the delay's; gain: where the lead's 90 degrees are eaten up."""
    found = figures(double(3000.0))
    assert found.crossover_hz == pytest.approx(200.0, rel=2e-3)
    phase_deg = np.degrees(np.arctan(2 * np.pi * 200 * 2e-3)) - 360 * 200 * 0.2e-3
    assert found.phase_deg == pytest.approx(phase_deg, abs=0.1)
    turns = np.arange(200.0, 3000.0, 0.01)
    left = np.degrees(np.arctan(2 * np.pi * turns * 2e-3)) - 360 * turns * 0.2e-3
    turn_hz = float(turns[int(np.argmin(np.abs(left)))])
    assert found.gain_hz == pytest.approx(turn_hz, rel=2e-3)
    ratio = np.abs(1 + 2j * np.pi * np.array([200.0, turn_hz]) * 2e-3)
    level = 20 * np.log10(ratio[1] / ratio[0] * (200.0 / turn_hz) ** 2)
    assert found.gain_db == pytest.approx(-level, abs=0.05)


def test_what_lies_beyond_the_lines_is_said() -> None:
    """Lines that end before the phase, or the level, crosses."""
    assert text_of(double(900.0)).endswith("gain margin not within the lines of 5 .. 895 Hz")
    assert figures(double(900.0)).phase_deg == figures(double(3000.0)).phase_deg
    assert text_of(double(150.0)) == "crossover not within the lines of 5 .. 145 Hz"


def test_picture_has_the_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Level, phase and Nyquist; without a record there are none."""
    seen: list[Figure] = []
    monkeypatch.setattr(plots, "png_of", seen.append)
    plant = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
    judged = judge(Loop(250.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), plant)
    one = double(3000.0)
    for measured in (None, one):
        plots.loop_png(judged, "demo", measured)
    dots = [[line for axes in figure.axes for line in axes.lines if line.get_marker() == "."]
            for figure in seen]  # fmt: skip
    assert not dots[0]
    level, phase, nyquist = (np.asarray(line.get_ydata()) for line in dots[1])
    np.testing.assert_allclose(10 ** (level / 20), np.abs(one.response))
    turns = np.exp(1j * np.radians(phase))
    np.testing.assert_allclose(turns, one.response / np.abs(one.response), atol=1e-9)
    np.testing.assert_allclose(nyquist, one.response.imag)
    assert phase.max() <= 0.0 and phase.min() > -360.0
