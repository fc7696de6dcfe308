"""A copy of the tree in which mutants are built and judged by the tests."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from mutants import Mutant

_BUILD_LIMIT_S, _TEST_LIMIT_S = 300.0, 60.0
_TEST_NAMES = "test_cam_*", "test_learn*"


class Workshop:
    """Copy of the tracked files with a build of the host preset.

    Parameters
    ----------
    root : Path
        The project.
    folder : Path
        Where the copy goes; what is there of an earlier campaign is used again.
    """

    def __init__(self, root: Path, folder: Path) -> None:
        self.tree = folder
        self._copy(root)
        self.build = self.tree / "build" / "host"
        self._checked = self.tree / "build" / "host-asan"
        for preset in ("host", "host-asan"):
            self._run(["cmake", "--preset", preset], _BUILD_LIMIT_S)
            if self._run(["cmake", "--build", "--preset", preset], 6 * _BUILD_LIMIT_S) != 0:
                raise RuntimeError(f"{self.tree}: {preset} does not build before it is changed")
        self.tests = self._tests()
        self._objects = self._find_objects()

    def _copy(self, root: Path) -> None:
        self.tree.mkdir(parents=True, exist_ok=True)
        listed = subprocess.run(
            ["git", "ls-files", "-z"], cwd=root, capture_output=True, check=True, text=True
        ).stdout.split("\0")
        for name in filter(None, listed):
            source, target = root / name, self.tree / name
            if not source.exists():
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists() or target.read_bytes() != source.read_bytes():
                shutil.copy2(source, target)
        for name in ("_unity", "_monocypher"):
            fetched, link = root / "build" / name, self.tree / "build" / name
            link.parent.mkdir(exist_ok=True)
            if fetched.exists() and not link.exists():
                link.symlink_to(fetched.resolve())

    def _run(self, words: list[str], limit_s: float) -> int | None:
        """Return the exit status of a command, None when it took too long."""
        with subprocess.Popen(
            words,
            cwd=self.tree,
            env=os.environ
            | {"PYTHONPATH": str(self.tree / "tools"), "CAMTURN_BUILD": str(self.build)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        ) as process:
            try:
                return process.wait(limit_s)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                return None

    def _tests(self) -> list[Path]:
        """Return the unit tests that have to do with the firmware, the quickest first."""
        found = [p for name in _TEST_NAMES for p in (self.build / "tests/unit").glob(name)]
        times = {}
        for path in sorted(p for p in found if p.is_file() and os.access(p, os.X_OK)):
            begin = time.monotonic()
            if self._run([str(path)], _TEST_LIMIT_S) != 0:
                raise RuntimeError(f"{path.name} fails before anything is changed")
            times[path] = time.monotonic() - begin
        return sorted(times, key=lambda path: times[path])

    def _find_objects(self) -> dict[str, Path]:
        entries = json.loads((self.build / "compile_commands.json").read_text(encoding="utf-8"))
        return {
            str(Path(entry["file"]).relative_to(self.tree)): self.build / _output(entry["command"])
            for entry in entries
            if Path(entry["file"]).is_relative_to(self.tree)
        }

    def _ninja(self, *targets: str, build: Path | None = None) -> int | None:
        folder = str(build or self.build)
        return self._run(["ninja", "-C", folder, *targets], _BUILD_LIMIT_S)

    def _own_first(self, mutant: Mutant) -> tuple[list[Path], list[Path]]:
        """Return the tests of the changed module, and all the others."""
        module = Path(mutant.file).stem
        own = [path for path in self.tests if path.name.startswith(f"test_{module}")]
        return own, [path for path in self.tests if path not in own]

    def _is_same_code(self, mutant: Mutant, before: str) -> bool | None:
        """Return whether the compiler makes the same code of it; None when it makes none."""
        target = self._objects.get(mutant.file)
        if target is None:
            return False
        if self._ninja(str(target.relative_to(self.build))) != 0:
            return None
        return _digest(target) == before

    def judge(self, mutant: Mutant) -> str:
        """Return `invalid`, `same code`, `survived`, or `killed by` what."""
        path = self.tree / mutant.file
        text = path.read_text(encoding="utf-8")
        target = self._objects.get(mutant.file)
        if target is not None:
            self._ninja(str(target.relative_to(self.build)))
        before = _digest(target) if target is not None else ""
        try:
            path.write_text(mutant.applied(text), encoding="utf-8")
            is_same = self._is_same_code(mutant, before)
            if is_same is None:
                return "invalid"
            return "same code" if is_same else self._test(mutant)
        finally:
            path.write_text(text, encoding="utf-8")

    def _test(self, mutant: Mutant) -> str:
        for group in self._own_first(mutant):
            if not group:
                continue
            if self._ninja(*(str(path.relative_to(self.build)) for path in group)) != 0:
                return "invalid"
            for path in group:
                status = self._run([str(path)], _TEST_LIMIT_S)
                if status != 0:
                    return f"killed by {path.name}" + (" (time)" if status is None else "")
        return self._test_slowly(mutant)

    def _test_slowly(self, mutant: Mutant) -> str:
        """Judge by what takes longer: own tests with sanitizers, then whole cuts on camsim."""
        own = [str(path.relative_to(self.build)) for path in self._own_first(mutant)[0]]
        self._ninja(*own, build=self._checked)
        for name in own:
            if self._run([str(self._checked / name)], 2 * _TEST_LIMIT_S) != 0:
                return f"killed by {Path(name).name} with sanitizers"
        self._ninja("host_sim/camsim")
        pytest = [sys.executable, "-m", "pytest", "-c", "tools/pyproject.toml", "-q", "-x"]
        words = [*pytest, f"--rootdir={self.tree}", "-p", "no:cacheprovider", "tests/scenarios"]
        return "survived" if self._run(words, 10 * _TEST_LIMIT_S) == 0 else "killed by scenarios"


def _output(command: str) -> str:
    """Return the file that a command of the compiler writes."""
    words = shlex.split(command)
    return words[words.index("-o") + 1]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
