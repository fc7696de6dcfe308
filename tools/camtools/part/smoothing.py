"""The smoothest values within a band around listed ones, how much noise a list has, and in words.

A list of rounded numbers has steps that its curve should not have. All values may move within the
band; the smallest third derivative decides where they go, MATHS.md (220).

>>> x = np.arange(40.0)
>>> listed = np.round(0.02 * x**2, 1)
>>> found = smoothed(x, listed, 0.05)
>>> bool(np.abs(found - listed).max() <= 0.05), f"{np.abs(np.diff(found, 3)).max():.4f}"
(True, '0.0000')
"""

from collections.abc import Callable
from typing import Annotated, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats, plain_number, rounded_up
from camtools.base.solvers import unsolved
from camtools.base.text import Json

LEAST_UM, MOST_UM = 0.001, 50.0
SmoothUm = Annotated[float, Field(ge=LEAST_UM, le=MOST_UM)]

T = TypeVar("T")

ORDER = 3  # of the derivative that is least
_MOST_STEPS = 200
_CENTRING, _STAY_INSIDE = 0.1, 0.95  # of a step of the interior-point method
_GAP = 1e-9  # of the largest gradient, or of itself where that vanishes within the bounds
_NOISE_ORDER = 6  # differences in which nothing of a smooth curve is left
_NORMAL_MEDIAN = 0.6745  # of |noise| over its standard deviation
_LEAST_ROWS = 12
_WORTH = 0.95  # of a peak: what smoothing must lower it to


def differences(x: Floats, order: int, period: float | None = None) -> csr_array:
    """Return the matrix of the divided differences of values at rising x, times order factorial.

    Where values repeat after a period every point begins a difference.
    """
    n = x.size
    n_rows = n if period else n - order
    places = np.arange(n_rows)[:, None] + np.arange(order + 1)
    at = x[places % n] + (period or 0.0) * (places // n)
    gaps = at[:, :, None] - at[:, None, :] + np.eye(order + 1)
    weights = np.prod(np.arange(1, order + 1)) / np.prod(gaps, axis=2)
    rows = np.repeat(np.arange(n_rows), order + 1)
    return csr_array((weights.ravel(), (rows, (places % n).ravel())), shape=(n_rows, n))


def smoothed(
    x: Floats,
    values: Floats,
    band: float,
    *,
    period: float | None = None,
    held: npt.NDArray[np.bool_] | None = None,
) -> Floats:
    """Return the values, none below 0, within a band whose third derivative is least.

    After a period values repeat; held ones do not move.
    """
    free = np.arange(x.size) if held is None else np.flatnonzero(~held)
    if x.size <= ORDER or not free.size:
        return values.copy()
    low, high = np.maximum(values[free] - band, 0.0), values[free] + band
    start = values.copy()
    start[free] = (low + high) / 2
    matrix = differences((x - x[0]) / np.ptp(x), ORDER, period and period / float(np.ptp(x)))
    inside = _least_in_box(matrix[:, free] @ diags_array((high - low) / 2), matrix @ start)
    found = start.copy()
    found[free] += inside * (high - low) / 2
    return found


def _least_in_box(matrix: csr_array, start: Floats) -> Floats:
    """Return r within -1 .. 1 for which |start + matrix r| is least: primal-dual interior point."""
    scale = np.sqrt((matrix * matrix).sum(axis=0).max()) or 1.0
    hessian = ((matrix.T @ matrix) / scale**2).tocsc()
    slope = matrix.T @ start / scale**2
    r = np.zeros(hessian.shape[0])
    lower, upper = np.ones(r.size), np.ones(r.size)  # multipliers of both bounds
    for _ in range(_MOST_STEPS):
        gradient, gap = hessian @ r + slope, (lower @ (1 + r) + upper @ (1 - r)) / (2 * r.size)
        if gap <= _GAP * max(_GAP, float(np.abs(gradient).max())):
            return np.asarray(r, dtype=np.float64)
        low, high = _CENTRING * gap / (1 + r), _CENTRING * gap / (1 - r)
        stiff = lower / (1 + r), upper / (1 - r)
        step = spsolve(hessian + diags_array(sum(stiff), format="csc"), low - high - gradient)
        d_lower, d_upper = low - lower - stiff[0] * step, high - upper + stiff[1] * step
        share = _share_inside(np.append(1 + r, 1 - r), np.append(step, -step))
        others = _share_inside(np.append(lower, upper), np.append(d_lower, d_upper))
        r, lower, upper = r + share * step, lower + others * d_lower, upper + others * d_upper
    raise unsolved("smooth_um")


def _share_inside(room: Floats, step: Floats) -> float:
    """Return the share of a step, at most 1, which leaves all of some positive numbers positive."""
    falling = step < 0
    return float(min(1.0, _STAY_INSIDE * (room[falling] / -step[falling]).min(initial=np.inf)))


def noise_of(x: Floats, values: Floats, period: float | None = None) -> float:
    """Return half the width of evenly spread noise in smooth values, MATHS.md (221).

    Rounding to steps of q has q / 2. Differences that touch a value of 0 are left out; 0 where too
    few are left to judge.
    """
    if x.size < _NOISE_ORDER + _LEAST_ROWS:
        return 0.0
    matrix = differences(x, _NOISE_ORDER, period)
    counted = (abs(matrix) @ (values <= 0)) == 0
    if np.count_nonzero(counted) < _LEAST_ROWS:
        return 0.0
    size = np.sqrt((matrix * matrix).sum(axis=1))
    deviation = np.median(np.abs((matrix @ values) / size)[counted]) / _NORMAL_MEDIAN
    return float(np.sqrt(3) * deviation)


def bands_um(x: Floats, values_mm: Floats, period: float | None = None) -> list[float]:
    """Return bands [um] that may remove the noise of values, rising; none without noise."""
    noise_um = noise_of(x, values_mm, period) * UM_PER_MM
    if noise_um < LEAST_UM:
        return []
    return [band_um for k in (1, 2, 4) if (band_um := rounded_up(noise_um * k)) <= MOST_UM]


def first_enough(
    bands: list[float], smooth: Callable[[float], T], peaks: Callable[[T], tuple[float, float]]
) -> T | None:
    """Return values smoothed within the narrowest of rising bands after which none lowers peaks."""
    found, least = None, np.inf
    for band_um in bands:
        values = smooth(band_um)
        before, after = peaks(values)
        least = before if found is None else least
        if after >= _WORTH * least:
            break
        found, least = values, after
    return found


_NOTHING_UM = 1e-5  # a residual below it is the rounding of the solver
_RISEN = 1 + 1e-3  # of a peak: more than numerical noise


class PeakChange(NamedTuple):
    """The largest magnitude of a derivative before and after smoothing."""

    name: str
    before: float
    after: float
    unit: str

    @property
    def text(self) -> str:
        """Return it in words."""
        return f"largest {self.name} from {self.before:.4g} to {self.after:.4g} {self.unit}"


def residuals(band_um: float, off_um: Floats, places: Floats, key: str) -> Json:
    """Return the residuals of smoothed points as data; `key` names the place of the largest."""
    worst = int(np.abs(off_um).argmax())
    return {
        "smooth_um": band_um,
        "largest_um": abs(float(off_um[worst])),
        key: float(places[worst]),
        "rms_um": float(np.sqrt(np.mean(off_um**2))),
    }


def smoothed_texts(what: str, facts: Json, place: str, peaks: list[PeakChange]) -> list[str]:
    """Return what smoothing did as lines, from `residuals`; the second derivative peaks first."""
    within = f"{what} smoothed within {facts['smooth_um']:g} um"
    if facts["largest_um"] < _NOTHING_UM:
        return [f"{within}: nothing changes, because its points are smooth already"]
    largest, rms = plain_number(facts["largest_um"]), plain_number(facts["rms_um"])
    changes = ", ".join(change.text for change in peaks)
    lines = [f"{within}: largest residual {largest} um at {place}, rms {rms} um; {changes}"]
    bend = peaks[0]
    if bend.after > _RISEN * bend.before:
        lines.append(
            f"warning: smoothing raises the largest {bend.name} of the {what}; remove smooth_um, "
            "or change it until the value falls"
        )
    return lines


def noise_text(what: str, remedy: str, peaks: list[PeakChange]) -> str:
    """Return the warning of points that should be smoothed."""
    changes = ", ".join(change.text for change in peaks)
    return f"warning: the {what} is noisy or rounded coarsely: {remedy} would change {changes}"


def band_words(band_um: float, taken_um: float, form_error_um: float) -> str:
    """Return the keys that smooth points within a band, with a tolerance that it leaves room in."""
    allowed_um = form_error_for(taken_um, form_error_um)
    more = "" if allowed_um == form_error_um else f" with process.form_error_um = {allowed_um:g}"
    return f"smooth_um = {band_um:g}{more}"


def form_error_for(taken_um: float, form_error_um: float) -> float:
    """Return the form error, or twice what smoothing takes where it takes all of it."""
    return form_error_um if taken_um < form_error_um else rounded_up(2 * taken_um)


def share_text(taken_um: float, form_error_um: float) -> str:
    """Return how much of the tolerance smoothing takes."""
    taken = plain_number(taken_um)
    return f"smoothing takes {taken} um of the tolerance of {plain_number(form_error_um)} um"


def sheet_note(form: Json, taken_um: float) -> str:
    """Return what the sheets of a part with smoothed points must state, nothing of others."""
    if taken_um == 0:
        return ""
    share = share_text(taken_um, form["tolerance"] + taken_um)
    return f"the drawing is that with smoothed points; {share}, and so much less is accepted here"


def check_share(field: str, taken_um: float, form_error_um: float) -> None:
    """Refuse smoothing that leaves nothing of the tolerance; `field`: path of smooth_um."""
    if taken_um and taken_um >= form_error_um:
        problem = (
            f"smoothing moves the surface by up to {plain_number(taken_um)} um, which leaves "
            f"nothing of process.form_error_um = {form_error_um:g}"
        )
        remedy = f"reduce smooth_um, or set process.form_error_um above {rounded_up(taken_um):g}"
        raise GeometryError(field, problem, remedy)
