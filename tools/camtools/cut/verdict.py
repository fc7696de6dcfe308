"""Whether the controller takes a table on a machine: its own rule, told in the words of a part.

>>> from camtools.cut.demand import Demand
>>> _line(Demand("u_speed", 400_000, 500_000), "turn more slowly")
'machine.limits.u_speed_mm_s = 400 mm/s: the part needs 500 mm/s; turn more slowly'
"""

from __future__ import annotations

from typing import NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.cut.demand import (
    Demand,
    JudgedCut,
    demands_of,
    exceeded,
    highest_mrpm,
    largest_feed_nm,
    parameters_of,
)
from camtools.cut.feasibility import HighestSpeed, remedy_text
from camtools.part.common import MachineLimits, SwingLimits
from camtools.table.facts import facts_of
from camtools.table.image import Table


class _Named(NamedTuple):
    """How the generator calls a limit of the controller."""

    name: str
    per_unit: float  # of the generator's unit, in that of the controller
    unit: str


_NAMES = {
    "swing_axis": _Named("swing_speed_deg_s", 1, "degrees/s"),
    "swing_range": _Named("swing_deg", 1e3, "degrees"),
    "swing_speed": _Named("swing_speed_deg_s", 1e3, "degrees/s"),
    "swing_acceleration": _Named("swing_acceleration_deg_s2", 1, "degrees/s2"),
    "spindle_speed": _Named("spindle_rpm", 1e3, "r/min"),
    "u_stroke": _Named("u_stroke_mm", 0.5e6, "mm"),
    "u_speed": _Named("u_speed_mm_s", 1e3, "mm/s"),
    "u_acceleration": _Named("u_acceleration_mm_s2", 1, "mm/s2"),
    "z_speed": _Named("z_speed_mm_s", 1e3, "mm/s"),
    "z_acceleration": _Named("z_acceleration_mm_s2", 1, "mm/s2"),
    "spindle_acceleration": _Named("spindle_acceleration_rad_s2", 1e3, "rad/s2"),
    "spindle_loop": _Named("spindle_bandwidth_rad_s", 1e3, "rad/s"),
    "spindle_set_point": _Named("spindle_rpm", 1e3, "r/min"),
    "tick_rate": _Named("tick_hz", 1e3, "r/min of a tick"),
    "x_speed": _Named("x_speed_mm_s", 1e3, "mm/s"),
    "x_acceleration": _Named("x_acceleration_mm_s2", 1, "mm/s2"),
    "feed": _Named("feed_mm", 1e6, "mm"),
    "cam_amplitude": _Named("amplitude", 1e6, ""),
    "turns": _Named("feed_mm", 1, "turns"),
}
_AT_ANY_SPEED = {
    "u_stroke": "no speed would do: less {}, or a longer stroke",
    "swing_range": "no speed would do: less steep a lift",
    "turns": "no speed would do: a larger feed_mm",
}
_TOLD_WHERE_EXCEEDED = ("swing_axis", "cam_amplitude", "turns")
_NOT_OF_A_PART = ("x_speed", "x_acceleration", "tick_rate", "feed", "cam_amplitude", "turns")


class RefusedError(CamtoolsError):
    """The machine cannot follow a table, which is known nevertheless.

    Attributes
    ----------
    table : Table
        What was judged.
    best : HighestSpeed
        What would do.
    """

    def __init__(self, lines: list[str], table: Table, best: HighestSpeed) -> None:
        super().__init__(lines)
        self.table = table
        self.best = best


class LimitMargin(NamedTuple):
    """What a cut needs of a limit, in the unit of the part file."""

    name: str  # the controller's
    field: str  # of machine.limits, or of the controller where no part file has it
    needed: float
    limit: float
    unit: str

    @property
    def left_percent(self) -> float:
        """Return how much of the limit is left [%], below 0 where it is exceeded."""
        return 100 * (1 - self.needed / self.limit) if self.limit else 0.0


def refused_of(error: BaseException | None) -> RefusedError | None:
    """Return the refusal of a table that led to an error, if one did."""
    while error is not None and not isinstance(error, RefusedError):
        error = error.__cause__
    return error


def margins_of(table: Table, limits: MachineLimits) -> list[LimitMargin]:
    """Return every limit that a cut may come near to, with what the table needs of it."""
    found = []
    for one in demands_of(cut_of(table, limits)):
        named = _NAMES[one.name]
        if one.name in _TOLD_WHERE_EXCEEDED and one.needed <= one.limit:
            continue
        needed, limit = one.needed / named.per_unit, one.limit / named.per_unit
        found.append(LimitMargin(one.name, named.name, needed, limit, named.unit))
    return found


def cut_of(table: Table, limits: MachineLimits) -> JudgedCut:
    """Return the cut of a table as the controller of this machine judges it."""
    return JudgedCut(facts_of(table), parameters_of(limits), table.spindle_mrpm, table.feed_nm)


def highest_of(cut: JudgedCut) -> HighestSpeed:
    """Return the highest speed that the controller takes, and the limit that decides."""
    mrpm = highest_mrpm(cut)
    beyond = exceeded(cut._replace(mean_mrpm=mrpm + 1))
    return HighestSpeed(mrpm / 1000, _NAMES[beyond[0].name].name if beyond else "spindle_rpm")


def _line(demand: Demand, remedy: str) -> str:
    named = _NAMES[demand.name]
    needed, limit = demand.needed / named.per_unit, demand.limit / named.per_unit
    told = f"{limit:.9g} {named.unit}: the part needs {needed:.9g} {named.unit}; {remedy}"
    if demand.name in _NOT_OF_A_PART:
        return f"the controller's {demand.name} = {told}"
    what = " as set-point of its loop" if demand.name == "spindle_set_point" else ""
    return f"machine.limits.{named.name} = {told}".replace("; ", f"{what}; ", 1)


def check_table(
    table: Table,
    limits: MachineLimits,
    best: HighestSpeed | None = None,
    asked_rpm: float | None = None,
) -> HighestSpeed:
    """Return the highest speed of a table, or refuse what the controller would refuse.

    Parameters
    ----------
    best : HighestSpeed, optional
        Highest speed asked for that would do, where it is not the highest mean speed.
    asked_rpm : float, optional
        Speed of the part file, where it is not the mean speed.

    Raises
    ------
    RefusedError
        One line for each limit exceeded: needed, limit, highest speed that would do.
    """
    cut = cut_of(table, limits)
    best = best or highest_of(cut)
    asked_rpm = table.spindle_mrpm / 1000 if asked_rpm is None else asked_rpm
    found = exceeded(cut)
    if asked_rpm > limits.spindle_rpm and all(one.name != "spindle_speed" for one in found):
        highest, asked = round(limits.spindle_rpm * 1000), round(asked_rpm * 1000)
        found.append(Demand("spindle_speed", highest, asked))
    if not found:
        return best if best.rpm >= asked_rpm else HighestSpeed(asked_rpm, best.decides)
    feed_nm = largest_feed_nm(cut)
    remedy = remedy_text(best, asked_rpm, feed_nm / NM_PER_MM if feed_nm > 0 else None)
    shape = "lift" if isinstance(limits, SwingLimits) else "ovality"
    raise RefusedError(
        [_line(one, _AT_ANY_SPEED.get(one.name, remedy).format(shape)) for one in found],
        table,
        best,
    )
