"""Tables of parts and their cuts: each part of the repository is made once in a process."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from camtools.base.quantities import Floats
from camtools.cut.correction import Correction
from camtools.pipeline.load import Loaded, Made, load, make
from camtools.sim.simulate import Result
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.image import Table, pack
from tests.tools.cases.camsim_cases import camsim, cut
from tests.tools.cases.part_cases import ROOT, load_part, parse_part

PARTS = ROOT / "tools" / "parts"
NM = 1e-6  # mm


@cache
def made_of(name: str) -> Made:
    """Return the table of a part of tools/parts."""
    path = PARTS / f"{name}.toml"
    return make(load(path), path)


def skirt_of(name: str) -> GeneratedSkirt:
    """Return the table of a skirt of tools/parts."""
    made: GeneratedSkirt = made_of(name).table
    return made


@cache
def geometry_of_part(name: str) -> Geometry:
    """Return the geometry of a skirt of tools/parts."""
    return make_geometry(load_part(PARTS / f"{name}.toml"))


def made_skirt(
    part: SkirtPart, tolerance_nm: float | None = None, correction: Correction | None = None
) -> Made:
    """Return the table of a skirt."""
    loaded = Loaded(KIND, part)
    return make(loaded, "a.toml", tolerance_nm=tolerance_nm, correction=correction)


def written(made: Made, folder: Path) -> Path:
    """Write the files of a table into a folder; return the table."""
    folder.mkdir(exist_ok=True)
    for name, data in made.files(with_plots=False).items():
        (folder / name).write_bytes(data)
    return folder / f"{made.table.part.part.name}.camtab"


def written_skirt(text: str, folder: Path) -> Path:
    """Write the files of the table of a part file's text into a folder; return the table."""
    return written(made_skirt(parse_part(text, folder=folder)), folder)


def evaluated(folder: Path, table: Table, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the columns that the firmware's own evaluation gives at points."""
    path = folder / "evaluated.camtab"
    path.write_bytes(pack(table))
    return file_evaluated(path, turn, z_mm)


def file_evaluated(table: Path, turn: Floats, z_mm: Floats) -> dict[str, Floats]:
    """Return the same of a table's file."""
    rows = "".join(f"{t!r},{z!r}\n" for t, z in zip(turn.tolist(), z_mm.tolist(), strict=True))
    done = camsim("eval", table, stdin=f"turn,z_mm\n{rows}")
    assert done.returncode == 0, done.stderr
    head, *lines = done.stdout.splitlines()
    values = np.array([line.split(",") for line in lines], dtype=np.float64)
    return dict(zip(head.split(","), values.T, strict=True))


def tip_mm(values: dict[str, Floats]) -> Floats:
    """Return where evaluated tables put the tip of the tool."""
    return np.asarray((values["x_nm"] - values["u_nm"]) * NM)


def cut_made(
    made: Made,
    folder: Path,
    *words: str | Path,
    status: int | None = 0,
    tables: Sequence[str] = ("surface",),
) -> Result:
    """Cut a part on its own machine, to its own tolerance."""
    table = written(made, folder)
    part = made.table.part
    tolerance, machine = part.process.form_error_um, made.kind.machine(part)
    words = ("--tolerance-um", str(tolerance), *words)
    return cut(table, *words, status=status, tables=tables, machine=machine)
