"""Errors a user can meet: one line, naming the place, the value and the remedy.

>>> str(InputError("part.toml", "process.feed_mm", 0, "must be above 0", "give mm per turn"))
'part.toml: process.feed_mm = 0: must be above 0; give mm per turn'
"""

from itertools import accumulate

_MAX_VALUE_CHARS = 60
_MOST_CHARS = 2000  # of an error
_LEFT_OUT = " [...] "


def shown(value: object) -> str:
    """Return a value as one short printable ASCII line."""
    try:
        text = ascii(value)
    except (ValueError, RecursionError):  # integers of more than 4300 digits have no decimal form
        text = f"<{type(value).__name__}>"
    return text if len(text) <= _MAX_VALUE_CHARS else text[: _MAX_VALUE_CHARS - 3] + "..."


def one_line(text: str) -> str:
    """Return text with every character that could break a terminal line replaced by '?'.

    >>> one_line("Drehbänke" + chr(27) + "[2J")
    'Drehbänke?[2J'
    """
    return "".join(sign if sign.isprintable() else "?" for sign in text)


def readable(text: str) -> str:
    """Return a message as one line, its middle left out where it is too long to be read.

    >>> len(readable("part.toml: " + "x" * 10_000 + ": too long; shorten it"))
    1999
    """
    line = one_line(text)
    if len(line) <= _MOST_CHARS:
        return line
    half = (_MOST_CHARS - len(_LEFT_OUT)) // 2  # place and value, then problem and remedy
    return line[:half] + _LEFT_OUT + line[-half:]


def first_lines(lines: list[str]) -> list[str]:
    """Return as many lines of an error as can be read at once, and the number of the others.

    >>> first_lines(["a: wrong"] * 500)[-2:]
    ['a: wrong', 'and 250 more']
    """
    n = max(1, sum(end <= _MOST_CHARS for end in accumulate(map(len, lines))))
    return lines if n >= len(lines) else [*lines[:n], f"and {len(lines) - n} more"]


class CamtoolsError(Exception):
    """Base of all errors that are the input's fault; `lines` holds one message per line."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = [readable(line) for line in lines]
        super().__init__("\n".join(self.lines))

    def __reduce__(self) -> tuple[type["CamtoolsError"], tuple[list[str]]]:
        return CamtoolsError, (self.lines,)  # from one process to another


class InputError(CamtoolsError):
    """One field of one file is wrong.

    The file is named as the user did; the field is a dotted path, "" for the file itself; a value
    of None is not shown.
    """

    def __init__(self, file: str, field: str, value: object, problem: str, remedy: str) -> None:
        found = "" if value is None else f" = {shown(value)}"
        place = f"{field}{found}: " if field else ""
        super().__init__([f"{file}: {place}{problem}; {remedy}"])


class GeometryError(CamtoolsError):
    """The numbers are each valid, but the shape is not; `field` is the dotted path to change."""

    def __init__(self, field: str, problem: str, remedy: str) -> None:
        self.field = field
        super().__init__([f"{field}: {problem}; {remedy}"])
