"""Where the project lies, its version and libraries, and where a result comes from.

A wheel holds the files of the project that the commands read in a folder of the package, at the
same places as in a clone (tools/cmake/CamWheel.cmake).

>>> (ROOT / "tools" / "parts").is_dir()
True
>>> with_names("see tools/run --help")
'see tools/run --help'

>>> from unittest.mock import patch
>>> with patch.dict(os.environ, {"SOURCE_DATE_EPOCH": "86400"}):
...     origin_of("tools/run", ["a part.toml", "-o", "out"])._replace(version="")
Origin(date='1970-01-02 00:00 UTC', version='', command="tools/run 'a part.toml'")

ctypes does at run time what cffi in ABI mode would do, and belongs to Python, so that nothing has
to be installed for it; tests compare the prototypes with the headers.

>>> with patch.dict(os.environ, {"CAMTURN_BUILD": "/no"}):
...     library("x", {}, "A")
Traceback (most recent call last):
camtools.base.errors.CamtoolsError: /no/host_sim/libx.so: cannot be loaded; start A, which builds it

>>> child_environment()["OPENBLAS_NUM_THREADS"]
'1'
"""

import ctypes
import os
import re
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.errors import CamtoolsError

_PACKAGE = Path(__file__).resolve().parents[1]
_TREE = _PACKAGE / "tree"
IS_INSTALLED = _TREE.is_dir()
ROOT = _TREE if IS_INSTALLED else _PACKAGE.parents[1]
RESULTS = Path("build").absolute() if IS_INSTALLED else ROOT / "build"
_HEADER = ROOT / "hal" / "include" / "hal" / "version.h"
VERSION: str = re.findall(r'"([\d.]+)"', _HEADER.read_text(encoding="ascii"))[0]
_SHORT = re.compile(r"\btools/(mktables|mkgcode|camctl)\b")
_LONG = re.compile(r"\btools/(?=(analyse|forecast|identify|live|panel|papers|run|tune)\b)")


def with_names(text: str) -> str:
    """Return a text with the commands as the user starts them: tools/run or camturn-run."""
    return _LONG.sub("camturn-", _SHORT.sub(r"\1", text)) if IS_INSTALLED else text


def shown_name(command: str) -> str:
    """Return what begins a command's messages: run, or camturn-run where it is installed."""
    return with_names(f"tools/{command}").removeprefix("tools/")


_OUTPUT = ("-o", "--output")


class Origin(NamedTuple):
    """What a person needs to repeat a result."""

    date: str
    version: str
    command: str  # without the folder of the results, which changes nothing


def date_text() -> str:
    """Return now, or the time of SOURCE_DATE_EPOCH, to the minute."""
    given = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        when = datetime.now(UTC) if given is None else datetime.fromtimestamp(int(given), UTC)
    except (ValueError, OverflowError, OSError) as error:
        problem = f"SOURCE_DATE_EPOCH = {given}: not a time"
        raise CamtoolsError([f"{problem}; give whole seconds since 1970, or unset it"]) from error
    return when.strftime("%Y-%m-%d %H:%M UTC")


def version_text() -> str:
    """Return what git calls this state of the project, without a clone its version."""
    if not (ROOT / ".git").exists():
        return VERSION
    words = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--tags"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown (git cannot be run)"
    return done.stdout.strip() or "unknown (git cannot tell)"


def command_text(program: str, words: Sequence[str]) -> str:
    """Return a command line without the folder of its results, as a shell takes it."""
    kept: list[str] = []
    skips, is_ours = False, True
    for word in words:
        is_ours = is_ours and word != "--"
        is_output = is_ours and (word in _OUTPUT or word.startswith("--output="))
        if not skips and not is_output:
            kept.append(word)
        skips = is_output and word in _OUTPUT and not skips
    return shlex.join([program, *kept])


def origin_of(program: str, words: Sequence[str]) -> Origin:
    """Return where a result comes from that a command makes now."""
    return Origin(date_text(), version_text(), command_text(with_names(program), words))


Prototypes = Mapping[str, tuple[Any, list[Any]]]  # result and arguments by the function's name


def build_folder() -> Path:
    """Return where simulator and libraries are: below the folder CAMTURN_BUILD, or build/host."""
    build = os.environ.get("CAMTURN_BUILD") or str(ROOT / "build" / "host")
    return Path(build).resolve() / "host_sim"


def library_path(name: str) -> Path:
    """Return the path of a library that is built: "camsim" or "camjudge"."""
    return build_folder() / f"lib{name}.so"


@cache
def _opened(path: Path) -> ctypes.CDLL:
    return ctypes.CDLL(str(path))


def library(name: str, prototypes: Prototypes, builder: str) -> ctypes.CDLL:
    """Return a library, built by the program `builder`, whose functions have their types."""
    path = library_path(name)
    try:
        opened = _opened(path)
        for function_name, (result, arguments) in prototypes.items():
            function = getattr(opened, function_name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        problem = f"{path}: cannot be loaded"
        raise CamtoolsError([f"{problem}; start {builder}, which builds it"]) from error
    return opened


def child_environment() -> dict[str, str]:
    """Return the environment, with the project found from any working folder."""
    paths = [str(ROOT / "tools"), *filter(None, os.environ.get("PYTHONPATH", "").split(":"))]
    return os.environ | {
        "PYTHONPATH": ":".join(dict.fromkeys(paths)),
        "OPENBLAS_NUM_THREADS": "1",  # as tools/setup.sh has it: last digits depend on it
    }
