r"""Words, blocks and frames of NC programs in the dialect of LinuxCNC.

>>> blocks([("X", 3)], np.array([[1.0], [-0.0001]]))
b'X1.000\nX0.000\n'
"""

from collections.abc import Iterable, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.cut.path import ToolPath
from camtools.skirt.geometry.skirt_geometry import Geometry, blank_radius_mm
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.turning import middle_nm

LENGTH_DECIMALS = 6  # of millimetres: a nanometre
ANGLE_DECIMALS = 5  # of degrees
CLEARANCE_MM = 2.0  # tool off the blank before and after

ENGAGE_TURNS = 10  # as the controller's engage_turns

Word = tuple[str, int]
"""Letter and decimals."""


class ProgramJob(NamedTuple):
    """What a program is made of."""

    part: SkirtPart
    geometry: Geometry
    z_first_mm: float
    z_last_mm: float
    chord_mm: float  # of the X/Z program; how far the planner may cut corners of any
    is_diameter: bool  # X is twice the radius

    @property
    def x_factor(self) -> float:
        """Return X per radius."""
        return 2.0 if self.is_diameter else 1.0

    @property
    def middle_mm(self) -> float:
        """Return the reduction of the radius that X carries instead of U."""
        return middle_nm(self.geometry, self.part.process.u_zero) / NM_PER_MM

    @property
    def clear_mm(self) -> float:
        """Return the radius at which the tool is off the blank."""
        return blank_radius_mm(self.geometry, self.part.process.depth_mm) + CLEARANCE_MM


def envelope(path: ToolPath, turns: Floats) -> Floats:
    """Return the quintic smooth step of depth and amplitude before and after the path."""
    s = np.clip(np.minimum(turns, ceil(path.turns) - turns) / ENGAGE_TURNS + 1, 0, 1)
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2), dtype=np.float64)


def blocks(words: Sequence[Word], values: Floats) -> bytes:
    """Return n blocks of the same m words; `values` of shape (n, m)."""
    line = " ".join(f"{letter}%.{decimals}f" for letter, decimals in words) + "\n"
    exact = np.empty_like(values)
    for i, (_, decimals) in enumerate(words):
        np.round(values[:, i], decimals, out=exact[:, i])
    exact += 0.0  # -0 becomes 0
    return (line * len(exact) % tuple(exact.ravel().tolist())).encode("ascii")


def length(letter: str, value_mm: float) -> str:
    """Return a word with a length."""
    return f"{letter}{value_mm:z.{LENGTH_DECIMALS}f}"


def lines(text: Iterable[str]) -> bytes:
    """Return lines as bytes."""
    return "".join(f"{line}\n" for line in text).encode("ascii")


def head(job: ProgramJob, notes: Iterable[str]) -> list[str]:
    """Return the lines that a program of a skirt begins with."""
    x = "twice the radius" if job.is_diameter else "radius"
    of = "the long half axis" if job.part.process.u_zero == "long-axis" else "U swings about it"
    comments = (
        f"{job.part.part.name}: made by mkgcode for LinuxCNC, lengths in mm",
        f"Z: height of the skirt on the drawing, {job.z_first_mm:g} .. {job.z_last_mm:g}",
        f"X: {x} that the tool tip turns at U 0, {of}",
        *notes,
    )
    return opening(comments, job.chord_mm, is_diameter=job.is_diameter)


def opening(comments: Iterable[str], chord_mm: float, *, is_diameter: bool) -> list[str]:
    """Return comments, and the modes in which every program runs."""
    radius = "G7" if is_diameter else "G8"
    setting = (f"G18 G21 G40 G49 G80 G90 {radius}", f"G64 P{chord_mm:.{LENGTH_DECIMALS}f} Q0")
    return [f"; {comment}" for comment in comments] + list(setting)
