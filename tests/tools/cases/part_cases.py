"""Places and processes that several tests of the table generator use."""

import os
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from numpy.typing import ArrayLike

from camtools.base.errors import CamtoolsError
from camtools.pipeline.load import load_for, parse_for
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.camsim_cases import BUILD

ROOT = Path(__file__).resolve().parents[3]
PERKINS = ROOT / "tools" / "parts" / "perkins240.toml"

Command = Callable[..., subprocess.CompletedProcess[str]]
Capture = pytest.CaptureFixture[str]
TableOf = Callable[[str], Path]
T = TypeVar("T")


def environment() -> dict[str, str]:
    """Return the environment in which a child finds camtools and the build, in any folder."""
    return os.environ | {"PYTHONPATH": str(ROOT / "tools"), "CAMTURN_BUILD": str(BUILD)}


def load_part(path: Path) -> SkirtPart:
    """Return the skirt of a part file, as the commands for skirts alone read it."""
    return load_for("analyse", SkirtPart, path)


def parse_part(text: str | bytes, file: str = "part.toml", folder: Path = Path()) -> SkirtPart:
    """Return the skirt that a part file describes."""
    data = text.encode() if isinstance(text, str) else text
    return parse_for("analyse", SkirtPart, data, file, folder)


def points_text(header: str, *columns: ArrayLike) -> str:
    """Return a file of points: columns, or what they are broadcast to, with all their digits."""
    cells = np.stack([one.ravel() for one in np.broadcast_arrays(*columns)], axis=1)
    rows = [",".join(map(repr, row)) for row in cells.astype(np.float64).tolist()]
    return "\n".join([header, *rows, ""])


POINTS_PART = """\
[part]
name = "points"
kind = "piston"
source = "Invented."
[piston.profile]
height_mm = {height_mm}
diameter_mm = [80, 80]
[piston.section]
shape = "table"
csv = "points.csv"
{more}
[process]
spindle_rpm = 600
feed_mm = 0.5
direction = {direction}
"""


def points_part(
    folder: Path, text: str, more: str = "", height_mm: str = "[0, 24]", direction: int = 1
) -> SkirtPart:
    """Return a cylinder of 80 mm with a file of measured points, and `more` keys of its section."""
    (folder / "points.csv").write_text(text)
    keys = {"more": more, "height_mm": height_mm, "direction": direction}
    (folder / "points.toml").write_text(POINTS_PART.format_map(keys))
    return load_part(folder / "points.toml")


OVAL_PART = """\
[part]
name = "{name}"
kind = "piston"
source = "Invented."
[piston.profile]
height_mm = [0, {high_mm}]
diameter_mm = [{diameter_mm}, {diameter_mm}]
[piston.ovality]
height_mm = [0, {high_mm}]
ovality_mm = {ovality_mm}
{more}
[process]
spindle_rpm = 1500
{process}
"""


def oval_text(
    name: str, size_mm: tuple[float, float], ovality_mm: list[float], process: str, more: str = ""
) -> str:
    """Return a part file of equal long axes: height and diameter, ovality at its ends, tables."""
    keys = {"name": name, "high_mm": size_mm[0], "diameter_mm": size_mm[1]}
    return OVAL_PART.format(**keys, ovality_mm=ovality_mm, process=process, more=more)


def changed(part: SkirtPart, values: Mapping[str, object]) -> SkirtPart:
    """Return a skirt with other values of keys or whole tables, named as "piston.profile"."""
    tree = part.model_dump(exclude_none=True)
    for path, value in values.items():
        *tables, key = path.split(".")
        place = tree
        for table in tables:
            place = place[table]
        place[key] = value
    return SkirtPart.model_validate(tree)


def sure(value: T | None) -> T:
    """Return a value, which must be there."""
    assert value is not None
    return value


def refused_lines(
    work: Callable[[], object], error: type[CamtoolsError] = CamtoolsError
) -> list[str]:
    """Return the lines with which a call is refused."""
    with pytest.raises(error) as info:
        work()
    return info.value.lines


def refused(work: Callable[[], object], error: type[CamtoolsError] = CamtoolsError) -> str:
    """Return the only line with which a call is refused."""
    [line] = refused_lines(work, error)
    return line


def listing(folder: Path) -> list[str]:
    """Return all names in a folder, hidden ones too."""
    return sorted(path.name for path in folder.iterdir())
