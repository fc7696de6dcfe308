# SPDX-License-Identifier: Apache-2.0
"""What lies in build/run: the results of earlier runs, a folder each, and which of them are kept.

A folder counts as a run when its summary.json is one of tools/run; nothing else is ever removed.

>>> import os, tempfile
>>> folder = Path(tempfile.mkdtemp())
>>> for made_s, name in enumerate(("one", "two")):
...     (folder / name).mkdir()
...     _ = (folder / name / "summary.json").write_text('{"run_wall_time_s": 1}')
...     os.utime(folder / name / "summary.json", (made_s, made_s))
>>> [run.name for run in drop_all_but(folder, 1)], kept_text(folder)
(['one'], '1 run, 22 bytes: two')
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import NamedTuple

from camtools.base.readable import size_text
from camtools.sim.camsim import SUMMARY

_MARK = "run_wall_time_s"  # no summary but that of tools/run has it
_MOST_NAMED = 6


class Kept(NamedTuple):
    """The results of a run."""

    name: str
    made_s: float
    n_bytes: int


def _is_run(folder: Path) -> bool:
    try:
        return _MARK in json.loads((folder / SUMMARY).read_bytes())
    except (OSError, ValueError, TypeError):
        return False


def runs(place: Path) -> list[Kept]:
    """Return the runs in a folder, the newest first."""
    found = []
    for folder in place.iterdir() if place.is_dir() else ():
        if folder.is_dir() and not folder.is_symlink() and _is_run(folder):
            n_bytes = sum(f.lstat().st_size for f in folder.rglob("*") if f.is_file())
            found.append(Kept(folder.name, (folder / SUMMARY).stat().st_mtime, n_bytes))
    return sorted(found, key=lambda run: (-run.made_s, run.name))


def drop_all_but(place: Path, n: int) -> list[Kept]:
    """Remove the oldest runs until so many are left; return those that were removed."""
    dropped = runs(place)[n:]
    for run in dropped:
        shutil.rmtree(place / run.name, ignore_errors=True)
    return dropped


def kept_text(place: Path) -> str:
    """Return what lies there in one line."""
    found = runs(place)
    if not found:
        return "no runs"
    names = [run.name for run in found]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    total = size_text(sum(run.n_bytes for run in found))
    count = f"{len(found)} run" + ("s" if len(found) != 1 else "")
    return f"{count}, {total}: {', '.join(names[:_MOST_NAMED])}{more}"
