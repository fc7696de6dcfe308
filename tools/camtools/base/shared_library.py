"""Shared libraries of this project, called by ctypes.

ctypes does at run time what cffi in ABI mode would do, and belongs to Python, so that nothing has
to be installed for it; tests compare the prototypes with the headers.

>>> loaded(Path("nowhere.so"), {}, "tools/run")
Traceback (most recent call last):
camtools.base.errors.CamtoolsError: nowhere.so: cannot be loaded; start tools/run, which builds it
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from camtools.base.errors import CamtoolsError

Prototypes = Mapping[str, tuple[Any, list[Any]]]  # result and arguments by the function's name


def loaded(path: Path, prototypes: Prototypes, builder: str) -> ctypes.CDLL:
    """Return a library whose functions have their types.

    Parameters
    ----------
    builder : str
        Program that builds the library, for the message.

    Raises
    ------
    CamtoolsError
        The library is missing or lacks a function.
    """
    try:
        library = ctypes.CDLL(str(path))
        for name, (result, arguments) in prototypes.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        problem = f"{path}: cannot be loaded"
        raise CamtoolsError([f"{problem}; start {builder}, which builds it"]) from error
    return library
