"""Results of a run appear in their folder all together, or not at all.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     with Stage(Path(name) / "new") as stage:
...         _ = (stage.folder / "a.txt").write_text("1")
...         stage.publish()
...     sorted(path.name for path in (Path(name) / "new").iterdir())
['a.txt']
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from camtools.base.errors import CamtoolsError
from camtools.base.leftovers import SUFFIX, held, sweep
from camtools.base.links import followed
from camtools.base.output import file_target, signals_held

_PREFIX = ".run."


def cannot_write(place: Path, error: OSError) -> CamtoolsError:
    """Return the error of a place that cannot be written, in one line."""
    reason = error.strerror or str(error)
    remedy = "give a folder that can be written and has room"
    return CamtoolsError([f"{place}: cannot write: {reason}; {remedy}"])


class Stage:
    """A hidden folder inside the output folder, gone at the end.

    A run that was killed leaves its folder behind; the next one into the same output removes it.

    Parameters
    ----------
    output : Path
        Where the results go; made when missing, removed again when nothing is published.

    Attributes
    ----------
    folder : Path
        Absolute; write everything here.

    Raises
    ------
    CamtoolsError
        On entering and publishing: the output folder cannot be written.
    """

    def __init__(self, output: Path) -> None:
        self.output = output
        self.folder = Path()
        self._made: list[Path] = []
        self._alive = ExitStack()

    def __enter__(self) -> Self:
        try:
            with signals_held():
                paths = (self.output, *self.output.parents)
                self._made = [path for path in paths if not path.exists()]  # innermost first
                followed(self.output).mkdir(parents=True, exist_ok=True)
                sweep(self.output, _PREFIX)
                name = tempfile.mkdtemp(prefix=_PREFIX, suffix=SUFFIX, dir=self.output)
                self.folder = Path(name).resolve()
                self._alive.enter_context(held(self.folder))
        except OSError as error:
            self._remove_empty()
            raise cannot_write(self.output, error) from error
        return self

    def publish(self) -> None:
        """Move every file into the output folder, over those of earlier runs."""
        files = sorted(path for path in self.folder.iterdir() if path.is_file())
        try:
            targets = [self._target(path.name) for path in files]
            for path in files:  # all of them are on the disk before the first one moves
                with path.open("rb") as stream:
                    os.fsync(stream.fileno())
            with signals_held():
                for path, target in zip(files, targets, strict=True):
                    path.replace(target)
        except OSError as error:
            raise cannot_write(self.output, error) from error

    def _target(self, name: str) -> Path:
        """Return the file that gets a name, or refuse before the first file moves."""
        target = file_target(self.output / name)
        if target.parent.stat().st_dev != self.folder.stat().st_dev:
            raise OSError(errno.EXDEV, f"{os.strerror(errno.EXDEV)}: {name}")
        return target

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with signals_held():
            shutil.rmtree(self.folder, ignore_errors=True)
            self._alive.close()
            self._remove_empty()

    def _remove_empty(self) -> None:
        for path in self._made:
            with suppress(OSError):
                path.rmdir()
