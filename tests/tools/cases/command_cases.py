"""Commands of camtools, called in this process as a shell would start them."""

import importlib
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from camtools.base.arguments import make_parser, read_arguments
from camtools.pipeline.job import RunJob
from camtools.pipeline.run import run
from camtools.plots.style import png_of
from camtools.report import sheet_page
from camtools.report.views import View
from tests.tools.cases.camsim_cases import BUILD
from tests.tools.cases.part_cases import Capture

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def command(
    module: str,
    *words: str | Path,
    cwd: Path | None = None,
    largest_file: int | None = None,
    draws: bool = True,
    **settings: str,
) -> subprocess.CompletedProcess[str]:
    """Run the command of a module in a folder, with settings in its environment.

    largest_file: bytes beyond which a file cannot be written, as on a full disk; draws: false
    leaves pictures empty, for tests of other results; drawing takes the longest.
    """
    texts = [str(word) for word in words]
    main: Callable[[list[str]], int] = importlib.import_module(module).main
    with pytest.MonkeyPatch.context() as patch, signals_kept(), _outputs() as said:
        for name, value in ({"CAMTURN_BUILD": str(BUILD)} | settings).items():
            patch.setenv(name, value)
        patch.chdir(cwd or Path.cwd())
        if not draws:
            undraw(patch)
        with files_end_at(largest_file):
            try:
                status = main(texts)
            except SystemExit as end:
                status = int(str(end.code or 0))
    return subprocess.CompletedProcess([module, *texts], status, *said)


def job_of(*words: str) -> RunJob:
    """Return what the words of tools/run ask for."""
    given = read_arguments(make_parser("tools/run", run), run, words)
    job: RunJob = given["job"]
    return job.with_words(given["extra"])


def complaint(main: Callable[[list[str]], int], words: list[str], capture: Capture) -> str:
    """Run a command in this process, which must end with status 2; return its only line."""
    try:
        status = main(words)
    except SystemExit as end:
        status = int(str(end.code))
    (line,) = capture.readouterr().err.splitlines()
    assert status == 2, line
    return line


def undraw(patch: pytest.MonkeyPatch) -> None:
    """Leave pictures empty: they take most of the time of a run."""

    def leave_empty(canvas: FigureCanvasAgg) -> None:
        canvas.get_renderer()  # type: ignore[no-untyped-call]

    patch.setattr(FigureCanvasAgg, "draw", leave_empty)
    patch.setattr(View, "png", lambda view, cut: png_of(Figure()))
    for name in ("draw_section", "draw_lines"):
        patch.setattr(sheet_page, name, lambda *_: Figure())


@contextmanager
def signals_kept() -> Iterator[None]:
    """Restore the handlers of signals that a command replaces."""
    before = [signal.getsignal(number) for number in SIGNALS]
    try:
        yield
    finally:
        for number, handler in zip(SIGNALS, before, strict=True):
            signal.signal(number, handler)


@contextmanager
def files_end_at(n_bytes: int | None) -> Iterator[None]:
    """Limit the size of every file that this process writes, as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    if n_bytes is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def _outputs() -> Iterator[list[str]]:
    """Catch both outputs of this process and its children; the list has them at the end."""
    said: list[str] = []
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        kept = [os.dup(number) for number in (1, 2)]
        streams = [open(f"{folder}/{number}", "w", buffering=1) for number in (1, 2)]  # noqa: PTH123, SIM115
        for number, name in enumerate(("stdout", "stderr"), start=1):
            getattr(sys, name).flush()
            os.dup2(streams[number - 1].fileno(), number)
            patch.setattr(sys, name, streams[number - 1])
        try:
            yield said
        finally:
            for number, (stream, one) in enumerate(zip(streams, kept, strict=True), start=1):
                stream.close()
                os.dup2(one, number)
                os.close(one)
                said.append(Path(stream.name).read_text())
