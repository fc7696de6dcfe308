"""Errors a user can meet: one line, naming the place, the value and the remedy.

>>> str(InputError("part.toml", "process.feed_mm", 0, "must be above 0", "give mm per turn"))
'part.toml: process.feed_mm = 0: must be above 0; give mm per turn'
"""

import re

_MAX_VALUE_CHARS = 60
_ONLY_NUMBERS = re.compile(r"(?:[-+0-9.eE,; \t\"]|nan|inf)*")


def shown(value: object) -> str:
    """Return a value as one short printable ASCII line."""
    try:
        text = ascii(value)
    except (ValueError, RecursionError):  # integers of more than 4300 digits have no decimal form
        text = f"<{type(value).__name__}>"
    return text if len(text) <= _MAX_VALUE_CHARS else text[: _MAX_VALUE_CHARS - 3] + "..."


def numbers_shown(line: str) -> str | None:
    """Return a line of a data file if nothing but numbers and separators stands in it.

    A part file from somebody else may name any file of the reader's, a list of passwords for
    one; an error about such a file must not show what is in it.
    """
    return line if _ONLY_NUMBERS.fullmatch(line) else None


def one_line(text: str) -> str:
    """Return text with every character that could break a terminal line replaced by '?'.

    >>> one_line("Drehbänke" + chr(27) + "[2J")
    'Drehbänke?[2J'
    """
    return "".join(sign if sign.isprintable() else "?" for sign in text)


class CamtoolsError(Exception):
    """Base of all errors that are the input's fault; `lines` holds one message per line."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = [one_line(line) for line in lines]
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
