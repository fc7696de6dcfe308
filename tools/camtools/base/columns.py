r"""Lines of numbers with commas, semicolons, or blanks and tabs between them.

The first line names the columns, and shows by its separator how the others are written; with
semicolons a decimal comma is read as well as a point.

>>> columns = Columns("angle_deg; height_mm")
>>> columns.names, columns.numbers("0,5;12")
(['angle_deg', 'height_mm'], [0.5, 12.0])
>>> Columns("a b\tc").numbers("1\t2 3")
[1.0, 2.0, 3.0]
"""

from __future__ import annotations

from collections.abc import Sequence


class Columns:
    """How the lines of a file are written.

    Attributes
    ----------
    separator : str or None
        None: blanks and tabs.
    names : list of str
        Of the columns.
    """

    def __init__(self, header: str) -> None:
        self.separator = next((one for one in (";", ",") if one in header), None)
        self.names = [name.strip() for name in header.split(self.separator)]

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line."""
        text = line.replace(",", ".") if self.separator == ";" else line
        return text.split(self.separator)

    def numbers(self, line: str, places: Sequence[int] | None = None) -> list[float]:
        """Return the numbers of a line, of all its columns or of some.

        Raises
        ------
        ValueError, IndexError
            A cell is missing or no number.
        """
        cells = self.cells(line)
        chosen = cells if places is None else [cells[place] for place in places]
        return [float(cell) for cell in chosen]
