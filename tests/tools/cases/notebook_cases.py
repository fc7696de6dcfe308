r"""Notebooks of the documentation are executed, cell after cell, as Jupyter would.

    python tests/tools/cases/notebook_cases.py NOTEBOOK    # executes it and keeps what it prints

>>> printed(["a = 6\n", "print(7 * a)"], {})
'42\n'
"""

import contextlib
import io
import json
import sys
from pathlib import Path
from typing import Any


def printed(source: list[str], space: dict[str, Any]) -> str:
    """Run a cell in the names of those before it; return what it prints."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile("".join(source), "<cell>", "exec"), space)
    return said.getvalue()


def kept(cell: dict[str, Any]) -> str:
    """Return what the notebook says that a cell prints."""
    return "".join(line for output in cell["outputs"] for line in output["text"])


def code_cells(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return a notebook and its cells of code."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return notebook, [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def main(path: Path) -> int:
    """Execute a notebook and write what its cells print into it."""
    notebook, cells = code_cells(path)
    space: dict[str, Any] = {}
    for cell in cells:
        lines = printed(cell["source"], space).splitlines(keepends=True)
        stream = {"name": "stdout", "output_type": "stream", "text": lines}
        cell["outputs"] = [stream] if lines else []
    text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
