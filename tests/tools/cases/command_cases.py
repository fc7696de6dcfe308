# SPDX-License-Identifier: Apache-2.0
"""Commands of camtools in processes of their own, as a shell starts them.

To import the libraries takes longer than most commands do. So `command` forks them off a process
that has imported everything already; it starts with the first command and ends with the tests.
What may depend on how a process begins, as the order of sets does, takes `fresh_command`.
"""

import importlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import IO, Any, NoReturn

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from tests.tools.cases.part_cases import ROOT, environment

IMPORTED = (
    *(f"camtools.cli.{name}" for name in ("run", "mktables", "mkgcode")),
    *(
        f"camtools.{kind}.{name}"
        for kind in ("skirt", "lobe", "polygon")
        for name in ("kind", "report")
    ),
    # what they import where they need it
    *("pandas", "plotly.offline", "pyarrow.csv", "pyarrow.dataset", "pyarrow.parquet"),
)
LIMIT_S = 120  # a command that goes on for longer is ended by SIGALRM


def command(
    module: str,
    *words: str | Path,
    cwd: Path | None = None,
    largest_file: int | None = None,
    draws: bool = True,
    **settings: str,
) -> subprocess.CompletedProcess[str]:
    """Run the command of a module in a folder, with settings in its environment.

    Parameters
    ----------
    largest_file : int
        Bytes beyond which a file cannot be written, as on a disk that is full.
    draws : bool
        False leaves pictures empty, for tests of what else there is; drawing takes the longest.
    """
    server = _server()
    with tempfile.TemporaryDirectory() as folder:
        order: dict[str, Any] = {
            "module": module,
            "words": [str(word) for word in words],
            "cwd": str(cwd or Path.cwd()),
            "environment": environment() | settings,
            "largest_file": largest_file,
            "draws": draws,
            "output": [f"{folder}/stdout", f"{folder}/stderr"],
        }
        _pipe(server.stdin).write(json.dumps(order) + "\n")
        _pipe(server.stdin).flush()
        status = _pipe(server.stdout).readline()
        assert status, "the process that commands are forked off has ended: see its stderr"
        said = [Path(path).read_text() for path in order["output"]]
    return subprocess.CompletedProcess([module, *order["words"]], int(status), *said)


def fresh_command(
    module: str, *words: str | Path, cwd: Path | None = None, **settings: str
) -> subprocess.CompletedProcess[str]:
    """Run it in a new interpreter."""
    return subprocess.run(
        [sys.executable, "-m", module, *map(str, words)],
        cwd=cwd,
        env=environment() | settings,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )


def complaint(
    main: Callable[[list[str]], int], words: list[str], capture: pytest.CaptureFixture[str]
) -> str:
    """Run a command in this process, which must end with status 2; return its only line."""
    try:
        status = main(words)
    except SystemExit as end:
        status = int(str(end.code))
    (line,) = capture.readouterr().err.splitlines()
    assert status == 2, line
    return line


def end_commands() -> None:
    """End the process that commands are forked off."""
    if _server.cache_info().currsize:
        _server().communicate()
        _server.cache_clear()


def leave_empty(canvas: FigureCanvasAgg) -> None:
    """Take the place of the drawing of a picture, whose pixels are there all the same."""
    canvas.get_renderer()  # type: ignore[no-untyped-call]


@cache
def _server() -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    env = environment()
    env["PYTHONPATH"] += f"{os.pathsep}{ROOT}"
    words = [sys.executable, "-m", "tests.tools.cases.command_cases"]
    return subprocess.Popen(words, env=env, stdin=pipe, stdout=pipe, text=True)


def _pipe(stream: IO[str] | None) -> IO[str]:
    assert stream is not None
    return stream


def _carry_out(order: Mapping[str, Any]) -> NoReturn:
    """Become the command."""
    signal.alarm(LIMIT_S)
    os.environ.clear()
    os.environ.update(order["environment"])
    os.chdir(order["cwd"])
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for descriptor, path in enumerate(order["output"], start=1):
        os.dup2(os.open(path, os.O_CREAT | os.O_WRONLY | os.O_APPEND), descriptor)
    if order["largest_file"] is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (order["largest_file"],) * 2)
    if not order["draws"]:
        setattr(FigureCanvasAgg, "draw", leave_empty)  # noqa: B010 - mypy forbids the assignment
    sys.argv = [order["module"], *order["words"]]
    sys.exit(importlib.import_module(order["module"]).main(order["words"]))


def _serve() -> None:
    """Carry out what stdin orders, a line each; tell the exit status of each."""
    for module in IMPORTED:
        importlib.import_module(module)
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            _carry_out(json.loads(line))
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    _serve()
