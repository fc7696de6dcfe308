"""Command line that makes every figure and table of the papers anew.

>>> [module.KEY for module in MODULES][:2]
['S0, S1', 'S2']
"""

from __future__ import annotations

import sys

from camtools.base.arguments import Folder, command
from camtools.base.files import write_all
from camtools.base.text import csv_text
from camtools.papers import corner, helix, lobe, removal
from camtools.papers.declared import filled, page
from camtools.papers.figures import PICTURES
from camtools.plots.style import pictures

PAGE = "papers.md"
MODULES = (removal, corner, helix, lobe)


def papers(output: Folder) -> int:
    """Reproduce every figure and table of the papers, beside the printed values.

    A page compares them.
    """
    found = [filled(module.KEY, module.quantities()) for module in MODULES]
    files = {PAGE: page(found).encode("utf-8")}
    for module in MODULES:
        files |= {name: csv_text(columns()).encode() for name, columns in module.TABLES.items()}
        files |= pictures(PICTURES[module.KEY]())
    write_all(output, files)
    n = sum(len(paper.rows) for paper in found)
    sys.stdout.write(f"{n} figures and tables, {len(files) - 1} files; {PAGE} compares them\n")
    return 0


main = command("tools/papers", papers)

if __name__ == "__main__":
    sys.exit(main())
