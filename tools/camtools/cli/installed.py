"""The commands of an installed package: each script of tools/pyproject.toml starts here.

>>> remedy("panel")
"pip install 'camturn[panel]'"
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path

from camtools.base.project import VERSION

_EXTRAS = ("panel", "forecast")


def remedy(command: str) -> str:
    """Return how to get the packages that a command needs on top."""
    extra = f"[{command}]" if command in _EXTRAS else ""
    return f"pip install 'camturn{extra}'"


def main() -> int:
    """Run the command that this process was started as; return its exit status."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as tools/setup.sh, before numpy is loaded
    script = Path(sys.argv[0]).name
    name = script.removeprefix("camturn-")
    if sys.argv[1:] == ["--version"]:  # needs no extra
        print(f"{script} {VERSION}")
        return 0
    try:
        status: int = import_module(f"camtools.cli.{name}").main()
    except ModuleNotFoundError as error:
        sys.stderr.write(f"{script}: needs the Python package {error.name}; {remedy(name)}\n")
        return 2
    return status
