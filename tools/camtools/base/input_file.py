"""Files that the user names are read whole, within bounds, and never waited for.

>>> try:
...     read_limited(Path("."), 10)
... except OSError as error:
...     print(error.strerror)
Is a directory
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from camtools.base.errors import InputError


def read_limited(path: Path, most_bytes: int) -> bytes:
    """Return the content of a file.

    Raises
    ------
    OSError
        It cannot be read, is no regular file (a pipe would be waited for, a device may never end),
        or is larger; `strerror` says which.
    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "not a file")
    with path.open("rb") as stream:
        data = stream.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise OSError(errno.EFBIG, f"larger than {most_bytes} bytes")
    return data


def read_text(path: Path, most_bytes: int) -> str:
    """Return the text of a file that a part file names; a mark of spreadsheets is left out.

    Raises
    ------
    InputError
        It cannot be read, is no file or too large (`read_limited`), or is not UTF-8.
    """
    try:
        return read_limited(path, most_bytes).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError, ValueError) as error:  # a path with a NUL is a ValueError
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        remedy = "give a text file, with its path relative to the part file"
        raise InputError(path.name, "", None, f"cannot be read: {reason}", remedy) from error


def read_whole_table(path: Path, most_bytes: int) -> str:
    """Return the text of a table of measured numbers, as `read_text`.

    Raises
    ------
    InputError
        Its last line does not end: a file that was cut short may stop within a number.
    """
    text = read_text(path, most_bytes)
    if text and not text.endswith(("\n", "\r")):
        place, last = f"line {len(text.splitlines())}", text.splitlines()[-1]
        problem = "the file stops within this line, so it may have been cut short"
        remedy = "copy it again, or end the line if it is complete"
        raise InputError(path.name, place, last[-40:], problem, remedy)
    return text
