"""What is not drawn because the compiler judges it by itself."""

from __future__ import annotations

from collections.abc import Sequence


def asserted(lines: Sequence[str]) -> set[int]:
    r"""Return the numbers, from 1, of all lines of every _Static_assert.

    >>> sorted(asserted(["int a;", "_Static_assert(A == 1 &&", "  B == 2, \"both\");", "int b;"]))
    [2, 3]
    """
    numbers: set[int] = set()
    is_inside = False
    for number, line in enumerate(lines, start=1):
        is_inside = is_inside or "_Static_assert(" in line
        if is_inside:
            numbers.add(number)
        is_inside = is_inside and ");" not in line
    return numbers
