"""What is not drawn: what the compiler judges by itself, and what it does not see on the host."""

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


def unseen(lines: Sequence[str]) -> set[int]:
    """Return the numbers, from 1, of all lines that are compiled for the Cortex-M alone.

    >>> sorted(unseen(["#if defined(__ARM_X)", "a();", "#else", "b();", "#endif", "c();"]))
    [1, 2]
    """
    numbers: set[int] = set()
    is_inside = False
    for number, line in enumerate(lines, start=1):
        is_inside = line.startswith("#if defined(__ARM_") or (
            is_inside and not line.startswith(("#else", "#endif"))
        )
        if is_inside:
            numbers.add(number)
    return numbers
