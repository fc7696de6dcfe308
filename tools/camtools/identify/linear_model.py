"""The constants of a recorded drive or oscillator, and whether a linear model holds.

>>> u = np.random.default_rng(1).normal(0, 1e-4, 16384)
>>> s = 2j * np.pi * np.fft.rfftfreq(u.size, 1e-3)
>>> y = np.fft.irfft(2 * np.fft.rfft(u) / (1 + 2e-3 * s + 1e-5 * s**2))
>>> found = identify_record(ForeignRecord(1000.0, u, y, "command_um"))
>>> found.problems, f"{1 / found.values[STATIC]:.2f} {found.values[RATE]:.5f}"
([], '2.00 0.00100')
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.base.solvers import OF_RECORD, converged
from camtools.base.text import Json
from camtools.identify.fit import solved, stacked
from camtools.identify.foreign_record import FORCES, ForeignRecord
from camtools.identify.recording import Complexes

STATIC, RATE, SECOND, DELAY = range(4)
_MOST_SEGMENT, _LEAST_SEGMENTS = 8192, 16
_N_BLOCKS = 8
_FREE = 0.55  # of the segments, which overlap by half
_MOST_HZ = 0.4  # of the sampling rate
_LEAST_POWER = 1e-4  # of the strongest line of the command
_LEAST_COHERENCE, _MIN_LINES = 0.5, 8
_LIKENESS = 0.003  # a line is weighted by its noise down to this share
_MOST_MISFIT, _MOST_CHI = 0.05, 4.0
_MOST_CHANGE, _CHANGE_SIGMAS = 0.02, 4.0
_LINES_PER_WIDTH = 10.0
_MOST_DELAY_STEPS = 64.0
_MOST_DISTORTION = 0.005  # of the rms of the command
_ALIASES = 16
_LEAST_SPREAD = 0.2  # of the segments, over which the command moves


class Lines(NamedTuple):
    """Mean spectra of some segments, at lines where the command has power."""

    s: Complexes  # j times the angular frequency [rad/s]
    hold_s: float  # how long each value of the command is held; 0: it is not
    response: Complexes  # position per command
    coherence: Floats
    noise: Floats  # standard deviation of the response as a share of it


class Half(NamedTuple):
    """What one half of the segments gives by itself."""

    values: Floats  # shape (4,)
    sigmas: Floats


class LinearModel(NamedTuple):
    """Constants of (static + rate s + second s^2) position = command e^(-s delay), hold/2 in it."""

    values: Floats  # shape (4,), SI units
    replicas: Floats  # shape (blocks, 4); values without one block of the record each
    lines: Lines
    misfit: float  # rms of the relative error of the response
    chi: float  # the same over the deviations of the lines
    small: Half  # of the segments, with the smaller motion
    large: Half
    problems: list[str]  # why a linear model does not hold


class _Segments(NamedTuple):
    """Windowed transforms of half overlapping segments, shape (segments, bins)."""

    s: Complexes
    hold_s: float
    u: Complexes
    y: Complexes


def _transforms(values: Floats) -> Complexes:
    n = min(_MOST_SEGMENT, 2 * values.size // (_LEAST_SEGMENTS + 1))
    starts = np.arange(0, values.size - n + 1, n // 2)
    rows = values[starts[:, None] + np.arange(n)]
    rows = (rows - rows.mean(axis=1, keepdims=True)) * np.hanning(n + 1)[:n]
    # A Hann window smears the mean over two bins.
    return np.asarray(np.fft.rfft(rows)[:, 2 : int(_MOST_HZ * n)], np.complex128)


def _segments(record: ForeignRecord, hold_s: float) -> _Segments:
    u, y = _transforms(record.u), _transforms(record.y)
    n = min(_MOST_SEGMENT, 2 * record.u.size // (_LEAST_SEGMENTS + 1))
    bins = np.arange(2, 2 + u.shape[1])
    s = np.asarray(2j * np.pi * bins * record.rate_hz / n, np.complex128)
    return _Segments(s, hold_s, u, y)


def _check_excitation(segments: _Segments) -> None:
    """Refuse a command that moves in too few segments, as a single step does."""
    energy = np.sum(np.abs(segments.u) ** 2, axis=1)
    spread = float(energy.sum() ** 2 / max(np.sum(energy**2), 1e-300)) / energy.size
    if spread < _LEAST_SPREAD:
        problem = (
            f"the command moves in {100 * spread:.2g} % of the record, at least "
            f"{100 * _LEAST_SPREAD:g} % are needed, so a single step is not enough"
        )
        remedy = "record noise, a sweep or many steps throughout"
        raise CamtoolsError([f"--record: {problem}; {remedy}"])


def _lines(segments: _Segments) -> Lines:
    """Return the mean of segments at the lines that the command excites coherently."""
    power_u, power_y = (
        np.mean(np.abs(transform) ** 2, axis=0) for transform in (segments.u, segments.y)
    )
    cross = np.mean(segments.y * segments.u.conj(), axis=0)
    coherence = np.abs(cross) ** 2 / np.maximum(power_u * power_y, 1e-300)
    is_used = (power_u > _LEAST_POWER * power_u.max()) & (coherence > _LEAST_COHERENCE)
    if np.count_nonzero(is_used) < _MIN_LINES:
        best = float(np.median(coherence[power_u > _LEAST_POWER * power_u.max()]))
        problem = (
            f"{np.count_nonzero(is_used)} lines have a coherence above {_LEAST_COHERENCE:g}, "
            f"{_MIN_LINES} are needed; the median is {best:.2g}: noise, or far from linear"
        )
        raise CamtoolsError([f"--record: {problem}; excite more frequencies, by another force"])
    used = coherence[is_used]
    free = _FREE * segments.u.shape[0]
    noise = np.sqrt(np.maximum(1 - used, 0.0) / (2 * used * free))
    response = cross[is_used] / power_u[is_used]
    return Lines(segments.s[is_used], segments.hold_s, response, used, noise)


def _solve(lines: Lines, delay_s: float) -> Floats:
    weight = 1 / np.hypot(lines.noise, _LIKENESS)
    columns = [lines.response * lines.s**i * np.exp(delay_s * lines.s) * weight for i in range(3)]
    return solved(columns, np.asarray(weight, np.complex128))[0]


def _off(values: Floats, lines: Lines) -> Floats:
    """Return the stacked error of the response over the deviations of its lines."""
    weight = 1 / (np.abs(lines.response) * np.hypot(lines.noise, _LIKENESS))
    return stacked((response_of(values, lines.s, lines.hold_s) - lines.response) * weight)


def _begin(lines: Lines) -> Floats:
    """Return where a fit begins: linear least squares for the best of many delays."""
    step_s = 0.25 * np.pi / float(np.abs(lines.s[-1]))
    delays_s = np.arange(-2, 4 * _MOST_DELAY_STEPS) * step_s
    tried = [np.append(_solve(lines, delay_s), delay_s) for delay_s in delays_s]
    costs = [float(np.sum(_off(values, lines) ** 2)) for values in tried]
    return tried[int(np.argmin(costs))]


def _fit(lines: Lines, begin: Floats) -> Floats:
    """Return the constants with the least error of the response, over its deviations."""
    high = float(np.abs(lines.s[-1]))
    static = float(np.abs(begin[STATIC]))
    scale = np.array([static, static / high, static / high**2, 1 / high])
    found = least_squares(lambda x: _off(x * scale, lines), begin / scale, x_scale="jac")
    return np.asarray(converged(found, "record: constants", OF_RECORD).x * scale)


def _fit_of(segments: _Segments, rows: Ints, begin: Floats) -> Floats:
    return _fit(_lines(segments._replace(u=segments.u[rows], y=segments.y[rows])), begin)


def _replicas(segments: _Segments, blocks: list[Ints], begin: Floats) -> Floats:
    rows = [np.concatenate(blocks[:i] + blocks[i + 1 :]) for i in range(len(blocks))]
    return np.array([_fit_of(segments, kept, begin) for kept in rows])


def jackknife(replicas: Floats) -> Floats:
    """Return standard deviations from values without one block each, shape (blocks, ..)."""
    n = replicas.shape[0]
    off = replicas - replicas.mean(axis=0)
    return np.asarray(np.sqrt((n - 1) / n * np.sum(off**2, axis=0)))


def _halves(segments: _Segments, begin: Floats) -> list[Half]:
    order = np.argsort(np.sum(np.abs(segments.y) ** 2, axis=1))
    found = []
    for rows in np.array_split(order, 2):
        blocks = [rows[i::_N_BLOCKS] for i in range(_N_BLOCKS)]
        replicas = _replicas(segments, blocks, begin)
        found.append(Half(_fit_of(segments, rows, begin), jackknife(replicas)))
    return found


def response_of(values: Floats, s: Complexes, hold_s: float) -> Complexes:
    """Return the response of constants at s = j w, for a command held [s] MATHS.md (225)."""
    if hold_s:
        step = 2j * np.pi / hold_s
        aliases = s[:, None] + step * np.arange(-_ALIASES, _ALIASES + 1)
        held = np.exp(aliases * hold_s / 2) - np.exp(-aliases * hold_s / 2)
        folded = response_of(values, aliases, 0.0) * held / (aliases * hold_s)
        return np.asarray(np.sum(folded, axis=1))
    below = values[STATIC] + values[RATE] * s + values[SECOND] * s**2
    return np.asarray(np.exp(-values[DELAY] * s) / below)


def _held_or_not(record: ForeignRecord) -> tuple[_Segments, Lines, Floats]:
    """Return the fit for a continuous command, or for a held one where that is clearly better."""
    found = []
    for hold_s, doubt in ((0.0, 0.0), (1 / record.rate_hz, _CHANGE_SIGMAS**2)):
        segments = _segments(record, hold_s)
        _check_excitation(segments)
        lines = _lines(segments)
        values = _fit(lines, _begin(lines))
        cost = float(np.sum(_off(values, lines) ** 2)) + doubt
        found.append((cost, (segments, lines, values)))
    return min(found, key=lambda fitted: fitted[0])[1]


def identify_record(record: ForeignRecord) -> LinearModel:
    """Return the constants of a recording with their deviations and doubts.

    The command is taken as held for each step where that fits clearly better than a continuous one.
    Raises `CamtoolsError`: the command moves in too little of the record, or too few lines are
    coherent.
    """
    segments, lines, values = _held_or_not(record)
    blocks = np.array_split(np.arange(segments.u.shape[0]), _N_BLOCKS)
    replicas, (small, large) = _replicas(segments, blocks, values), _halves(segments, values)
    off = np.abs(response_of(values, lines.s, lines.hold_s) / lines.response - 1)
    misfit = float(np.sqrt(np.mean(off**2)))
    chi = float(np.sqrt(np.mean((off / np.hypot(lines.noise, _LIKENESS)) ** 2)))
    found = LinearModel(values, replicas, lines, misfit, chi, small, large, [])
    return found._replace(problems=_problems(found) + _distortion(record, segments, values))


def _terms(record: ForeignRecord, values: Floats, hold_s: float) -> dict[str, Floats]:
    """Return terms of the command that a drive may have and a linear model has not."""
    s = np.asarray(2j * np.pi * np.fft.rfftfreq(record.u.size, 1 / record.rate_hz))[1:]
    spectrum = np.fft.rfft(record.u)[1:] * response_of(values, s, hold_s)
    terms = (np.fft.irfft(np.append(0, spectrum * s**i), record.u.size) for i in range(3))
    (position, speed, acceleration), command = terms, record.u - record.u.mean()
    return {
        "friction": np.sign(speed),
        "friction, or clipping of the speed,": speed**3,
        "a square term of the command, a drive that is not symmetrical,": command**2,
        "a square term of the position, a drive that is not symmetrical,": position**2,
        "clipping, or a cubic term of the command,": command**3,
        "clipping, or a cubic term of the position,": position**3,
        "clipping, or a cubic term of the acceleration,": acceleration**3,
    }


def _rest(y: Complexes, u: Complexes) -> Complexes:
    """Return what of y no linear response to u explains."""
    share = np.sum(y * u.conj(), axis=0) / np.maximum(np.sum(np.abs(u) ** 2, axis=0), 1e-300)
    return np.asarray(y - share * u)


def _distortion(record: ForeignRecord, segments: _Segments, values: Floats) -> list[str]:
    """Return the nonlinear term that explains most, MATHS.md (226)."""
    response = response_of(values, segments.s, segments.hold_s)
    rest = _rest(segments.y, segments.u)
    noise = np.maximum(np.mean(np.abs(rest) ** 2, axis=0), 1e-300)
    power = float(np.sum(np.abs(segments.u) ** 2))
    found = []
    for name, term in _terms(record, values, segments.hold_s).items():
        part = _rest(_transforms(term), segments.u)
        moved = part * response
        size = max(float(np.sum(np.abs(moved) ** 2 / noise)), 1e-300)
        factor = abs(float(np.sum((rest * moved.conj()).real / noise))) / size
        unit = 100 * np.sqrt(float(np.sum(np.abs(part) ** 2)) / power)
        sigma = (2 * _FREE * size) ** -0.5
        found.append((factor / sigma, factor * unit, sigma * unit, name))
    sigmas, percent, sigma, name = max(found)
    if sigmas <= _CHANGE_SIGMAS or percent <= 100 * _MOST_DISTORTION:
        return []
    return [
        f"{name} acts like {percent:.3g} % of the command, deviation {sigma:.2g} %; at most "
        f"{100 * _MOST_DISTORTION:g} % or {_CHANGE_SIGMAS:g} deviations"
    ]


def _problems(found: LinearModel) -> list[str]:
    problems = []
    if found.misfit > _MOST_MISFIT and found.chi > _MOST_CHI:
        problems.append(
            f"the model leaves {100 * found.misfit:.3g} % of the response, {found.chi:.3g} times "
            f"its deviations; at most {100 * _MOST_MISFIT:g} % or {_MOST_CHI:g} times"
        )
    width_hz = float(found.values[RATE] / found.values[SECOND]) / (2 * np.pi)
    line_hz = float(np.abs(np.diff(found.lines.s)).min()) / (2 * np.pi)
    is_ringing = found.values[STATIC] / found.values[SECOND] > (np.pi * width_hz) ** 2
    if is_ringing and abs(width_hz) < _LINES_PER_WIDTH * line_hz:
        problems.append(
            f"the resonance is {abs(width_hz):.3g} Hz wide, but lines are {line_hz:.3g} Hz apart, "
            f"at most {abs(width_hz) / _LINES_PER_WIDTH:.3g} Hz; record for longer or more slowly"
        )
    for name, i in (("static term", STATIC), ("second-order term", SECOND)):
        change = float(found.large.values[i] / found.small.values[i] - 1)
        sigma = float(np.hypot(found.small.sigmas[i], found.large.sigmas[i]))
        sigma /= abs(float(found.small.values[i]))
        if abs(change) > max(_MOST_CHANGE, _CHANGE_SIGMAS * sigma):
            problems.append(
                f"the {name} is {100 * change:+.3g} % off in the half of the record with the "
                f"larger motion, deviation {100 * sigma:.2g} %; at most {100 * _MOST_CHANGE:g} % "
                f"or {_CHANGE_SIGMAS:g} deviations"
            )
    return problems


_NS, _US2, _UM = 1e9, 1e12, 1e6  # per s, s2 and m


def constants_of(values: Floats, command: str) -> dict[str, float]:
    """Return constants, as of `LinearModel`, by name and unit; the command's column chooses.

    Without natural frequency and damping where mass and spring have not one sign, or either is 0.
    """
    static, rate, second, delay_s = (float(values[i]) for i in (STATIC, RATE, SECOND, DELAY))
    shape = {"delay ns": delay_s * _NS}
    if static * second > 0:
        ringing = (static / second) ** 0.5  # rad/s
        shape["natural frequency Hz"] = ringing / (2 * np.pi)
        shape["damping"] = rate / (2 * second * ringing)
    if command in FORCES:
        return {"mass kg": second, "viscous N s/m": rate, "stiffness N/m": static} | shape
    gain, unit = (_UM / static, "um/V") if command == "command_v" else (1 / static, "")
    drive = {"k1 ns": rate / static * _NS, "k2 us2": second / static * _US2}
    return {f"gain {unit}".strip(): gain} | drive | shape


def _uncertain(found: LinearModel, command: str) -> list[tuple[str, float, float]]:
    """Return name, value and deviation of the constants that the record has without any block."""
    constants = constants_of(found.values, command)
    rows = [constants_of(replica, command) for replica in found.replicas]
    names = [name for name in constants if all(name in row for row in rows)]
    sigmas = jackknife(np.array([[row[name] for name in names] for row in rows]))
    return [
        (name, constants[name], sigma) for name, sigma in zip(names, sigmas.tolist(), strict=True)
    ]


def record_lines(found: LinearModel, record: ForeignRecord) -> Iterator[str]:
    """Yield the report, line by line."""
    hz = np.abs(found.lines.s) / (2 * np.pi)
    coherence = found.lines.coherence
    held = "held for each step" if found.lines.hold_s else "continuous"
    yield (
        f"record: {record.u.size} rows at {record.rate_hz:.6g} Hz; command {held}; {hz.size} lines "
        f"{hz[0]:.3g} .. {hz[-1]:.4g} Hz, coherence {np.median(coherence):.4g} in the median, "
        f"{coherence.min():.3g} at least"
    )
    yield f"{'':<22}{'found':>14}{'deviation':>12}"
    for name, value, sigma in _uncertain(found, record.command):
        yield f"{name:<22}{value:>14.6g}{sigma:>12.2g}"
    yield f"misfit {100 * found.misfit:.3g} %, {found.chi:.3g} times the deviations of the lines"
    yield from (f"a linear model does not hold: {problem}" for problem in found.problems)


def record_numbers(found: LinearModel, record: ForeignRecord) -> Json:
    """Return the report for other programs."""
    return {
        "constants": {
            name: {"found": value, "deviation": sigma}
            for name, value, sigma in _uncertain(found, record.command)
        },
        "command_hold_s": found.lines.hold_s,
        "lines": int(found.lines.s.size),
        "coherence_median": float(np.median(found.lines.coherence)),
        "misfit": found.misfit,
        "misfit_deviations": found.chi,
        "problems": found.problems,
    }
