"""Print what a tolerance costs in bytes, as rows of a table.

>>> from camtools.skirt.part.part_file import example_part
>>> row(example_part(), 1.0)
'| 1 | 3456 | 32 | 16 (8) | 10 | 0.378 | 0.717 |'
"""

import sys
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.pipeline.load import load_for
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import generate
from camtools.table.channel import KIND_U, KIND_X
from camtools.table.image import pack

TOLERANCES_NM = (100.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01)
_HEADER = """\
| tolerance nm | bytes | u slices | u knots per turn (stored) | x knots | error u nm | error x nm |
|---|---|---|---|---|---|---|
"""


def row(part: SkirtPart, tolerance_nm: float) -> str:
    """Return one line of the table: what this tolerance takes."""
    result = generate(part, tolerance_nm)
    u, x = result.table.channel(KIND_U), result.table.channel(KIND_X)
    stored = u.knots.shape[1]
    cells = [
        *(f"{tolerance_nm:g}", f"{len(pack(result.table))}", f"{u.n_slices}"),
        *(f"{stored << u.log2_repeat} ({stored})", f"{x.n_slices}"),
        *(f"{result.accuracy_u.value_nm:.3f}", f"{result.accuracy_x.value_nm:.3f}"),
    ]
    return f"| {' | '.join(cells)} |"


def main(argv: list[str]) -> int:
    """Print the table for the part file given; return the exit status."""
    if len(argv) != 1:
        sys.stderr.write("usage: python -m camtools.papers.size_by_tolerance PART.toml\n")
        return 2
    try:
        part = load_for("trade", SkirtPart, Path(argv[0]))
        rows = [row(part, tolerance_nm) for tolerance_nm in TOLERANCES_NM]
    except CamtoolsError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(_HEADER + "\n".join(rows) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
