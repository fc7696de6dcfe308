# SPDX-License-Identifier: Apache-2.0
r"""What a loop does on its drive, as text.

>>> from camtools.tune.judgement import judge
>>> from camtools.tune.loop_design import Loop
>>> drive = Drive(mass_kg=1.5, amplifier_hz=1500.0, delay_us=25.0, tick_hz=20000.0)
>>> judged = judge(Loop(250.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), drive.plant)
>>> print(*lines_of(judged, drive), sep="\n")
crossover: 244 Hz
margins at 0.7 of the mass: 15.7 dB, 34 degrees
margins at 1 of the mass: 18.8 dB, 31 degrees
margins at 1.3 of the mass: 21.1 dB, 29 degrees
least dynamic stiffness: 1.6 N/um at 192 Hz
step of 10 N: peak 5.11 um, within 0.1 um after 60.6 ms
"""

from __future__ import annotations

from collections.abc import Iterator

from camtools.tune.drive import Drive
from camtools.tune.judgement import BACK_UM, STEP_N, Judgement
from camtools.tune.loop_design import MASSES


def lines_of(judged: Judgement, drive: Drive) -> Iterator[str]:
    """Yield the report, line by line."""
    yield f"crossover: {judged.crossing_hz:.0f} Hz"
    for mass, at in zip(MASSES, judged.at, strict=True):
        yield f"margins at {mass:g} of the mass: {at.gain_db:.1f} dB, {at.phase_deg:.0f} degrees"
    stiffness, at_hz = judged.stiffness_n_per_um, judged.weakest_hz
    yield f"least dynamic stiffness: {stiffness:.3g} N/um at {at_hz:.3g} Hz"
    back = f"within {BACK_UM:g} um after {1e3 * judged.back_s:.3g} ms"
    if judged.back_s == float("inf"):
        back = f"not within {BACK_UM:g} um after {judged.step_s[-1]:.1f} s"
    yield f"step of {STEP_N:g} N: peak {judged.peak_um:.3g} um, {back}"
    if drive.scale_quantum_nm:
        noise = judged.noise_n(drive.scale_quantum_nm)
        yield f"noise of the force: {noise:.3g} N rms by a scale of {drive.scale_quantum_nm:g} nm"
    if drive.task is not None:
        yield from _task_lines(drive)


def _task_lines(drive: Drive) -> Iterator[str]:
    needed = drive.needed()
    limits = (
        ("peak", needed.peak_n, drive.force_limit_n, "force_limit_n"),
        ("rms", needed.rms_n, drive.continuous_n, "continuous_n"),
    )
    for name, force, limit, key in limits:
        verdict = ""
        if limit is not None:
            word = "enough" if force <= limit else "NOT ENOUGH"
            verdict = f"; {key} = {limit:g}: {word}"
        yield f"task without cutting force: {force:.0f} N {name}{verdict}"
