"""Whether the controller takes a table on a machine: its own rule, in the words of a part.

>>> _line(Demand("u_speed", 400_000, 500_000), "turn more slowly")
'machine.limits.u_speed_mm_s = 400 mm/s: the part needs 500 mm/s; turn more slowly'
"""

from typing import NamedTuple

from camtools.base.controller_limits import LIMITS
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.cut.feasibility import FIELDS, HighestSpeed, remedy_text
from camtools.judge.binding import Demand, Judge, TablePeaks
from camtools.part.common import MachineLimits, SwingLimits
from camtools.table.channel import KIND_SWING
from camtools.table.image import Table, pack

_FIELDS = FIELDS | {  # with limits that no part file has, or that decide by another error
    "swing_axis": "swing_speed_deg_s",
    "z_acceleration": "z_acceleration_mm_s2",
    "spindle_loop": "spindle_bandwidth_rad_s",
    "spindle_set_point": "spindle_rpm",
    "tick_rate": "tick_hz",
    "x_speed": "x_speed_mm_s",
    "x_acceleration": "x_acceleration_mm_s2",
    "feed": "feed_mm",
    "cam_amplitude": "amplitude",
    "turns": "feed_mm",
    "u_command": "u_stroke_mm",
    "u_command_speed": "u_speed_mm_s",
    "u_command_acceleration": "u_acceleration_mm_s2",
    "servo_continuous": "servo_continuous_mn",
}
_HALVES = ("u_stroke", "u_command")  # a part file has the whole stroke
_AT_ANY_SPEED = {
    "u_stroke": "no speed helps: give less {}, or a longer stroke",
    "swing_range": "no speed helps: give a less steep lift",
    "turns": "no speed helps: give a larger feed_mm",
}
_SHOWN_WHERE_EXCEEDED = (
    "swing_axis",
    "cam_amplitude",
    "turns",
    "u_command",
    "u_command_speed",
    "u_command_acceleration",
    "servo_continuous",
)
_SWING = ("swing_range", "swing_speed", "swing_acceleration")
_MOVED = ("u_speed", "u_acceleration", "swing_speed", "swing_acceleration")
_NOT_OF_A_PART = ("x_speed", "x_acceleration", "tick_rate", "feed", "cam_amplitude", "turns")


class RefusedError(CamtoolsError):
    """The machine cannot follow a table, which is known nevertheless."""

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


def _shown(demand: Demand) -> LimitMargin:
    """Return a demand in the unit of the part file."""
    unit, per_unit, _ = LIMITS[demand.name]
    per = per_unit / 2 if demand.name in _HALVES else per_unit
    field = _FIELDS[demand.name]
    return LimitMargin(demand.name, field, demand.needed / per, demand.limit / per, unit)


def margins_of(table: Table, limits: MachineLimits) -> list[LimitMargin]:
    """Return every limit that a cut may come near to, with what the table needs of it."""
    is_swung = table.angle is not None and table.angle.kind == KIND_SWING
    found = []
    for demand in judge_of(table, limits).demands(table.spindle_mrpm):
        is_left_out = demand.name in _SHOWN_WHERE_EXCEEDED and demand.needed <= demand.limit
        if demand.name in _FIELDS and not is_left_out and (is_swung or demand.name not in _SWING):
            found.append(_shown(demand))
    return found


def parameters_of(limits: MachineLimits) -> dict[str, float]:
    """Return the controller's parameters on the machine that is simulated with these limits."""
    found = {
        "u_stroke_nm": limits.u_stroke_mm * NM_PER_MM,
        "u_speed_um_per_s": limits.u_speed_mm_s * 1e3,
        "u_acceleration_mm_per_s2": limits.u_acceleration_mm_s2,
        "z_speed_um_per_s": limits.z_speed_mm_s * 1e3,
        "z_acceleration_mm_per_s2": limits.z_acceleration_mm_s2,
        "spindle_limit_mrpm": limits.spindle_rpm * 1e3,
        "spindle_lag_us": 1e6 / limits.spindle_bandwidth_rad_s,
        "spindle_acceleration_mrad_per_s2": limits.alpha_rad_s2 * 1e3,
        "swing_speed_mdeg_per_s": 1e6,
    }
    if isinstance(limits, SwingLimits):
        found |= {
            "swing_speed_mdeg_per_s": limits.swing_speed_deg_s * 1e3,
            "swing_acceleration_deg_per_s2": limits.swing_acceleration_deg_s2,
            "swing_range_mdeg": limits.swing_deg * 1e3,
        }
    return found


def needs_of_peaks(peaks: TablePeaks, limits: MachineLimits, mrpm: int) -> dict[str, float]:
    """Return needed over limit of U and of the swing before there is a table, by limit."""
    judge = Judge(peaks, limits.tick_hz, parameters_of(limits))
    return {
        _FIELDS[demand.name]: demand.needed / demand.limit
        for demand in judge.demands(mrpm)
        if demand.name in _MOVED
    }


def judge_of(table: Table, limits: MachineLimits) -> Judge:
    """Return the controller's judge of a table on this machine."""
    return Judge(pack(table), limits.tick_hz, parameters_of(limits))


def _line(demand: Demand, remedy: str) -> str:
    margin = _shown(demand)
    needed = f"{margin.needed:.9g} {margin.unit}"
    limit = f"{margin.limit:.9g} {margin.unit}: the part needs {needed}; {remedy}"
    if demand.name in _NOT_OF_A_PART:
        return f"the controller's {demand.name} = {limit}"
    what = " as set-point of its loop" if demand.name == "spindle_set_point" else ""
    return f"machine.limits.{margin.field} = {limit}".replace("; ", f"{what}; ", 1)


def check_table(
    table: Table,
    limits: MachineLimits,
    best: HighestSpeed | None = None,
    asked_rpm: float | None = None,
) -> HighestSpeed:
    """Return the highest speed of a table, or refuse what the controller would refuse.

    `best` is the highest speed asked for that would do, `asked_rpm` the speed of the part file,
    where they are no mean speeds. RefusedError has one line for each limit exceeded: needed, limit,
    highest speed that would do.
    """
    judge = judge_of(table, limits)
    if best is None:
        mrpm = judge.highest_mrpm()
        beyond = judge.exceeded(mrpm + 1)
        best = HighestSpeed(mrpm / 1000, _FIELDS[beyond[0].name] if beyond else "spindle_rpm")
    asked_rpm = table.spindle_mrpm / 1000 if asked_rpm is None else asked_rpm
    found = judge.exceeded(table.spindle_mrpm)
    if asked_rpm > limits.spindle_rpm and all(demand.name != "spindle_speed" for demand in found):
        highest, asked = round(limits.spindle_rpm * 1000), round(asked_rpm * 1000)
        found.append(Demand("spindle_speed", highest, asked))
    if not found:
        return best if best.rpm >= asked_rpm else HighestSpeed(asked_rpm, best.decides)
    feed_nm = judge.largest_feed_nm(table.spindle_mrpm)
    remedy = remedy_text(best, asked_rpm, feed_nm / NM_PER_MM if feed_nm > 0 else None)
    shape = "lift" if isinstance(limits, SwingLimits) else "ovality"
    raise RefusedError(
        [_line(demand, _AT_ANY_SPEED.get(demand.name, remedy).format(shape)) for demand in found],
        table,
        best,
    )
