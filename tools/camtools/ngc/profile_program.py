"""X/Z program for a CNC that carries camturn on its U axis.

The spindle leads: Z is fed by the turn (G33), X follows the long half axis by straight segments,
and camturn plays U from its table, from the measured spindle angle and Z.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> geometry = make_geometry(example_part())
>>> chords = segments(geometry, 0.0, 62.0, 0.0001)
>>> chords.z_mm.size - 1, f"{chords.error_mm:.7f}"
(27, '0.0000986')
"""

from collections.abc import Iterator
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.ngc.gcode_words import LENGTH_DECIMALS, ProgramJob, blocks, head, length, lines
from camtools.skirt.geometry.skirt_geometry import Geometry

_DENSE = 20_001
_MAX_SEGMENTS = 5000
_KINK = 1e-6  # mm/mm: a smaller jump of the slope is that of the cubics on an arc
_FLATTEST = 1e-9  # 1/mm, so that places on a straight line stay distinct
_WAIT_S = 60  # for camturn to engage and to disengage
_NO_ANSWER = "(MSG, camturn does not cut: see its messages)"


class Segments(NamedTuple):
    """A polygon along the profile."""

    z_mm: Floats
    x_mm: Floats
    error_mm: float  # largest distance in X from the profile


def _polygon(geometry: Geometry, z_mm: Floats, middle_mm: float) -> Segments:
    """Return the polygon through rounded points of the profile, its error measured."""
    z = np.round(z_mm, LENGTH_DECIMALS)
    x = np.round(geometry.radius_mm(z) - middle_mm, LENGTH_DECIMALS)
    dense = np.linspace(z[0], z[-1], _DENSE)
    drawn = geometry.radius_mm(dense) - middle_mm
    off = np.interp(dense, z, x) - drawn
    return Segments(z, x, float(np.abs(off).max()))


def _kinks_mm(geometry: Geometry, z_first_mm: float, z_last_mm: float) -> Floats:
    """Return the heights between two ends at which the slope of the profile jumps."""
    curve = geometry.radius
    slopes = curve.derivative().c
    before = np.array([np.polyval(slopes[:, i], h) for i, h in enumerate(np.diff(curve.x)[:-1])])
    is_kink = np.abs(slopes[-1, 1:] - before) > _KINK
    heights = curve.x[1:-1][is_kink]
    return np.asarray(heights[(heights > z_first_mm) & (heights < z_last_mm)], dtype=np.float64)


def segments(
    geometry: Geometry, z_first_mm: float, z_last_mm: float, chord_mm: float, middle_mm: float = 0.0
) -> Segments:
    """Return the fewest points on the profile whose polygon keeps a chord error.

    Spacing goes with the curvature, MATHS.md (45). X is below the long half axis by `middle_mm`.
    Raises GeometryError where more than 5000 segments would be needed.
    """
    dense = np.linspace(z_first_mm, z_last_mm, _DENSE)
    density = np.sqrt(np.maximum(np.abs(geometry.radius_mm(dense, 2)), _FLATTEST) / (8 * chord_mm))
    steps = (density[1:] + density[:-1]) / 2 * np.diff(dense)
    sums = np.concatenate([[0.0], np.cumsum(steps)])
    kinks = _kinks_mm(geometry, z_first_mm, z_last_mm)
    n = ceil(sums[-1])
    while n <= _MAX_SEGMENTS:
        places = np.interp(sums[-1] * np.arange(n + 1) / n, sums, dense)
        found = _polygon(geometry, np.union1d(places, kinks), middle_mm)
        if found.error_mm <= chord_mm:
            return found
        n += 1 + n // 50
    problem = f"a chord error of {chord_mm * 1000:g} um needs more than {_MAX_SEGMENTS} segments"
    raise GeometryError("--chord-um", problem, "allow a larger one")


def _engage(job: ProgramJob, x_mm: float) -> list[str]:
    """Return approach and engagement; without its answer nothing is cut.

    Where U swings about X, the tool comes in at full amplitude: at U 0 it would be in the part.
    """
    process = job.part.process
    clear = length("X", job.clear_mm * job.x_factor)
    inwards = [f"G95 G1 {length('X', x_mm)} F{process.feed_mm:.6f}"]
    answer = [
        "M64 P0 ; camturn: start",
        f"M66 P0 L3 Q{_WAIT_S} ; camturn: at full amplitude",
        "o100 if [#<_task> AND [#5399 LT 0]]",
        *(f"  {line}" for line in (_NO_ANSWER, f"G0 {clear}", "M65 P0", "M5", "M2")),
        "o100 endif",
    ]
    return [
        "M65 P0 ; an aborted program left it on: M64 must be a rising edge",
        f"S{process.spindle_rpm:g} {'M3' if process.direction == 1 else 'M4'}",
        f"G0 {clear}",
        f"G0 {length('Z', job.z_first_mm)}",
        *(answer + inwards if job.middle_mm > 0 else inwards + answer),
    ]


def _notes(job: ProgramJob, found: Segments) -> list[str]:
    process = job.part.process
    notes = [
        f"U: camturn, parameter z_is_measured = 1, table {job.part.part.name}.camtab",
        "digital output 0: camturn start / stop; digital input 0: its output in cut",
        f"{found.z_mm.size - 1} segments, chord error {found.error_mm * 1000:.4f} um",
        f"feed {process.feed_mm:g} mm per turn of Z, spindle {process.spindle_rpm:g} r/min",
    ]
    if process.mode == "equal-volume":
        notes.append("the speed of the spindle is camturn's: S is its mean")
    return notes


def profile_program(job: ProgramJob) -> Iterator[bytes]:
    """Return the program in pieces; refuse a path that is no helix, else as `segments`."""
    if job.part.process.path != "helix":
        problem = "a CNC cannot stop Z for some turns of its spindle with G33"
        raise GeometryError("process.path", problem, 'give --axes cxzu, or path = "helix"')
    ends = job.z_first_mm, job.z_last_mm
    found = segments(job.geometry, *ends, job.chord_mm, job.middle_mm)
    return _pieces(job, found)


def _pieces(job: ProgramJob, found: Segments) -> Iterator[bytes]:
    x = found.x_mm * job.x_factor
    yield lines([*head(job, _notes(job, found)), *_engage(job, float(x[0]))])
    # K is measured along the segment; the feed is that of Z: MATHS.md (45).
    slant = np.hypot(1, np.diff(found.x_mm) / np.diff(found.z_mm))
    lead = job.part.process.feed_mm * slant
    words = [("G33 X", LENGTH_DECIMALS), ("Z", LENGTH_DECIMALS), ("K", 9)]
    yield blocks(words, np.stack([x[1:], found.z_mm[1:], lead], axis=1))
    clear = length("X", job.clear_mm * job.x_factor)
    yield lines([f"G0 {clear}", "M65 P0 ; camturn: stop", f"M66 P0 L4 Q{_WAIT_S}", "G94 M5", "M2"])
