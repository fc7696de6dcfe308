"""The first half of the pipeline: from a part file to the files of its table.

>>> from camtools.base.project_paths import ROOT
>>> from camtools.pipeline.load import load
>>> made = make(load(ROOT / "tools" / "parts" / "cam-disc.toml"), "cam-disc.toml")
>>> sorted(made.files(with_plots=False))
['cam-disc.camtab', 'cam-disc.json', 'cam-disc_table.c', 'cam-disc_table.h']
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.cut.correction import Correction
from camtools.pipeline.kind import AnyKind
from camtools.pipeline.load import Loaded
from camtools.table.summary import table_files


class Made(NamedTuple):
    """A table with its kind."""

    kind: AnyKind
    table: Any  # what the kind knows about it

    def text(self) -> str:
        """Return what is known about the table, in a few lines for people."""
        return self.kind.text(self.kind.summary(self.table))

    def files(self, *, with_plots: bool) -> dict[str, bytes]:
        """Return the content of every file of the table, by file name."""
        image = self.table.table
        files = table_files(image, self.kind.summary(self.table))
        if with_plots:
            plots = self.kind.plots(self.table)
            files |= {f"{image.part_name}_{topic}.png": png for topic, png in plots.items()}
        return files


def make(
    loaded: Loaded,
    file: Path | str,
    *,
    tolerance_nm: float | None = None,
    rpm: float | None = None,
    correction: Correction | None = None,
) -> Made:
    """Return the table of a part, made for another speed where the kind's tables depend on it.

    Raises
    ------
    CamtoolsError
        It cannot be made; the file's name is in every line.
    """
    kind, part = loaded
    try:
        part = kind.at_speed(part, rpm)
        if correction is None:
            return Made(kind, kind.make(part, tolerance_nm))
        return Made(kind, kind.make_corrected(part, tolerance_nm, correction))
    except CamtoolsError as error:
        lines = [line + _hint(line, correction) for line in error.lines]
        raise CamtoolsError([f"{file}: {line}" for line in lines]) from error


def _hint(line: str, correction: Correction | None) -> str:
    """Return what a correction has to do with a refusal of what U can follow."""
    if correction is None or ".u_" not in line:
        return ""
    return "; or leave the high waves of the correction out by --keep-harmonics"
