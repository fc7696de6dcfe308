"""What the simulator gives of a cut, as arrays of what they mean.

>>> rows = np.array([(1, 0, 5, 46, -30), (0, 0.25, 7, 45.9, 20)], [
...     ("section", float), ("turn", float), ("z_mm", float), ("radius_mm", float),
...     ("deviation_nm", float)])
>>> found = sections_of(rows)
>>> found.sections[0].deviation_mm.tolist(), found.lines[0].angle_deg
([-3e-05], 90.0)
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, NamedTuple, Self, TypeVar

import numpy as np
import numpy.typing as npt

from camtools.base.errors import InputError
from camtools.base.project import Origin
from camtools.base.quantities import DEG_PER_TURN, NM_PER_MM, Floats
from camtools.base.text import Json
from camtools.roundness.section import DEFAULT_UPR
from camtools.sim.binding import Rows
from camtools.sim.drawn_parts import DrawnParts
from camtools.table.header import MadeTable

TRACE, SURFACE, SUMMARY = "trace.parquet", "surface.csv", "summary.json"
SECTIONS = "sections.csv"
OVERVIEW = "overview.parquet"  # one tick of several of a cut too long to trace
STATES = (
    *("off", "homing", "ready", "engaging", "cutting", "disengaging", "fault"),
    *("rehearsing", "identifying", "manual", "holding"),
)
CUTTING, FAULT = STATES.index("cutting"), STATES.index("fault")
_TURNS_PER_Q32 = 2.0**-32


class GaugedSurface(NamedTuple):
    """Gauged points of the surface, each of shape (n,)."""

    turn: Floats  # drawing's angle, 0 .. 1
    z_mm: Floats
    radius_mm: Floats
    error_um: Floats  # above 0: metal left standing


class CutTrace(NamedTuple):
    """Every tick of the controller, each of shape (n,)."""

    t_s: Floats
    turn: Floats  # drawing's angle since the index was found; falls with M4
    z_mm: Floats
    u_set_nm: Floats  # where U shall be when the command has taken effect
    u_act_nm: Floats  # measured
    state: Floats  # index into STATES
    u_due_nm: Floats  # where U should be now
    error_nm: Floats  # true radius of the tool tip minus that of the drawing
    x_nm: Floats  # measured
    turns_per_tick: Floats

    @property
    def following_um(self) -> Floats:
        """Return the following error of U [um]."""
        return (self.u_act_nm - self.u_due_nm) * 1e-3

    @property
    def speed_rpm(self) -> Floats:
        """Return the spindle speed as the controller sees it [r/min]."""
        tick_s = float(np.median(np.diff(self.t_s))) if self.t_s.size > 1 else 1.0
        return self.turns_per_tick * (60 / tick_s)

    @property
    def sense(self) -> int:
        """Return 1 where the drawing's angle rises in time (M3), -1 where it falls (M4)."""
        return -1 if self.turn.size and self.turn[-1] < self.turn[0] else 1

    def pick(self, rows: slice | npt.NDArray[Any]) -> Self:
        """Return some of the ticks."""
        return type(self)(*(column[rows] for column in self))


def is_beyond(summary: Json) -> bool:
    """Return whether a gauged surface is out of its tolerance, or out of those of its zones."""
    form = summary["form_error_um"]
    return float(form.get("excess", form["max"] - form["tolerance"])) > 0


PLACES = 3600  # of a whole section


class GaugedSection(NamedTuple):
    """A section; arrays of shape (n,), in the order of rising angles."""

    number: int  # as asked for, from 1 on
    z_mm: float
    turn: Floats  # drawing's angle, 0 .. 1; of a lobe the polar angle of its profile
    radius_mm: Floats
    deviation_mm: Floats  # from the drawing, above 0: metal left; of a lobe along the normal

    @property
    def is_whole(self) -> bool:
        """Return whether it was cut all round."""
        return self.turn.size == PLACES


class GaugedLine(NamedTuple):
    """A profile along the height; arrays of shape (n,), heights rising."""

    angle_deg: float  # drawing's
    z_mm: Floats
    radius_mm: Floats
    deviation_mm: Floats


class GaugedSections(NamedTuple):
    """Sections and lines of a part."""

    sections: tuple[GaugedSection, ...] = ()
    lines: tuple[GaugedLine, ...] = ()


NO_SECTIONS = GaugedSections()


class Removal(NamedTuple):
    """Metal removed in time slices, each of shape (n,)."""

    t_s: Floats  # middle of the slice
    turn: Floats  # drawing's angle there; falls with M4
    z_mm: Floats
    rate_mm3_s: Floats
    power_w: Floats
    rate_force_n: Floats  # the papers' model: area cut in the slice
    chip_force_n: Floats  # physical: section of the chip


MadeT = TypeVar("MadeT", bound=MadeTable, covariant=True)
_SURFACE_COLUMNS = ("turn", "z_mm", "radius_mm", "error_nm")
_TRACE_COLUMNS = (
    *("t_s", "turn", "z_mm", "u_set_nm", "u_act_nm", "state", "u_due_nm", "error_nm"),
    *("in_x_nm", "speed_q32"),
)


def surface_of(rows: Rows, error: str = "error_nm") -> GaugedSurface:
    """Return a surface with the errors of a column."""
    turn, z_mm, radius_mm = (rows[name] for name in _SURFACE_COLUMNS[:3])
    return GaugedSurface(turn, z_mm, radius_mm, rows[error] * 1e-3)


def control_of(rows: Rows) -> GaugedSurface | None:
    """Return the surface with the controller's own errors, nothing where they are the same."""
    return surface_of(rows, "control_nm") if "control_nm" in (rows.dtype.names or ()) else None


def sections_of(rows: Rows) -> GaugedSections:
    """Return the sections of a part; without a section when nothing was cut."""
    number, turn, z_mm, radius_mm = (
        rows[name] for name in ("section", "turn", "z_mm", "radius_mm")
    )
    deviation_mm = rows["deviation_nm"] / NM_PER_MM
    sections = []
    for section_number in np.unique(number[number > 0]):
        at = number == section_number
        place = float(z_mm[at][0])
        sections.append(
            GaugedSection(int(section_number), place, turn[at], radius_mm[at], deviation_mm[at])
        )
    lines = []
    for line_turn in np.unique(turn[number == 0]):
        at = (number == 0) & (turn == line_turn)
        angle_deg = float(line_turn) * DEG_PER_TURN
        lines.append(GaugedLine(angle_deg, z_mm[at], radius_mm[at], deviation_mm[at]))
    return GaugedSections(tuple(sections), tuple(lines))


def removal_of(rows: Rows) -> Removal:
    """Return the slices of metal removed."""
    return Removal(*(rows[name] for name in Removal._fields))


def read_surface(path: Path) -> GaugedSurface:
    """Return the surface that a run has kept; without a point when nothing was cut."""
    with path.open(encoding="ascii") as stream:
        header = stream.readline().strip().split(",")
        is_empty = not stream.read(1)
    for name in _SURFACE_COLUMNS:
        if name not in header:
            problem = f"has no column {name}"
            raise InputError(path.name, "", None, problem, "build camsim again, as tools/run does")
    places = [header.index(name) for name in _SURFACE_COLUMNS]
    form: dict[str, Any] = {"delimiter": ",", "skiprows": 1, "encoding": "ascii", "ndmin": 2}
    rows = np.empty((0, 4)) if is_empty else np.loadtxt(path, usecols=places, **form)
    turn, z_mm, radius_mm, error_nm = np.ascontiguousarray(rows.T)
    return GaugedSurface(turn, z_mm, radius_mm, error_nm * 1e-3)


def read_trace(path: Path) -> CutTrace:
    """Return a trace from a Parquet file."""
    from camtools.sim.table_file import read_columns  # pyarrow, which making a table never needs

    found = read_columns(path, _TRACE_COLUMNS)
    columns = [found[name].astype(np.float64) for name in _TRACE_COLUMNS]
    columns[-1] *= _TURNS_PER_Q32
    return CutTrace(*columns)


def read_swing(path: Path) -> Floats | None:
    """Return the true swing of the tool [degrees] from a trace, nothing when there is none."""
    from camtools.sim.table_file import column_names, read_columns

    if "swing_act_deg" not in column_names(path):
        return None
    swing: Floats = read_columns(path, ("swing_act_deg",))["swing_act_deg"]
    return swing


class CutVariant(NamedTuple):
    """The same cut with a part of the controller switched off."""

    name: str
    max_um: float  # control error
    rms_um: float


@dataclass(frozen=True, eq=False)
class Cut(Generic[MadeT]):
    """What is known about the cut of a part of any kind."""

    generated: MadeT  # the part and its table
    summary: Json  # of camsim
    surface: GaugedSurface
    trace: CutTrace
    is_trace_complete: bool = True  # the trace holds the whole cut, not its first turns only
    variants: tuple[CutVariant, ...] = ()  # comparison cuts, the matched one first; may be empty
    overview: CutTrace | None = None  # one tick of several, where the trace is not complete
    origin: Origin | None = None  # what repeats the cut, where a command made it
    sections: GaugedSections = NO_SECTIONS  # the true radius at evenly spaced places
    cutoff_upr: int = DEFAULT_UPR  # of the filter of the sheets, waves per turn
    drawn: DrawnParts | None = None  # the same part on machines that a forecast has drawn

    @property
    def name(self) -> str:
        """Return the part's name."""
        return self.generated.part.part.name

    @property
    def is_modulated(self) -> bool:
        """Return whether the table changes the spindle's speed over its angle."""
        return self.generated.table.speed is not None

    @property
    def has_fault(self) -> bool:
        """Return whether the controller ended the cut by itself."""
        return "fault" in self.summary

    @property
    def is_good(self) -> bool:
        """Return whether the whole part was cut within tolerance."""
        return bool(self.summary["is_good"])


AnyCut = Cut[Any]
