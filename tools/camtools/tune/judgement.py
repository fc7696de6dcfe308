r"""What a loop does on its drive, measured or described: proposals, refusals, reports.

A measured open loop has no model of the drive: it is the reading over the whole force, times the
response of the controller's parameters.

>>> plant = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
>>> judged = judge(Loop(250.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), plant)
>>> f"{judged.crossing_hz:.0f} Hz, {judged.stiffness_n_per_um:.2f} N/um"
'244 Hz, 1.60 N/um'
>>> refusal(judged, is_proposal=False).split("; ")[-1]
'most to blame is the lag of the amplifier of 1500 Hz: take a faster one'

>>> hz = np.linspace(10.0, 990.0, 99)
>>> response = 100.0 / (1j * hz) * np.exp(-2j * np.pi * hz * 0.5e-3)
>>> print(loop_text(OpenLoop(hz, response)))
crossover 100 Hz, phase margin 72.0 degrees, gain margin 14.0 dB at 500 Hz
>>> refusal_by_lines(OpenLoop(hz, response))
''
>>> refusal_by_lines(OpenLoop(hz, response * np.exp(-2j * np.pi * hz * 1.5e-3))).split(",")[0]
'as measured it has 1.9 dB and 18 degrees'
"""

from collections.abc import Iterator, Mapping
from dataclasses import astuple, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camtools.identify.recording import Spectra
from camtools.tune.excited import Measured
from camtools.tune.loop_design import (
    LEAST_GAIN_DB,
    LEAST_PHASE_DEG,
    MASSES,
    Complexes,
    Loop,
    Margins,
    Plant,
    Reals,
    best,
    closed_compliance,
    controller_response,
    margins,
    open_loop,
    response_grid,
    step_response,
)
from camtools.tune.parameters import Drive, drive_of, loop_of, parameters_of, plant_of, read_loop
from camtools.tune.plant_fit import fit_lines_of, with_fit

STEP_N = 10.0
BACK_UM = 0.1
_LINE_HZ = 1.0  # of the response to a step, which then lasts 0.5 s
_N_NOISE = 4000  # lines over which noise is summed
_WITHOUT_LAG_HZ = 1e6


@dataclass(frozen=True, eq=False)
class Judgement:
    """A loop on its drive."""

    loop: Loop
    plant: Plant  # with the mass that the loop is made for
    mass: float  # real one, relative to that; the fields below are for it
    at: tuple[Margins, ...]  # at MASSES times the real mass
    crossing_hz: float  # the last of the open loop through 0 dB
    weakest_hz: float  # of the least dynamic stiffness
    stiffness_n_per_um: float
    step_um: Reals  # after a step of STEP_N, for 0.5 s

    @property
    def row(self) -> Reals:
        """The loop as the functions of loop_design take it."""
        return np.array(astuple(self.loop))

    @property
    def step_s(self) -> Reals:
        """Times of step_um."""
        return np.linspace(0.0, 0.5 / _LINE_HZ, self.step_um.size, endpoint=False)

    @property
    def peak_um(self) -> float:
        """Greatest deviation after the step."""
        return float(np.abs(self.step_um).max())

    @property
    def back_s(self) -> float:
        """Time after which the deviation stays below BACK_UM; infinity if it does not."""
        above = np.flatnonzero(np.abs(self.step_um) > BACK_UM)
        if above.size == 0:
            return 0.0
        is_back = above[-1] + 1 < self.step_um.size
        return float(self.step_s[above[-1] + 1]) if is_back else np.inf

    def noise_n(self, quantum_nm: float) -> float:
        """Return the force rms that the rounding of a scale causes."""
        hz = (np.arange(_N_NOISE) + 0.5) / _N_NOISE * 0.5 * self.plant.step_hz
        force = controller_response(self.row, self.plant, hz)
        force /= 1.0 + open_loop(self.row, self.plant, hz, self.mass)
        return float(quantum_nm * 1e-9 * np.sqrt(np.mean(np.abs(force) ** 2) / 12.0))


def judge(loop: Loop, plant: Plant, mass: float = 1.0) -> Judgement:
    """Judge a loop; arguments of `margins`."""
    row, hz = np.array(astuple(loop)), response_grid(plant)
    level = np.abs(open_loop(row, plant, hz, mass))
    stiffness = 1e-6 / np.abs(closed_compliance(row, plant, hz, mass))
    weakest = int(np.argmin(stiffness))
    return Judgement(
        loop, plant, mass,
        tuple(margins(loop, plant, mass * relative) for relative in MASSES),
        float(hz[np.flatnonzero(level > 1.0)[-1]]) if level.max() > 1.0 else 0.0,
        float(hz[weakest]), float(stiffness[weakest]),
        STEP_N * 1e6 * step_response(row, plant, _LINE_HZ, mass),
    )  # fmt: skip


def _missing(at: tuple[Margins, ...]) -> float:
    """Return how much the margins lack, 0: nothing; of each mass 1: all, 2: unstable."""

    def lack(reached: Margins) -> float:
        share = min(reached.gain_db / LEAST_GAIN_DB, reached.phase_deg / LEAST_PHASE_DEG)
        return max(0.0, 1.0 - share) if reached.is_stable else 2.0

    return sum(map(lack, at))


def _without(plant: Plant) -> dict[str, Plant]:
    """Return the drive without each of its lags, by its description and remedy."""
    quick = max(_WITHOUT_LAG_HZ, plant.amplifier_hz)
    tick = f"the hold of a tick at {plant.step_hz * 1e-3:.3g} kHz: raise the rate"
    lag = f"the lag of the amplifier of {plant.amplifier_hz:.4g} Hz: take a faster one"
    found = {
        f"the delay of {plant.delay_s * 1e6:.3g} us: shorten it": replace(plant, delay_s=0.0),
        tick: replace(plant, delay_s=plant.delay_s - 0.5 / plant.step_hz),
        lag: replace(plant, amplifier_hz=quick),
    }
    if plant.mode_hz:
        mode = f"the mode at {plant.mode_hz:.4g} Hz: damp or stiffen it"
        found[mode] = replace(plant, mode_hz=0.0)
    return found


def _culprit(judged: Judgement, is_proposal: bool) -> str:
    without = _without(judged.plant)

    def lacks(what: str) -> tuple[float, float]:
        plant = without[what]
        loop = best(plant) if is_proposal else judged.loop
        if judged.plant.mode_hz and not plant.mode_hz and not is_proposal:
            loop = replace(loop, notch_zero=loop.notch_pole)
        rejudged = judge(loop, plant, judged.mass)
        return _missing(rejudged.at), rejudged.peak_um

    return min(without, key=lacks)


def refusal(judged: Judgement, *, is_proposal: bool) -> str:
    """Return why a loop, proposed as best or given, is refused and what to do; "" if it is not."""
    poor = [pair for pair in zip(MASSES, judged.at, strict=True) if not pair[1].is_enough]
    if not poor:
        return ""
    mass, at = min(poor, key=lambda pair: (pair[1].is_stable, pair[1].gain_db, pair[1].phase_deg))
    state = f"{at.gain_db:.1f} dB and {at.phase_deg:.0f} degrees" if at.is_stable else "unstable"
    return (
        f"margins at {mass:g} of the mass: {state}; at least {LEAST_GAIN_DB:g} dB and "
        f"{LEAST_PHASE_DEG:g} degrees; most to blame is {_culprit(judged, is_proposal)}"
    )


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
    limits = (("peak", "force_limit_n"), ("rms", "continuous_n"))
    for force, (name, key) in zip(drive.needed_n(), limits, strict=True):
        limit, verdict = getattr(drive, key), ""
        if limit is not None:
            word = "enough" if force <= limit else "NOT ENOUGH"
            verdict = f"; {key} = {limit:g}: {word}"
        yield f"task without cutting force: {force:.0f} N {name}{verdict}"


class OpenLoop(NamedTuple):
    """An open loop at some frequencies, which rise."""

    hz: Reals
    response: Complexes


class Figures(NamedTuple):
    """Crossover and margins; None: not within the lines."""

    crossover_hz: float | None = None  # the last crossing of 0 dB
    phase_deg: float | None = None
    gain_db: float | None = None  # above the crossover
    gain_hz: float | None = None


def measured_loop(lines: Spectra, values: Mapping[str, int], drive: Drive) -> OpenLoop:
    """Return what lines of force [N] and position [nm] show of the loop in force."""
    hz = lines.frequency_hz
    row = np.array(astuple(loop_of(values, drive)))
    control = controller_response(row, plant_of(values, drive)[0], hz)
    force = lines.u / np.sinc(hz / drive.tick_hz)  # as it was commanded, without its hold
    return OpenLoop(hz, np.asarray(control * 1e-9 * lines.y / force))


def model_loop(values: Mapping[str, int], drive: Drive) -> OpenLoop:
    """Return what a model of the drive shows; arguments of `measured_loop`."""
    plant, mass = plant_of(values, drive)
    hz = response_grid(plant)
    return OpenLoop(hz, open_loop(np.array(astuple(loop_of(values, drive))), plant, hz, mass))


def _at_zeros(values: Reals, *others: Reals) -> list[Reals]:
    """Return others where values cross 0, linear between the lines."""
    i = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    part = values[i] / (values[i] - values[i + 1])
    return [row[i] + part * (row[i + 1] - row[i]) for row in others]


def figures(loop: OpenLoop) -> Figures:
    """Return crossover and margins."""
    log_hz, level_db = np.log(loop.hz), 20.0 * np.log10(np.abs(loop.response))
    angle_deg = np.degrees(np.unwrap(np.angle(-loop.response)))
    crossing, angle = _at_zeros(level_db, log_hz, angle_deg)
    if crossing.size == 0:
        return Figures()
    phase_deg = float(np.abs((angle + 180.0) % 360.0 - 180.0).min())
    found = Figures(float(np.exp(crossing[-1])), phase_deg)
    imag, real = loop.response.imag, loop.response.real
    turned, level, real = _at_zeros(imag, log_hz, level_db, real)
    is_crossing = (real < 0.0) & (turned > crossing[-1])
    if not is_crossing.any():
        return found
    least = int(np.argmax(np.where(is_crossing, level, -np.inf)))
    return found._replace(gain_db=-float(level[least]), gain_hz=float(np.exp(turned[least])))


def loop_text(loop: OpenLoop) -> str:
    """Return crossover and margins in a line."""
    found = figures(loop)
    missing = f"not within the lines of {loop.hz[0]:.0f} .. {loop.hz[-1]:.0f} Hz"
    if found.crossover_hz is None:
        return f"crossover {missing}"
    text = f"crossover {found.crossover_hz:.0f} Hz, phase margin {found.phase_deg:.1f} degrees"
    if found.gain_db is None:
        return f"{text}, gain margin {missing}"
    return f"{text}, gain margin {found.gain_db:.1f} dB at {found.gain_hz:.0f} Hz"


class Subject(NamedTuple):
    """What is tuned."""

    name: str  # of files
    where: str  # in errors
    drive: Drive
    lines: list[str]  # of its constants, and of its loop as it is
    is_measured: bool  # its constants
    measured: OpenLoop | None = None
    spectra: Spectra | None = None  # of force and reading


class Proposal(NamedTuple):
    """A loop for a drive."""

    values: dict[str, int]  # its parameters
    judged: Judgement
    problem: str  # why it is refused; "" where it has the margins
    lines: list[str]  # the report


def subject_of(found: Measured, keys: dict[str, Any], name: str, where: str) -> Subject:
    """Return the drive that an excitation shows, with keys of a drive file, and its loop."""
    drive = drive_of(with_fit(keys, found.fit, found.tick_hz), where)
    measured = measured_loop(found.lines, found.values, drive)
    lines = [
        *fit_lines_of(found.fit),
        f"as it is (measured): {loop_text(measured)}",
        f"as it is (model): {loop_text(model_loop(found.values, drive))}",
    ]
    return Subject(name, where, drive, lines, True, measured, found.lines)


_OF_LEAST = 2.0 / 3.0  # of the margins, that a loop needs on the lines themselves


def refusal_by_lines(loop: OpenLoop) -> str:
    """Return why a loop that is good on the model is not on what was measured; "" if it is."""
    found = figures(loop)
    if found.crossover_hz is None:
        return "its crossover is outside the measured frequencies; give another --highest-hz"
    gain_db = np.inf if found.gain_db is None else found.gain_db
    phase_deg = np.inf if found.phase_deg is None else found.phase_deg
    if gain_db >= _OF_LEAST * LEAST_GAIN_DB and phase_deg >= _OF_LEAST * LEAST_PHASE_DEG:
        return ""
    return (
        f"as measured it has {gain_db:.1f} dB and {phase_deg:.0f} degrees, so the model "
        "does not fit the drive; raise the crossover of the loop in force, and measure again"
    )


def proposed(subject: Subject, given: Path | None = None) -> Proposal:
    """Return the best loop for a drive, or the given one, which may be for another mass."""
    drive = subject.drive
    values = read_loop(given, drive) if given else parameters_of(best(drive.plant), drive)
    judged = judge(loop_of(values, drive), *plant_of(values, drive))
    problem = refusal(judged, is_proposal=given is None)
    if not problem and subject.spectra is not None:
        problem = refusal_by_lines(measured_loop(subject.spectra, values, drive))
    head = ["given:" if given else "proposed:"] if subject.measured else []
    return Proposal(values, judged, problem, [*subject.lines, *head, *lines_of(judged, drive)])
