"""By which table a gauged part was cut: its NAME.json, and whether both belong together.

>>> is_alike({"a": [1.0, "x"]}, {"a": [1.0 + 1e-13, "x"]}), is_alike({"a": 1.0}, {"a": 1.1})
(True, False)
"""

from __future__ import annotations

import json
from math import isclose
from pathlib import Path
from typing import NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.json_text import Json
from camtools.cut.correction import Correction, correction_of

_MAX_BYTES = 64 * 1024 * 1024
_SUMMARY = "summary.json"  # that camsim and tools/run write beside a surface
_RELATIVE, _ABSOLUTE = 1e-9, 1e-12


class Previous(NamedTuple):
    """The table that cut a part."""

    path: Path
    crc32: int
    report: Json
    correction: Correction | None


def is_alike(one: object, other: object) -> bool:
    """Return whether two JSON values are the same but for rounding."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(is_alike, one, other))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return isclose(one, other, rel_tol=_RELATIVE, abs_tol=_ABSOLUTE)
    return bool(one == other)


def read_given(path: Path, option: str, most_bytes: int = _MAX_BYTES) -> bytes:
    """Return the content of a file that an option names.

    Raises
    ------
    CamtoolsError
        It cannot be read.
    """
    try:
        return read_limited(path, most_bytes)
    except (OSError, ValueError) as error:  # a path with a NUL is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
        raise CamtoolsError([f"{option} {path}: cannot be read: {reason}; give a file"]) from error


def _report(path: Path) -> Json:
    """Return the report of a table."""
    try:
        report = json.loads(read_given(path, "--previous"))
        is_report = {"part", "design", "table_crc32"} <= report.keys()
    except (ValueError, AttributeError):
        is_report = False
    if not is_report:
        problem = "not a NAME.json of mktables"
        raise CamtoolsError([f"--previous {path}: {problem}; give that of the table that cut it"])
    found: Json = report
    return found


def _crc32(value: object) -> int:
    """Return a CRC-32 that is a number, or a string in hexadecimal."""
    return int(value, 16) if isinstance(value, str) else int(str(value))


def _check_summary(surface: Path, path: Path, crc32: int) -> None:
    """Refuse a surface whose summary beside it names another table."""
    summary = surface.parent / _SUMMARY
    if not summary.is_file():
        return
    try:
        other = _crc32(json.loads(read_given(summary, "--measured"))["table_crc32"])
    except (ValueError, TypeError, KeyError):
        return
    if other != crc32:
        problem = (
            f"{_SUMMARY} next to it names table 0x{other:08x}, but {path} is of table "
            f"0x{crc32:08x}: another table cut the part"
        )
        raise CamtoolsError([f"--measured {surface}: {problem}; give its NAME.json by --previous"])


def find_previous(surface: Path, given: Path | None, name: str, design: Json) -> Previous:
    """Return the table that cut a gauged part.

    Parameters
    ----------
    surface : Path
        The gauged surface.
    given : Path or None
        NAME.json of the table; by default it is looked for beside the surface.
    name, design : str, dict
        Of the part whose next table is to be made.

    Raises
    ------
    CamtoolsError
        There is none, or it is not known to be of this part and surface.
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
    drawn = {key: value for key, value in report["design"].items() if key != "gauge_mm"}
    if not is_alike(drawn, design):
        problem = "not the drawing of the part file, so the surface belongs to another one"
        remedy = "measure a part that the table of this part file has cut"
        raise CamtoolsError([f"--previous {path}: design: {problem}; {remedy}"])
    crc32 = _crc32(report["table_crc32"])
    _check_summary(surface, path, crc32)
    return Previous(path, crc32, report, _correction(path, report))


def _correction(path: Path, report: Json) -> Correction | None:
    if "correction" not in report:
        return None
    try:
        return correction_of(report["correction"])
    except (KeyError, TypeError, ValueError) as error:
        problem = "correction: not as mktables writes it"
        raise CamtoolsError([f"--previous {path}: {problem}; make the table again"]) from error
