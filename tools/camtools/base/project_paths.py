"""Where the project lies, and its version.

A wheel holds the files of the project that the commands read in a folder of the package, at the
same places as in a clone (tools/cmake/CamWheel.cmake).

>>> (ROOT / "tools" / "parts").is_dir()
True
>>> with_names("see tools/run --help")
'see tools/run --help'
"""

from __future__ import annotations

import re
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_TREE = _PACKAGE / "tree"
IS_INSTALLED = _TREE.is_dir()
ROOT = _TREE if IS_INSTALLED else _PACKAGE.parents[1]
RESULTS = Path("build").absolute() if IS_INSTALLED else ROOT / "build"
_HEADER = ROOT / "hal" / "include" / "hal" / "version.h"
VERSION: str = re.findall(r'"([\d.]+)"', _HEADER.read_text(encoding="ascii"))[0]
_SHORT = re.compile(r"\btools/(mktables|mkgcode|camctl)\b")
_LONG = re.compile(
    r"\btools/(?=(analyse|forecast|identify|keys|live|panel|papers|run|scallop|tune)\b)"
)


def with_names(text: str) -> str:
    """Return a text with the commands as the user starts them: tools/run or camturn-run."""
    return _LONG.sub("camturn-", _SHORT.sub(r"\1", text)) if IS_INSTALLED else text


def shown_name(command: str) -> str:
    """Return what begins a command's messages: run, or camturn-run where it is installed.

    >>> shown_name("run")
    'run'
    """
    return with_names(f"tools/{command}").removeprefix("tools/")
