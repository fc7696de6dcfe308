"""The picture of a loop: open loop, sensitivity, step of force, dynamic stiffness.

>>> from camtools.tune.judgement import judge
>>> from camtools.tune.loop_design import Loop, Plant
>>> drive = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
>>> picture = loop_png(judge(Loop(250.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), drive), "demo")
>>> picture[1:4]
b'PNG'
"""

import numpy as np
from matplotlib.axes import Axes

from camtools.plots import style
from camtools.tune.judgement import BACK_UM, STEP_N, Judgement, OpenLoop
from camtools.tune.loop_design import (
    LEAST_GAIN_DB,
    LEAST_PHASE_DEG,
    MASSES,
    Complexes,
    Reals,
    closed_compliance,
    open_loop,
    response_grid,
)

_COLOURS = dict(zip(MASSES, (style.ORANGE, style.BLUE, style.RED), strict=True))
_LOWEST_HZ = 5.0
_NYQUIST = 2.5
_LEVELS_DB = (-60.0, 60.0)


def _decibels(axes: Axes, hz: Reals, values: Complexes, mass: float) -> None:
    label = f"{mass:g} x mass"
    axes.plot(hz, 20 * np.log10(np.abs(values)), color=_COLOURS[mass], label=label)


def _nyquist(axes: Axes) -> None:
    """Draw the unit circle and what the margins keep clear."""
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    axes.plot(turn.real, turn.imag, color=style.GREY, lw=0.8)
    near = np.exp(1j * np.radians(180 + np.array([-LEAST_PHASE_DEG, LEAST_PHASE_DEG])))
    axes.plot(near.real, near.imag, "k_", ms=8)
    axes.plot([-(10 ** (-LEAST_GAIN_DB / 20))], [0], "k|", ms=8)
    axes.plot([-1], [0], "k+", ms=10)
    limits = (-_NYQUIST, _NYQUIST / 2)
    axes.set(xlim=limits, ylim=(-0.75 * _NYQUIST, 0.75 * _NYQUIST), aspect="equal")
    axes.set(xlabel="open loop, real part", ylabel="imaginary part")


def _curves(panels: list[Axes], judged: Judgement, hz: Reals, mass: float) -> None:
    real = judged.mass * mass
    level, phase, nyquist, sensitivity, _, stiffness = panels
    opened = open_loop(judged.row, judged.plant, hz, real)
    _decibels(level, hz, opened, mass)
    angle = np.degrees(np.unwrap(np.angle(opened)))
    angle -= 360 * np.ceil(angle[0] / 360)  # from -270 .. 0 degrees on
    phase.plot(hz, angle, color=_COLOURS[mass])
    nyquist.plot(opened.real, opened.imag, color=_COLOURS[mass])
    _decibels(sensitivity, hz, 1 / (1 + opened), mass)
    compliance = closed_compliance(judged.row, judged.plant, hz, real)
    stiffness.plot(hz, 1e-6 / np.abs(compliance), color=_COLOURS[mass])


def _step(axes: Axes, judged: Judgement) -> None:
    time_ms = 1e3 * judged.step_s
    axes.plot(time_ms, judged.step_um, color=style.BLUE)
    for side in (-BACK_UM, BACK_UM):
        axes.axhline(side, color=style.GREY, lw=0.8, ls="--")
    end = judged.back_s if np.isfinite(judged.back_s) else judged.step_s[-1]
    axes.set(xlim=(0, max(10.0, 1.5e3 * end)))
    axes.set(xlabel="time, ms", ylabel=f"after a step of {STEP_N:g} N, um")


def _measured(panels: list[Axes], loop: OpenLoop) -> None:
    level, phase, nyquist = panels[:3]
    decibels = 20 * np.log10(np.abs(loop.response))
    level.plot(loop.hz, decibels, "k.", ms=3, label="as it is, measured")
    phase.plot(loop.hz, -np.degrees(np.angle(loop.response.conj()) % (2 * np.pi)), "k.", ms=3)
    nyquist.plot(loop.response.real, loop.response.imag, "k.", ms=3)


def loop_png(judged: Judgement, title: str, measured: OpenLoop | None = None) -> bytes:
    """Return the picture as PNG. `judged`: of a stable loop. `measured`: of the loop in force."""
    hz = response_grid(judged.plant)
    hz = hz[hz >= _LOWEST_HZ]
    with style.drawing():
        figure = style.titled_figure(13.0, 8.0, title)
        panels: list[Axes] = list(figure.subplots(2, 3).ravel())
        for mass in MASSES:
            _curves(panels, judged, hz, mass)
        _nyquist(panels[2])
        if measured is not None:
            _measured(panels, measured)
        _step(panels[4], judged)
        names = ("open loop, dB", "open loop, degrees", "", "sensitivity, dB", "")
        for axes, name in zip(panels, (*names, "dynamic stiffness, N/um"), strict=True):
            axes.grid(color="#dddddd", linewidth=0.6)
            if name:
                style.log_axis(axes, "x", _LOWEST_HZ, float(hz[-1]))
                axes.set(xlabel="frequency, Hz", ylabel=name)
        panels[0].set_ylim(_LEVELS_DB)
        panels[0].axhline(0, color=style.GREY, lw=0.8)
        panels[1].set(ylim=(-540, 0), yticks=range(-540, 1, 90))
        panels[3].set_ylim(-60, 15)
        least = judged.stiffness_n_per_um
        style.log_axis(panels[5], "y", 0.5 * least, 1e3 * least)
        panels[0].legend(loc="lower left", frameon=False)
        return style.png_of(figure)
