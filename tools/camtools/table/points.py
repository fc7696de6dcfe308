r"""Points of one turn as text: value over angle, with velocity and acceleration or without them.

A header names columns and units; without one two columns of numbers are angle and value, four are
angle, value, velocity and acceleration, in degrees and mm. The third of three is ignored if notes
follow, as in Lenze's files.
[Forms of other makers](maker_forms.py) are read, too. A turn may begin anywhere: its angle may fall
once, from the end of the turn to its begin.

>>> text = "X_deg;Y_mm\n" + "".join(f"{45 * i};{i % 8},5\n" for i in range(9))
>>> found = parse_points(text, "a.txt")
>>> found.sections[0].y_mm.tolist()[:3], found.has_motion
([0.5, 1.5, 2.5], False)
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.number_table import Column, NumberTable, read_whole_table
from camtools.base.quantities import DEG_PER_RAD, DEG_PER_TURN, Floats, Ints
from camtools.part.model import MIN_STEP_MM, SAME_MM
from camtools.table.channel import segment_coefficients
from camtools.table.maker_forms import Found, check_rows, found_in, placed

MAX_POINTS = 100_000
MAX_BYTES = 20_000_000
MIN_STEP_DEG = 0.001
_CLOSED_MM = 1e-6  # values of a turn's first and last point, or steps, that differ by less agree
ROUGH_SHARE, FINE_SHARE = 0.3, 0.05  # of the largest step: what V and A may contradict
_SAME_DEG = 1e-6
_FEWEST, _FEWEST_ALONE = 4, 8  # points of a turn: with motion, and of values alone
MM_PER_INCH = 25.4
_ANGLES = {"deg": 1.0, "rad": DEG_PER_RAD, "turn": DEG_PER_TURN}
LENGTHS = {"mm": 1.0, "um": 1e-3, "nm": 1e-6, "inch": MM_PER_INCH}
_WORDS = {
    "z": "z",
    "x": "x|angle|master|phi",
    "y": "y|u|lift|reduction|value|position|slave",
    "v": "v|velocity",
    "a": "a|acceleration",
}
_UNITS = {
    "z": "_(mm)",
    "x": "_(deg|rad|turn)",
    "y": "_(mm|um|nm|inch)",
    "v": "_(mm|um|nm|inch)_per_(deg|rad|turn)",
    "a": "_(mm|um|nm|inch)_per_(deg|rad|turn)2",
}
_COLUMNS = {key: re.compile(f"(?:{words})(?:{_UNITS[key]})?") for key, words in _WORDS.items()}
_MISSPELT = re.compile(rf"height|(?:{'|'.join(_WORDS.values())})(?![^\W\d_])")  # no letter follows
_WITHOUT_HEADER = {1: ("y",), 2: ("x", "y"), 3: ("x", "y"), 4: ("x", "y", "v", "a")}
_NOTE = re.compile(r"^[^#/(\n]*[0-9][ \t]+//", re.MULTILINE)  # after the numbers of a row
_USE = "name the columns z_mm, X_deg, Y_mm, V_mm_per_deg, A_mm_per_deg2, or fewer of them"


class PointedTurn(NamedTuple):
    """Points of one turn without its last point, which is the first one; shape (n,)."""

    x_deg: Floats  # rising, within a turn
    y_mm: Floats
    v: Floats  # mm/degree
    a: Floats  # mm/degree^2

    @property
    def steps_deg(self) -> Floats:
        """Return the distance to the next point, of the last one to the first."""
        return np.diff(np.append(self.x_deg, self.x_deg[0] + 360))


_GAP_STEPS = 4.0  # a gap: so many mean steps without a point ..
_GAP_DEG = (10.0, 45.0)  # .. but not less than the first and not more than the second


def most_step_deg(n: int) -> float:
    """Return the largest distance between two of n points of a turn that is no gap."""
    return float(np.clip(_GAP_STEPS * DEG_PER_TURN / n, *_GAP_DEG))


def gaps_after(steps_deg: Floats) -> Ints:
    """Return after which points of a turn there is a gap, by the distances to the next points."""
    return np.flatnonzero(steps_deg > most_step_deg(steps_deg.size))


class PointFile(NamedTuple):
    """What a file of points holds."""

    z_mm: Floats | None  # (m,) rising; none where the file does not tell heights
    sections: tuple[PointedTurn, ...]  # one for each height
    has_motion: bool  # velocities and accelerations were given


class Reading(NamedTuple):
    """How a file is read: units that its header does not name, and what its values are."""

    turns: int = 1  # of the file's angle for one turn of the part
    value_mm: float | None = None  # of 1 in the columns Y, V and A; mm where it is not given
    counts_per_turn: float | None = None  # of the file's angle; degrees where it is not given
    if_longer: str = ""  # what else to do about points that span up to two turns
    if_counts: str = ", and convert counts of an encoder"  # .. and about those that span more
    is_lift: bool = False  # an arc without points may be the base circle, however long it is

    @property
    def deg(self) -> float:
        """Return how far the part turns [deg] by 1 of the file's angle."""
        return DEG_PER_TURN / (self.counts_per_turn or DEG_PER_TURN) / self.turns


DEGREES_AND_MM = Reading()


class _Column(NamedTuple):
    key: str
    scale: float
    place: int
    has_unit: bool = False


def _column(name: str, place: int) -> _Column | None:
    for key, pattern in _COLUMNS.items():
        found = pattern.fullmatch(name)
        if found is None:
            continue
        units = [unit for unit in found.groups() if unit]
        scale = _ANGLES.get(units[0], LENGTHS.get(units[0], 1.0)) if units else 1.0
        if len(units) == 2:
            scale /= _ANGLES[units[1]] ** (1 if key == "v" else 2)
        return _Column(key, scale, place, bool(units))
    return None


def _check_names(table: NumberTable) -> None:
    """Refuse a name that seems to be a column of points in an unknown unit."""
    for place, name in enumerate(table.names):
        if _MISSPELT.match(name) and _column(name, place) is None:
            problem = f"column {place + 1} has an unknown unit or name"
            raise InputError(table.file, table.place, None, problem, _USE)


def _unnamed(table: NumberTable) -> InputError:
    columns = "1 column" if table.n_columns == 1 else f"{table.n_columns} columns"
    problem = f"has {columns} and no header"
    return InputError(table.file, table.place, None, problem, _USE)


def _columns_of(table: NumberTable, layout: Found | None) -> list[_Column]:
    """Return the columns of points by a header, or by their number without one."""
    if layout is not None:
        check_rows(layout, table)
    if not table.names:
        if table.n_columns not in _WITHOUT_HEADER or (table.n_columns == 1 and layout is None):
            raise _unnamed(table)
        keys = list(_WITHOUT_HEADER[table.n_columns])
        return [_Column(key, 1.0, place) for place, key in enumerate(keys)]
    _check_names(table)
    columns = [
        found
        for place, name in enumerate(table.names)
        if (found := _column(name, place)) is not None
    ]
    keys = [column.key for column in columns]
    missing = [key for key in ("x", "y") if key not in keys]
    if ("v" in keys) != ("a" in keys):
        missing.append("a" if "v" in keys else "v")
    if missing or len(set(keys)) != len(keys):
        what = f"no column of {missing[0].upper()}" if missing else "a column appears twice"
        raise InputError(table.file, table.place, None, what, _USE)
    return columns


def _check_units(columns: list[_Column], reading: Reading, file: str, place: str) -> None:
    """Refuse a header that names units where the part file names others."""
    for keys, given, what in (
        ("yva", reading.value_mm, "length"),
        ("xva", reading.counts_per_turn, "angle"),
    ):
        if given is not None and any(c.has_unit and c.key in keys for c in columns):
            problem = f"the header names a unit of {what}, and the part file another"
            remedy = "name the columns without a unit, or remove the unit from the part file"
            raise InputError(file, place, None, problem, remedy)


def _in_units(rows: dict[str, Floats], reading: Reading) -> dict[str, Floats]:
    """Return columns in degrees of the part and mm."""
    value_mm, deg = reading.value_mm or 1.0, reading.deg
    factors = {"x": deg, "y": value_mm, "v": value_mm / deg, "a": value_mm / deg**2}
    return {key: row * factors.get(key, 1.0) for key, row in rows.items()}


def parse_points(text: str, file: str, reading: Reading = DEGREES_AND_MM) -> PointFile:
    """Return the points of a text, or refuse it by the line that is wrong, with a remedy."""
    layout = found_in(text, file)
    table = NumberTable(text if layout is None else layout.text, file, MAX_POINTS)
    columns = _columns_of(table, layout)
    _check_units(columns, reading, file, table.place)
    if not table.rows:
        raise InputError(file, table.place, None, "no points follow", "give those of one turn")
    values = table.values([Column(column.place, column.scale) for column in columns])
    rows = dict(zip((column.key for column in columns), values, strict=True))
    with np.errstate(over="ignore", invalid="ignore"):
        if layout is not None:
            rows = placed(layout, rows, DEG_PER_TURN / reading.deg, file)
        rows = _in_units(rows, reading)
    beyond = ~np.isfinite(np.stack(list(rows.values()))).all(axis=0)
    if beyond.any():
        problem, remedy = "no finite number in degrees and mm", "correct the number or its unit"
        raise table.refusal(int(beyond.argmax()), problem, remedy)
    if table.n_columns == 3 and not table.names and not _has_torques(text, rows):
        raise _unnamed(table)
    return _sections(rows, table.lines, file, reading)


def _has_torques(text: str, rows: dict[str, Floats]) -> bool:
    """Return whether three columns are Lenze's: with notes, X rises, Y is no height."""
    is_rising = (np.diff(_unwrapped(rows["x"])) > 0).all()
    return bool(_NOTE.search(text) and is_rising and np.ptp(rows["y"]) > 0)


def check_apart(z_mm: Floats, file: str) -> None:
    """Refuse heights that are so near to each other that they are meant to be the same."""
    heights = np.unique(z_mm)
    steps = np.diff(heights, append=np.inf)
    is_near = steps < MIN_STEP_MM - SAME_MM
    if not is_near.any():
        return
    first = int(is_near.argmax())
    last = first + int((~is_near[first:]).argmax())
    names = [f"{height:.7g}" for height in heights[first : last + 1]]
    shown = names if len(names) < 4 else [*names[:2], "..", names[-1]]
    problem = f"the heights {', '.join(shown)} mm are less than {MIN_STEP_MM:g} mm apart"
    remedy = "give all points of a section the same z_mm, the one that was set"
    raise InputError(file, "z_mm", None, problem, remedy)


def _sections(rows: dict[str, Floats], numbers: Ints, file: str, reading: Reading) -> PointFile:
    has_motion = "v" in rows
    zero = np.zeros(numbers.size)
    columns = np.stack([rows["x"], rows["y"], rows.get("v", zero), rows.get("a", zero)])
    if "z" not in rows:
        turn = _turn(columns, numbers, file, reading, has_motion=has_motion)
        return PointFile(None, (turn,), has_motion)
    z, turns = rows["z"], []
    check_apart(z, file)
    edges = np.flatnonzero(np.diff(z)) + 1
    starts = np.concatenate([[0], edges]).astype(np.int64)
    heights = z[starts]
    if (np.diff(heights) <= 0).any():
        i = int(starts[1:][np.diff(heights) <= 0][0])
        problem = f"height {z[i]:g} mm follows {z[i - 1]:g} mm"
        remedy = "sort by height, all points of one height together"
        raise InputError(file, f"line {numbers[i]}", None, problem, remedy)
    for low, high in zip(starts, [*edges, z.size], strict=True):
        turns.append(
            _turn(columns[:, low:high], numbers[low:high], file, reading, has_motion=has_motion)
        )
    return PointFile(heights, tuple(turns), has_motion)


def _unwrapped(x_deg: Floats) -> Floats:
    """Return angles that rise through the end of a turn; others are returned as they are."""
    falls = np.flatnonzero(np.diff(x_deg) < 0)
    if falls.size != 1:
        return x_deg
    late = np.arange(x_deg.size) > falls[0]
    rising = x_deg + DEG_PER_TURN * (late - float(x_deg[0] >= DEG_PER_TURN))
    is_turn = rising[-1] - rising[0] < DEG_PER_TURN + _SAME_DEG
    return rising if is_turn and (np.diff(rising) > 0).all() else x_deg


def _turn(
    columns: Floats, numbers: Ints, file: str, reading: Reading, *, has_motion: bool
) -> PointedTurn:
    """Return the points of a turn, its end left out, or refuse them."""
    columns[0] = x = _unwrapped(columns[0])
    low = np.flatnonzero(np.diff(x) < MIN_STEP_DEG)
    if low.size:
        i = int(low[0]) + 1
        problem = f"angle {x[i]:g} follows {x[i - 1]:g} degrees"
        remedy = f"sort the points, at least {MIN_STEP_DEG:g} degrees apart"
        raise InputError(file, f"line {numbers[i]}", None, problem, remedy)
    span = float(x[-1] - x[0])
    last = f"line {numbers[-1]}"
    if abs(span - 360) < _SAME_DEG:
        for key, row in zip("YVA", columns[1:], strict=True):
            if abs(row[-1] - row[0]) > _CLOSED_MM:
                problem = f"the turn is not closed: {key} ends at {row[-1]:g}, began at {row[0]:g}"
                raise InputError(file, last, None, problem, "make the last value equal the first")
        columns = columns[:, :-1]
    elif span > 360 - MIN_STEP_DEG:
        problem = f"the points span {span:.9g} degrees, a turn has 360"
        more = reading.if_longer if span < 2 * DEG_PER_TURN + 1 else reading.if_counts
        remedy = f"give one turn in degrees{more if span > 360 else ''}"
        raise InputError(file, last, None, problem, remedy)
    turn = PointedTurn(*columns)
    widest = float(turn.steps_deg.max())
    fewest = _FEWEST if has_motion else _FEWEST_ALONE
    if turn.x_deg.size < fewest or (widest >= 180 and not reading.is_lift):
        problem = f"{turn.x_deg.size} points span {span:.9g} degrees: the turn is not closed"
        raise InputError(file, last, None, problem, f"give at least {fewest} points all around")
    if has_motion:
        _check_motion(turn, numbers, file)
    return turn


def _check_motion(turn: PointedTurn, numbers: Ints, file: str) -> None:
    h, y, v, a = turn.steps_deg, turn.y_mm, turn.v, turn.a
    y1, v1, a1 = (np.roll(values, -1) for values in (y, v, a))
    rough, fine = h * (v + v1) / 2, h * (v + v1) / 2 - h**2 * (a1 - a) / 12
    for key, what, step, stated, share in (
        ("V", "values", y1 - y, rough, ROUGH_SHARE),  # a wrong unit or sense
        ("A", "velocities", v1 - v, h * (a + a1) / 2, ROUGH_SHARE),
        ("V", "values", y1 - y, fine, FINE_SHARE),
    ):
        off = np.abs(step - stated)
        i = int(off.argmax())
        if off[i] > share * float(np.abs(step).max()) + _CLOSED_MM:
            problem = (
                f"{key} contradicts the {what}: to the next point they change by {step[i]:.6g}, "
                f"{key} says {stated[i]:.6g}; {100 * share:g} % of the largest step may differ"
            )
            remedy = f"give {key} in the unit of its header, by degrees without one"
            raise InputError(file, f"line {numbers[i]}", None, problem, remedy)


def read_points(path: Path) -> PointFile:
    """Return the points of a file; errors as of `parse_points`, or it cannot be read."""
    return parse_points(read_whole_table(path, MAX_BYTES), path.name)


def quintics_of(turn: PointedTurn) -> Floats:
    """Return the quintics in t = 0 .. 1 between the points, the last one to the first, (n, 6)."""
    h = turn.steps_deg
    left = np.stack([turn.y_mm, h * turn.v, h**2 / 2 * turn.a], axis=-1)
    y1, v1, a1 = (np.roll(values, -1) for values in (turn.y_mm, turn.v, turn.a))
    right = np.stack([y1, h * v1, h**2 / 2 * a1], axis=-1)
    pairs = np.stack([left, right], axis=1)
    return np.asarray(segment_coefficients(pairs, periodic=False)[:, 0], dtype=np.float64)
