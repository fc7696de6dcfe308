"""Charts of the following error over the angle, the last turns over each other.

A chart has a series for each few turns. An update tells only the series that got samples since the
last one, so that what is sent stays small however many samples are shown.

>>> turns = Ticks(np.array([7, 7]), np.array([0.25, 0.5]), np.array([0.1, -0.3]))
>>> Trail().changes(turns)[0]
Series(slot=1, age=0, points=[[90.0, 0.1], [180.0, -0.3]])
>>> whole(POLAR, 0.2, 5.0)["radiusAxis"][0]["axisLabel"]["showMaxLabel"]
False
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, isfinite, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from camtools.base.quantities import Floats
from camtools.panel.views.echart import INK, RED, text_style

Whole = npt.NDArray[np.int64]
SHOWN_TURNS = 50
TURNS_PER_SERIES = 5
SLOTS = SHOWN_TURNS // TURNS_PER_SERIES + 1  # the oldest and the newest of them are not whole
MOST_POINTS = 600  # of a series
BINS = 72  # of the mean over the angle: 5 degrees each
_WIDE_BINS = 6  # a gap that no line may cross
_DEG = 360.0
Points = list[list[float]]


@dataclass(frozen=True)
class Ticks:
    """Single ticks; arrays of the same length, in the order of time."""

    turn: Whole  # whole turns, rising from each enable on
    angle_turn: Floats  # drawing's angle [turn], 0 .. 1
    error_um: Floats  # following error of U in the same tick [um]


@dataclass(frozen=True)
class Series:
    """A series that changes."""

    slot: int  # its number in the chart, 0 .. SLOTS - 1
    age: int  # 0 is the newest
    points: Points | None  # angle [degrees] and error [um]; None: those of before stay


@dataclass(frozen=True)
class Statistics:
    """Of all samples that are shown."""

    max_um: float
    rms_um: float
    turns: int
    samples: int


def recent(samples: Ticks) -> Ticks:
    """Return the samples of the last SHOWN_TURNS turns since the count of turns began anew."""
    if not len(samples.turn):
        return samples
    is_shown = samples.turn > samples.turn[-1] - SHOWN_TURNS
    falls = np.flatnonzero(np.diff(samples.turn) < -1)  # by 1 also where a spindle turns back
    if len(falls):
        is_shown[: falls[-1] + 1] = False
    return Ticks(samples.turn[is_shown], samples.angle_turn[is_shown], samples.error_um[is_shown])


def statistics(samples: Ticks) -> Statistics:
    """Return the statistics of samples; nan where there are none."""
    if not len(samples.turn):
        return Statistics(float("nan"), float("nan"), 0, 0)
    error_um = samples.error_um
    return Statistics(
        float(np.max(np.abs(error_um))),
        float(np.sqrt(np.mean(error_um**2))),
        int(samples.turn[-1] - samples.turn[0]) + 1,
        len(error_um),
    )


def mean_by_angle(samples: Ticks) -> list[list[float | None]]:
    """Return angle [degrees] and mean error [um] of each of BINS parts of a turn that was seen.

    None stands where a wide part was not; a line may join parts over narrow ones without a sample.
    """
    which = np.minimum((samples.angle_turn * BINS).astype(np.int64), BINS - 1)
    n = np.bincount(which, minlength=BINS)
    total = np.bincount(which, weights=samples.error_um, minlength=BINS)
    width_deg = _DEG / BINS
    means = [round(float(t / k), 4) if k else None for t, k in zip(total, n, strict=True)]
    told: list[list[float | None]] = []
    last = -1
    for i, mean in enumerate(means):
        if mean is not None:
            told += [[i * width_deg, None]] if i - last > _WIDE_BINS else []
            told.append([(i + 0.5) * width_deg, mean])
            last = i
    return told


def _points(samples: Ticks, is_in: npt.NDArray[np.bool_]) -> Points:
    """Return the points of a series, thinned evenly where there are too many."""
    angle = np.round(samples.angle_turn[is_in] * _DEG, 1)
    error = np.round(samples.error_um[is_in], 3)
    stride = -(-len(angle) // MOST_POINTS) if len(angle) else 1
    pairs: Points = np.column_stack((angle, error))[::stride].tolist()
    return pairs


class Trail:
    """What one chart has been told."""

    def __init__(self) -> None:
        self._told: dict[int, tuple[int, tuple[int, float] | None, int]] = {}

    def changes(self, samples: Ticks) -> list[Series]:
        """Return the series that differ from what the chart was told last."""
        shown = recent(samples)
        groups = shown.turn // TURNS_PER_SERIES
        newest = int(groups[-1]) if len(groups) else 0
        there = {int(group): groups == group for group in np.unique(groups)}
        changed = [
            series
            for group, is_in in there.items()
            if (series := self._series(shown, group, newest - group, is_in)) is not None
        ]
        taken = {group % SLOTS for group in there}
        for slot in sorted(self._told.keys() - taken):
            del self._told[slot]
            changed.append(Series(slot, SLOTS - 1, []))
        return changed

    def _series(
        self, shown: Ticks, group: int, age: int, is_in: npt.NDArray[np.bool_]
    ) -> Series | None:
        last = int(np.flatnonzero(is_in)[-1])
        mark = (int(shown.turn[last]), float(shown.angle_turn[last]))
        slot = group % SLOTS
        before = self._told.get(slot)
        if before == (group, mark, age):
            return None
        self._told[slot] = (group, mark, age)
        is_grown = before is None or before[:2] != (group, mark)
        return Series(slot, age, _points(shown, is_in) if is_grown else None)


UNROLLED, POLAR = "unrolled", "polar"
_FAINT, _DOTS, _NEWEST, _MEAN = "#c4ccd0", "#1565c0", "#0d47a1", "#bf360c"
_MEAN_ID, _LIMITS = "mean", ("limit-high", "limit-low")
_ANGLES = [float(angle) for angle in range(0, 361, 6)]
_QUARTER_DEG = 90
Option = dict[str, Any]
Means = Sequence[Sequence[float | None]]


def opacity(age: int) -> float:
    """Return how strongly a series is drawn: the older the fainter."""
    return round(max(0.06, 0.85 * 0.72**age), 3)


def _placed(kind: str, points: Points | Means) -> list[list[float | None]]:
    # In the order of the coordinate system: on a polar one the radius is first.
    return [[error, angle] if kind == POLAR else [angle, error] for angle, error in points]


def _series(kind: str, name: str, form: str, **more: Any) -> Option:  # noqa: ANN401
    system = "polar" if kind == POLAR else "cartesian2d"
    fixed = {"coordinateSystem": system, "silent": True, "data": []}
    return {"id": name, "type": form, **fixed, **more}


def _slot(kind: str, slot: int) -> Option:
    style = {"color": _DOTS, "opacity": opacity(slot)}
    large = {"symbolSize": 3, "large": True, "largeThreshold": 50}
    return _series(kind, f"turns-{slot}", "scatter", itemStyle=style, **large)


def _line(kind: str, name: str, colour: str, width: float, dash: str) -> Option:
    style = {"color": colour, "width": width, "type": dash}
    return _series(kind, name, "line", showSymbol=False, clip=True, lineStyle=style)


def _axis(low: float, high: float, interval: float, **label: Any) -> Option:  # noqa: ANN401
    return {
        "type": "value",
        "min": low,
        "max": high,
        "interval": interval,
        "axisLabel": text_style(13) | label,
        "splitLine": {"lineStyle": {"color": _FAINT}},
    }


def _system(kind: str, full_um: float) -> Option:
    """Return the axes; the drawing's angle counts counter-clockwise, seen from the headstock."""
    angles = _axis(0, 360, _QUARTER_DEG // 2, formatter="{value}°", hideOverlap=True)
    angles["axisLine"] = {"lineStyle": {"color": INK}}
    if kind == POLAR:
        # Its largest label would touch that of 0 degrees; the unrolled chart has the same scale.
        scale = _axis(-full_um, full_um, full_um / 2, showMaxLabel=False)
        zero = {"axisLine": {"show": False}, "axisTick": {"show": False}}
        return {
            "polar": [{"radius": "76%", "center": ["50%", "51%"]}],
            "angleAxis": [angles | {"startAngle": 0, "clockwise": False}],
            "radiusAxis": [scale | zero],
        }
    name = {"name": "following error / µm", "nameLocation": "middle", "nameGap": 48}
    scale = _axis(-full_um, full_um, full_um / 2) | name | {"nameTextStyle": text_style(13)}
    grid = {"left": 72, "right": 18, "top": 14, "bottom": 30}
    return {"grid": [grid], "xAxis": [angles], "yAxis": [scale]}


def _limits(kind: str, limit_um: float, full_um: float) -> list[Option]:
    """Return the lines of the tolerance, above and below; none where they are beyond the scale.

    A polar axis would show what is below its least value on the other side of the centre.
    """
    angles = _ANGLES if limit_um <= full_um else []
    return [
        {"id": name, "data": _placed(kind, [[angle, sign * limit_um] for angle in angles])}
        for name, sign in zip(_LIMITS, (1, -1), strict=True)
    ]


def whole(kind: str, full_um: float, limit_um: float) -> Option:
    """Return the options of an empty chart."""
    limits = [
        _line(kind, data["id"], RED, 1.5, "dashed") | data
        for data in _limits(kind, limit_um, full_um)
    ]
    mean = _line(kind, _MEAN_ID, _MEAN, 2.5, "solid")
    series = [*(_slot(kind, slot) for slot in range(SLOTS)), *limits, mean]
    return {"animation": False, **_system(kind, full_um), "series": series}


def change(
    kind: str, series: Sequence[Series], means: Means, scale_um: tuple[float, float] | None = None
) -> Option:
    """Return what an update sets: the data that are new, and the scale where it has changed.

    Without `means` the mean of before stays, without `scale_um` full scale and tolerance.
    """
    told: list[Option] = [
        {
            "id": f"turns-{one.slot}",
            "itemStyle": {"color": _DOTS if one.age else _NEWEST, "opacity": opacity(one.age)},
            **({} if one.points is None else {"data": _placed(kind, one.points)}),
        }
        for one in series
    ]
    if means:
        closed = [*means, [means[0][0], means[0][1]]] if kind == POLAR else means
        told.append({"id": _MEAN_ID, "data": _placed(kind, closed)})
    if scale_um is None:
        return {"series": told}
    full_um, limit_um = scale_um
    axis = "radiusAxis" if kind == POLAR else "yAxis"
    scale = {"min": -full_um, "max": full_um, "interval": full_um / 2}
    return {"series": [*told, *_limits(kind, limit_um, full_um)], axis: [scale]}


_STEPS = (1.0, 2.0, 5.0, 10.0)
_ROOM = 1.05  # of the scale above the peak
_DOWN_SHARE = 0.8  # of the smaller step, below which it is enough
_DOWN_TIMES = 30  # for so many updates in a row: three seconds


def step_above(value: float) -> float:
    """Return the first of 1, 2, 5, 10, 20 .. that is not below a positive value.

    >>> step_above(0.11), step_above(5.0), step_above(51)
    (0.2, 5.0, 100.0)
    """
    decade = 10.0 ** floor(log10(value))
    # The last step is above every value of the decade, so one is always found.
    return next(
        float(f"{step * decade:.6g}") for step in _STEPS if step * decade >= value * (1 - 1e-9)
    )


class Scale:
    """Full scale of a plot that is symmetric about 0.

    `least`: it never gets smaller; a step of 1, 2 or 5.
    """

    def __init__(self, least: float) -> None:
        self.full = self._least = least
        self._low_times = 0

    def follow(self, peak: float) -> float:
        """Take the largest magnitude that is to be shown, and return the full scale."""
        if not isfinite(peak):
            return self.full
        wanted = max(self._least, step_above(max(peak, 1e-12) * _ROOM))
        if wanted > self.full:
            self.full, self._low_times = wanted, 0
        elif wanted < self.full and peak <= wanted * _DOWN_SHARE:
            self._low_times += 1
            if self._low_times >= _DOWN_TIMES:
                self.full, self._low_times = wanted, 0
        else:
            self._low_times = 0
        return self.full
