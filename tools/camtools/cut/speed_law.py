"""The spindle's speed over its angle that keeps the removal rate even, within the machine's limits.

With r = speed / mean speed and b = r^2 everything the machine limits is linear: the spindle's
acceleration is mean^2 b'/2, that of U mean^2 (delta'' b + delta' b'/2), the square of the removal
rate A'^2 b. Only the mean speed is not: the integral of b^(-1/2) is convex, so planes cut it off.
The law of least ripple is thus found by a few linear programs, MATHS.md (27),
(28). Partial modulation, MATHS.md (26), blends uniform and full modulation in time.

>>> phi = np.pi * np.arange(N_GRID) / N_GRID
>>> load = Load(1 + np.cos(2 * phi) / 3, np.sin(2 * phi) / 10, np.cos(2 * phi) / 5, np.pi)
>>> law = full(load)
>>> f"{law.ripple:.6f} {law.ratio(0.0):.6f}"
'0.000000 0.750000'
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import linprog

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, FloatsLike
from camtools.base.solvers import unsolved

N_GRID = 512  # places of a pattern at which limits are watched
MIN_RATIO, MAX_RATIO = 0.25, 4.0  # slower is no use to a piston; what a table holds
MAX_BEND = 9.9  # of |r r'|, per rad: a table holds up to 10
_MARGIN = 0.996  # of every limit: the places between the grid, and the table's own error
_SET_POINT_MARGIN = 0.992  # the controller judges them by chords
_N_CONTROL = 32  # control points of a pattern
_SMOOTHNESS = 1e-4  # weight of the second differences, so that neighbouring heights agree
_MAX_CUTS, _MEAN_ERROR = 40, 1e-7
_BISECTIONS = 40


class Load(NamedTuple):
    """One section on N_GRID equally spaced angles of its pattern."""

    area_mm2: Floats  # A' = (blank^2 - rho^2) / 2, per rad
    d1_mm: Floats  # delta', per rad
    d2_mm: Floats  # delta'', per rad^2
    pattern_rad: float  # length of the pattern


class SpeedLimits(NamedTuple):
    """What spindle and U can do."""

    alpha_rad_s2: float
    spindle_rad_s: float
    u_speed_mm_s: float
    u_acceleration_mm_s2: float
    bandwidth_rad_s: float = np.inf  # of the speed loop


class InfeasibleError(CamtoolsError):
    """Even uniform speed is beyond a limit."""


@dataclass(frozen=True, eq=False)
class Law:
    """A speed law of one section."""

    spline: BSpline  # r over the angle [rad], periodic
    load: Load  # of the section
    share: float  # lambda of MATHS.md (26) for partial modulation; 1 full, 0 uniform, NaN optimised

    def ratio(self, phi_rad: FloatsLike, derivative: int = 0) -> Floats:
        """Return r, r' or r'' at angles [rad]."""
        return np.asarray(self.spline(phi_rad, nu=derivative), dtype=np.float64)

    @property
    def rate(self) -> Floats:
        """Return the removal rate over its mean at the grid of the load."""
        phi = grid_rad(self.load)
        rate = self.load.area_mm2 * self.ratio(phi) / self.load.area_mm2.mean()
        return np.asarray(rate, dtype=np.float64)

    @property
    def ripple(self) -> float:
        """Return (largest - least) / mean of the removal rate; the mean is over time."""
        return float(np.ptp(self.rate))

    @property
    def peaks(self) -> tuple[float, float, float, float]:
        """Return peaks of |r r'|, r, |delta' r| and |delta'' r^2 + delta' r r'|."""
        phi, load = grid_rad(self.load), self.load
        r, r1 = self.ratio(phi), self.ratio(phi, 1)
        motion = load.d2_mm * r**2 + load.d1_mm * r * r1
        found = (np.abs(r * r1), r, np.abs(load.d1_mm * r), np.abs(motion))
        return tuple(float(values.max()) for values in found)  # type: ignore[return-value]

    def set_points(self, lag_rad: float) -> Floats:
        """Return the set-points that a speed loop needs, over the mean speed, MATHS.md (80).

        The lag is the mean speed over the bandwidth of the loop.
        """
        phi = grid_rad(self.load)
        r = self.ratio(phi)
        return np.asarray(r + lag_rad * r * self.ratio(phi, 1), dtype=np.float64)

    @property
    def fall(self) -> float:
        """Return the largest -r' [1/rad]: the bandwidth that a loop needs, over the mean speed."""
        return float(np.max(-self.ratio(grid_rad(self.load), 1)))


def grid_rad(load: Load) -> Floats:
    """Return the angles of a load's grid."""
    n = load.area_mm2.size
    return np.asarray(load.pattern_rad * np.arange(n) / n, dtype=np.float64)


def _law(load: Load, ratio: Floats, share: float) -> Law:
    """Return the law through ratios on the grid, its mean speed made exact."""
    exact = ratio * float(np.mean(1 / ratio))
    return Law(periodic_quintic(exact, load.pattern_rad), load, share)


def periodic_quintic(y: Floats, length: float) -> BSpline:
    """Return the periodic quintic spline through values at equal distances.

    Its coefficients solve a circulant system, so the Fourier transform does in no time what a
    general solver does in 20 ms, and a part takes a thousand of them.
    """
    n, k = y.size, 5
    wave = 2 * np.pi * np.arange(n // 2 + 1) / n
    at_knots = (66 + 52 * np.cos(wave) + 2 * np.cos(2 * wave)) / 120  # of one B-spline
    middle = np.fft.irfft(np.fft.rfft(y) / at_knots, n)
    knots = length / n * np.arange(-k, n + k + 1)
    return BSpline(knots, middle[np.arange(-2, n + 3) % n], k, extrapolate="periodic")


def partial(load: Load, share: float) -> Law:
    """Return 1/omega = (1 - share)/omega_m + share/omega_full, MATHS.md (26)."""
    return _law(load, 1 / (1 - share + share * load.area_mm2 / load.area_mm2.mean()), share)


def full(load: Load) -> Law:
    """Return the law of constant removal rate, whatever the machine can do, MATHS.md (24)."""
    return partial(load, 1.0)


def uniform(load: Load) -> Law:
    """Return the law of constant speed."""
    return partial(load, 0.0)


def _most_alpha_rad_s2(limits: SpeedLimits, mean_rad_s: float) -> float:
    """Return the highest acceleration that the spindle has and a table holds."""
    return min(limits.alpha_rad_s2, MAX_BEND * mean_rad_s**2)


def excess(law: Law, limits: SpeedLimits, mean_rad_s: float) -> dict[str, float]:
    """Return needed over limit, above 1 where a law breaks it, by name of the limit."""
    alpha, ratio, speed, motion = law.peaks
    set_points = law.set_points(mean_rad_s / limits.bandwidth_rad_s)
    commanded = float(set_points.max()) * _MARGIN / _SET_POINT_MARGIN
    return {
        "spindle_acceleration_rad_s2": alpha
        * mean_rad_s**2
        / _most_alpha_rad_s2(limits, mean_rad_s),
        "spindle_bandwidth_rad_s": law.fall * mean_rad_s / limits.bandwidth_rad_s,
        "spindle_rpm": max(ratio, commanded) * mean_rad_s / limits.spindle_rad_s,
        "u_speed_mm_s": speed * mean_rad_s / limits.u_speed_mm_s,
        "u_acceleration_mm_s2": motion * mean_rad_s**2 / limits.u_acceleration_mm_s2,
    }


def _keeps(law: Law, limits: SpeedLimits, mean_rad_s: float) -> bool:
    r = law.ratio(grid_rad(law.load))
    in_table = r.min() >= MIN_RATIO and r.max() <= MAX_RATIO
    return bool(in_table) and max(excess(law, limits, mean_rad_s).values()) <= _MARGIN


def _check_uniform(load: Load, limits: SpeedLimits, mean_rad_s: float) -> None:
    worst = excess(uniform(load), limits, mean_rad_s)
    name = max(worst, key=lambda limit: worst[limit])
    if worst[name] > 1:
        rpm = mean_rad_s * 60 / (2 * np.pi)
        problem = f"needs {worst[name]:.4g} times the limit even at a uniform {rpm:g} r/min"
        raise InfeasibleError([f"machine.limits.{name}: {problem}; turn more slowly"])


def largest_partial(load: Load, limits: SpeedLimits, mean_rad_s: float) -> Law:
    """Return the partial modulation of the largest share within the limits.

    Raises InfeasibleError where uniform speed breaks a limit already.
    """
    _check_uniform(load, limits, mean_rad_s)
    if _keeps(full(load), limits, mean_rad_s):
        return full(load)
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        is_kept = _keeps(partial(load, middle), limits, mean_rad_s)
        low, high = (middle, high) if is_kept else (low, middle)
    return partial(load, low)


class _Program:
    """The linear program of one section: rows that do not change, and the cuts."""

    def __init__(self, load: Load, limits: SpeedLimits, mean_rad_s: float) -> None:
        self.load, self.mean = load, mean_rad_s
        self.value, slope, self.second = _basis(load)
        area2 = (load.area_mm2 / load.area_mm2.mean()) ** 2
        n_c, n_s = self.value.shape[1], self.second.shape[0]
        self.n = n_c + 2 + n_s  # control points, lo, hi, magnitudes of second differences
        alpha = 2 * _MARGIN * _most_alpha_rad_s2(limits, mean_rad_s) / mean_rad_s**2
        motion = load.d2_mm[:, None] * self.value + load.d1_mm[:, None] * slope / 2
        most = _MARGIN * limits.u_acceleration_mm_s2 / mean_rad_s**2
        rows = load.area_mm2.size
        ones, zeros = np.ones((rows, 1)), np.zeros((rows, 1))
        rate = area2[:, None] * self.value
        # Factors of the control points, of lo and of hi; bound.
        blocks: list[tuple[Floats, Floats, Floats, Floats | float]] = [
            (rate, zeros, -ones, 0.0),
            (-rate, ones, zeros, 0.0),
            (slope, zeros, zeros, alpha),
            (-slope, zeros, zeros, alpha),
            (motion, zeros, zeros, most),
            (-motion, zeros, zeros, most),
            (self.value, zeros, zeros, self._highest(limits)),
            (-self.value, zeros, zeros, -(MIN_RATIO**2)),
        ]
        self.slope, self.limits = slope, limits
        rest = np.zeros((rows, n_s))
        a = [np.hstack([of_c, of_lo, of_hi, rest]) for of_c, of_lo, of_hi, _ in blocks]
        a += [np.hstack([s * self.second, np.zeros((n_s, 2)), -np.eye(n_s)]) for s in (1, -1)]
        self.a = np.vstack(a)
        bounds = [np.broadcast_to(bound, rows) for _, _, _, bound in blocks]
        self.b = np.concatenate([*bounds, np.zeros(2 * n_s)])
        self.cost = np.zeros(self.n)
        self.cost[n_c : n_c + 2] = -1, 1
        self.cost[n_c + 2 :] = _SMOOTHNESS

    def _highest(self, limits: SpeedLimits) -> Floats:
        """Return the largest b that spindle speed, speed of U and the table allow."""
        with np.errstate(divide="ignore"):
            by_u = limits.u_speed_mm_s / (np.abs(self.load.d1_mm) * self.mean)
        by_spindle = min(MAX_RATIO, limits.spindle_rad_s / self.mean)
        return (_MARGIN * np.minimum(by_u, by_spindle)) ** 2

    def cut(self, square: Floats) -> None:
        """Add the plane that touches the mean-speed condition at b."""
        weight = square**-1.5 / (2 * square.size)
        row = np.zeros(self.n)
        row[: self.value.shape[1]] = -(weight @ self.value)
        self.a = np.vstack([self.a, row])
        self.b = np.append(self.b, 1 - 3 * float(np.mean(square**-0.5)) / 2)

    def _loop(self, square: Floats) -> tuple[Floats, Floats]:
        """Return rows of the speed loop, MATHS.md (81): r stands for its tangent at sqrt(b)."""
        per_rad = self.mean / self.limits.bandwidth_rad_s
        half, bend = np.sqrt(square) / 2, per_rad * self.slope / 2
        tangent = self.value / (4 * half[:, None])
        highest = _SET_POINT_MARGIN * self.limits.spindle_rad_s / self.mean
        rows = np.vstack([-bend - _MARGIN * tangent, bend + tangent])
        bounds = np.concatenate([_MARGIN * half, highest - half])
        return np.pad(rows, ((0, 0), (0, self.n - rows.shape[1]))), bounds

    def solve(self, square: Floats) -> Floats | None:
        """Return b on the grid from that before, nothing when no law keeps the limits."""
        a, b = self.a, self.b
        if np.isfinite(self.limits.bandwidth_rad_s):
            rows, bounds = self._loop(square)
            a, b = np.vstack([a, rows]), np.append(b, bounds)
        found = linprog(self.cost, A_ub=a, b_ub=b, bounds=[(None, None)] * self.n, method="highs")
        if found.status != 0:
            return None
        return np.asarray(self.value @ found.x[: self.value.shape[1]], dtype=np.float64)


def _basis(load: Load) -> tuple[Floats, Floats, Floats]:
    """Return periodic quintic B-splines on the grid, their slopes, and second differences.

    Columns of mirror images are joined when the load is its own mirror image.
    """
    n, step = _N_CONTROL, load.pattern_rad / _N_CONTROL
    place = grid_rad(load) / step
    base = BSpline.basis_element(np.arange(-3.0, 4.0), extrapolate=False)
    value, slope = np.zeros((place.size, n)), np.zeros((place.size, n))
    for i in range(n):
        off = np.mod(place - i + n / 2, n) - n / 2
        value[:, i] = np.nan_to_num(base(off))
        slope[:, i] = np.nan_to_num(base.derivative()(off)) / step
    eye = np.eye(n)
    second = np.roll(eye, 1, axis=1) - 2 * eye + np.roll(eye, -1, axis=1)
    area = load.area_mm2
    if np.allclose(area[1:], area[:0:-1], rtol=1e-9, atol=0):  # mirrored
        fold = np.zeros((n, n // 2 + 1))
        fold[np.arange(n), np.minimum(np.arange(n), n - np.arange(n))] = 1
        value, slope, second = value @ fold, slope @ fold, (second @ fold)[: n // 2 + 1]
    return value, slope, second


def optimise(load: Load, limits: SpeedLimits, mean_rad_s: float) -> Law:
    """Return the law of least ripple of the removal rate within the limits.

    The mean speed of a turn is kept exactly. Raises InfeasibleError as `largest_partial`.
    """
    fallback = largest_partial(load, limits, mean_rad_s)
    if fallback.share == 1:
        return fallback
    program, square = _Program(load, limits, mean_rad_s), np.ones(load.area_mm2.size)
    for _ in range(_MAX_CUTS):
        program.cut(square)
        found = program.solve(square)
        if found is None:
            return fallback
        square = np.maximum(found, MIN_RATIO**2)
        if np.mean(square**-0.5) <= 1 + _MEAN_ERROR:
            break
    else:
        raise unsolved("process.speed: law of least ripple")
    law = _law(load, np.sqrt(square), float("nan"))
    is_better = law.ripple < fallback.ripple and max(excess(law, limits, mean_rad_s).values()) <= 1
    return law if is_better else fallback


def full_mean_rad_s(load: Load, limits: SpeedLimits) -> float:
    """Return the highest mean speed at which the rate can be kept constant [rad/s]."""
    law, low, high = full(load), 0.0, limits.spindle_rad_s
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        is_kept = max(excess(law, limits, middle).values()) <= 1
        low, high = (middle, high) if is_kept else (low, middle)
    return low
