"""One round of cutting, gauging and correcting: from a surface and its table to a correction.

>>> is_alike({"a": [1.0, "x"]}, {"a": [1.0 + 1e-13, "x"]}), is_alike({"a": 1.0}, {"a": 1.1})
(True, False)
"""

import json
from collections.abc import Sequence
from contextlib import suppress
from math import isclose
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.files import read_limited, utf8_text
from camtools.base.quantities import UM_PER_MM
from camtools.base.text import Json
from camtools.cut.correction import MAX_ORDER, Correction, Drawing, correction_of
from camtools.measured.correction_step import RoundStep, account_of, best_text, judged, take, taper
from camtools.measured.points import MAX_BYTES, GaugedPoints, parse_points
from camtools.measured.surface import SurfaceFit, fit_surface
from camtools.part.areas import in_any

_MAX_BYTES = 64 * 1024 * 1024
_SUMMARY = "summary.json"  # that camsim and tools/run write beside a surface
_RELATIVE, _ABSOLUTE = 1e-9, 1e-12


class Previous(NamedTuple):
    """The table that cut a part."""

    path: Path
    crc32: int
    report: Json
    correction: Correction | None


def is_alike(first: object, second: object) -> bool:
    """Return whether two JSON values are the same but for rounding."""
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(
            is_alike(first[key], second[key]) for key in first
        )
    if isinstance(first, list) and isinstance(second, list):
        return len(first) == len(second) and all(map(is_alike, first, second))
    if isinstance(first, float | int) and isinstance(second, float | int):
        return isclose(first, second, rel_tol=_RELATIVE, abs_tol=_ABSOLUTE)
    return bool(first == second)


def read_given(path: Path, option: str, most_bytes: int = _MAX_BYTES) -> bytes:
    """Return the content of a file that an option names, or refuse it."""
    try:
        return read_limited(path, most_bytes)
    except (OSError, ValueError) as error:  # a path with a NUL is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
        raise CamtoolsError([f"{option} {path}: cannot be read: {reason}; give a file"]) from error


def _report(path: Path) -> Json:
    found: object = None
    with suppress(ValueError):
        found = json.loads(read_given(path, "--previous"))
    if not isinstance(found, dict) or not {"part", "design", "table_crc32"} <= found.keys():
        problem = "not a NAME.json of mktables"
        raise CamtoolsError([f"--previous {path}: {problem}; give that of the table that cut it"])
    return found


def _crc32(report: Json) -> int:
    """Return the CRC-32 of a report, a number or a string in hexadecimal."""
    value = report["table_crc32"]
    return int(value, 16) if isinstance(value, str) else int(str(value))


def _check_summary(surface: Path, path: Path, crc32: int) -> None:
    """Refuse a surface whose summary beside it names another table."""
    summary = surface.parent / _SUMMARY
    if not summary.is_file():
        return
    try:
        named = _crc32(json.loads(read_given(summary, "--measured")))
    except (ValueError, TypeError, KeyError):
        return
    if named != crc32:
        problem = f"{_SUMMARY} next to it names table 0x{named:08x}, but {path} is of table "
        problem += f"0x{crc32:08x}: another table cut the part"
        raise CamtoolsError([f"--measured {surface}: {problem}; give its NAME.json by --previous"])


def find_previous(surface: Path, given: Path | None, name: str, design: Json) -> Previous:
    """Return the table that cut a gauged part: NAME.json as given, or beside the surface.

    Name and design are those of the part whose next table is to be made. Raises CamtoolsError:
    there is none, or it is not known to be of this part and surface.
    """
    path = given or surface.parent / f"{name}.json"
    if given is None and not path.is_file():
        problem = f"no {name}.json next to it, so the table that cut the part is unknown"
        raise CamtoolsError([f"--measured {surface}: {problem}; give it by --previous NAME.json"])
    report = _report(path)
    own = report["part"].get("name")
    if own != name:
        problem = f"is of the part '{own}', not of '{name}'"
        raise CamtoolsError([f"--previous {path}: {problem}; give that of the table that cut it"])
    drawn = {key: value for key, value in report["design"].items() if key not in _NO_SHAPE}
    if not is_alike(drawn, design):
        problem = "not the drawing of the part file, so the surface belongs to another one"
        remedy = "measure a part that the table of this part file has cut"
        raise CamtoolsError([f"--previous {path}: design: {problem}; {remedy}"])
    crc32 = _crc32(report)
    _check_summary(surface, path, crc32)
    try:
        correction = correction_of(report["correction"]) if "correction" in report else None
    except (KeyError, TypeError, ValueError) as error:
        problem = "correction: not as mktables writes it"
        raise CamtoolsError([f"--previous {path}: {problem}; make the table again"]) from error
    return Previous(path, crc32, report, correction)


_NO_SHAPE = ("gauge_mm", "windows", "zones")  # of a drawing: where it is judged, and how
DEFAULT_GAIN = 0.7
MIN_GAIN, MAX_GAIN = 0.05, 1.0
MAX_MEAN_UM = 100.0
MIN_LIMIT_UM, SPRUNG_UM = 10.0, 25.0  # least limits: of an oval, of all waves, as of a chuck
LIMIT_SHARE = 0.1  # of the section's reduction
MAX_OFF_RADIUS_UM = 20.0
CLEAR_SHARE = 0.1  # by which the largest error or the rms must fall, and by the noise
MOST_RISE = 0.01  # of the largest error, beside the noise, where the rms falls
_BEYOND = 0.01  # of the part's height
_GRID = 720


class Request(NamedTuple):
    """What the command line asks for."""

    surface: Path  # the gauged one
    previous: Path | None = None  # NAME.json of the table that cut it; None: beside the surface
    gain: float = DEFAULT_GAIN  # share taken off of what this part alone shows, see `take`
    most_order: int | None = None  # highest harmonic kept; None: 16, or as many as angles allow
    is_centred: bool = False  # mean and centre were taken out: harmonics 0 and 1 are left alone


class Round(NamedTuple):
    """The correction of the next table, with what it is made of in `rounds`."""

    correction: Correction
    previous: Previous


def check_request(request: Request) -> None:
    """Refuse options that are out of range."""
    if not MIN_GAIN <= request.gain <= MAX_GAIN:
        problem = f"--gain {request.gain:g}: must be {MIN_GAIN:g} .. {MAX_GAIN:g}"
        raise CamtoolsError([f"{problem}; leave it out for {DEFAULT_GAIN:g}"])
    order = request.most_order
    if order is not None and not 1 <= order <= MAX_ORDER:
        problem = f"--keep-harmonics {order}: must be 1 .. {MAX_ORDER}"
        raise CamtoolsError([f"{problem}; leave it out for 16, or as many as the angles allow"])


def _check_place(points: GaugedPoints, drawing: Drawing) -> None:
    """Refuse points that lie beyond the part, or on another radius."""
    first_mm, last_mm = drawing.ends_mm
    slack_mm = _BEYOND * (last_mm - first_mm)
    off_mm = np.maximum(first_mm - points.z_mm, points.z_mm - last_mm)
    worst = int(np.argmax(off_mm))
    if off_mm[worst] > slack_mm:
        part = f"the part's {first_mm:g} .. {last_mm:g} mm"
        problem = f"height {points.z_mm[worst]:.6g} mm is beyond {part}"
        raise CamtoolsError([f"--measured: {problem}; give heights of the drawing, and this part"])
    if points.radius_mm is None:
        return
    drawn_mm = drawing.radius_mm(points.turn, np.clip(points.z_mm, first_mm, last_mm))
    off_um = (points.radius_mm - drawn_mm) * UM_PER_MM - points.deviation_um
    if np.median(np.abs(off_um)) > MAX_OFF_RADIUS_UM:
        problem = (
            f"radii and deviations contradict each other by {float(np.median(off_um)):.4g} um in "
            f"the median, at most {MAX_OFF_RADIUS_UM:g} um is allowed"
        )
        raise CamtoolsError([f"--measured: {problem}; give the surface of this part"])


def _check_size(fit: SurfaceFit, drawing: Drawing) -> None:
    """Refuse errors that no machine makes which cuts this part."""
    whole = fit.correction(drawing.ends_mm, 1.0)
    mean_um = float(np.abs(whole.mean(whole.nodes_mm)).max()) * UM_PER_MM
    if mean_um > MAX_MEAN_UM:
        problem = f"the mean of a height is {mean_um:.4g} um off, the limit is {MAX_MEAN_UM:g} um"
        remedy = "correct the zero of X or the tool offset, and cut again"
        raise CamtoolsError([f"--measured: {problem}; {remedy}"])
    oval = Correction(
        drawing.ends_mm, {k: whole.waves_mm[k] for k in (2, 4) if k in whole.waves_mm}
    )
    share_um = LIMIT_SHARE * drawing.swing_mm * UM_PER_MM
    for waves, name, least_um in (
        (oval, "waves of an oval", MIN_LIMIT_UM),
        (whole, "waves", SPRUNG_UM),
    ):
        limit_um, waves_um = max(least_um, share_um), _largest_um(waves)
        if waves_um > limit_um:
            problem = (
                f"the {name} reach {waves_um:.4g} um, the limit is {limit_um:.4g} um, a tenth of "
                f"the stroke of U and at least {least_um:g} um"
            )
            remedy = "give deviations from the drawing by its angle, not from a circle; else "
            raise CamtoolsError([f"--measured: {problem}; {remedy}identify the drive first"])


def _largest_um(waves: Correction) -> float:
    phi = 2 * np.pi * np.arange(_GRID) / _GRID
    return float(np.abs(waves.delta(phi, waves.nodes_mm[:, None])[0]).max()) * UM_PER_MM


def _check_new(previous: Previous, surface: Path, own: int) -> None:
    """Refuse a surface that was corrected already."""
    rounds = previous.correction.rounds if previous.correction else ()
    for number, about in enumerate(rounds, start=1):
        if about.get("surface_crc32") == own:
            problem = f"was already used in round {number} of {previous.path}"
            remedy = "measure a part that this table has cut"
            raise CamtoolsError([f"--measured {surface}: {problem}; {remedy}"])


def _step(fit: SurfaceFit, by: GaugedPoints, before: Correction, gain: float) -> RoundStep:
    """Return what the round takes off, smaller at the ends where that leaves less."""
    shown = fit.correction(before.heights_mm, 1.0)
    taken = taper(take(shown, before.left_mm, gain).taken, by)
    left_mm = {order: shown.waves_mm[order] - values for order, values in taken.waves_mm.items()}
    return RoundStep(taken, left_mm)


def _check_gain(rounds: Sequence[Json]) -> None:
    """Refuse a last round that promises too little, the previous misprediction included."""
    about = rounds[-1]
    now_um, next_um, missed_um = about["judged_um"], dict(about["expected_um"]), 0.0
    if len(rounds) > 1:
        expected_um = rounds[-2]["expected_um"]
        missed_um = max(0.0, now_um["max"] - expected_um["max"])
        for key in next_um:
            next_um[key] += max(0.0, now_um[key] - expected_um[key])
    repeats_um = about["noise_corrected_um"]
    is_less = [next_um[key] + repeats_um <= (1 - CLEAR_SHARE) * now_um[key] for key in now_um]
    most_um = (1 + MOST_RISE) * now_um["max"] + about["noise_um"]
    if next_um["max"] <= most_um and any(is_less):
        return
    problem = f"the next part would not be clearly better: the largest error is {now_um['max']:.4g}"
    problem += f" um now and would be {next_um['max']:.4g} um"
    problem += f", of which the last round mispredicted {missed_um:.2g} um" if missed_um else ""
    remedy = f"keep {best_text(rounds)}, or gauge more points with less noise"
    raise CamtoolsError([f"--measured: {problem}; {remedy}"])


def _on_metal(points: GaugedPoints, drawing: Drawing) -> GaugedPoints:
    """Return the points that lie in no window of the drawing, nor in the margin of one."""
    if not drawing.windows:
        return points
    radius_mm = drawing.radius_mm(points.turn, np.clip(points.z_mm, *drawing.ends_mm))
    return points.pick(~in_any(drawing.windows, points.turn, points.z_mm, radius_mm))


def next_round(request: Request, name: str, drawing: Drawing) -> Round:
    """Return the correction of the next table.

    Raises CamtoolsError: not a surface of this part, too little of it, too large errors, no gain.
    """
    check_request(request)
    data = read_given(request.surface, "--measured", MAX_BYTES)
    previous = find_previous(request.surface, request.previous, name, drawing.document)
    own = crc32(data)
    _check_new(previous, request.surface, own)
    file = str(request.surface)
    points = parse_points(utf8_text(data, file), file)
    try:
        _check_place(points, drawing)
        points = _on_metal(points, drawing)
        first = 2 if request.is_centred else 0
        fit = fit_surface(points, drawing.ends_mm, request.most_order, first)
        _check_size(fit, drawing)
        before = previous.correction or Correction(drawing.ends_mm, {})
        by = judged(fit, points, drawing.ends_mm)
        step = _step(fit, by, before, request.gain)
        about = {"table_crc32": previous.crc32, "surface_crc32": own, "gain": request.gain}
        about |= account_of(points, fit, step, by)
        _check_gain([*before.rounds, about])
    except CamtoolsError as error:
        own_name = f"--measured {request.surface}: "
        lines = [line.replace("--measured: ", own_name, 1) for line in error.lines]
        if drawing.windows:
            hint = "heights with a window count only for few waves, a gap of g degrees for 180 / g"
            lines.append(f"{own_name}{hint}; give --keep-harmonics as few")
        raise CamtoolsError(lines) from error
    return Round(before.plus(step.taken, about, step.left_mm), previous)
