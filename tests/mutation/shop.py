"""A private copy of the tree in which mutants are built and judged by the tests."""

import json
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from subprocess import DEVNULL, PIPE

from tests.mutation.mutants import Mutant

INVALID = ("not compiled", "same code")
SCENARIOS = "host_sim/libcamsim.so"  # stands for the scenarios among the programs of the tests
_OPTIONS = ("CMAKE_C_COMPILER=gcc", "CMAKE_BUILD_TYPE=Debug", "CMAKE_C_FLAGS_DEBUG=-O1")
_CONFIGURE = ["cmake", "-S.", "-Bbuild/host", "-GNinja", "-DCAM_TEST_OPTIONS=-O0"]
_CTEST = ["ctest", "--test-dir", "build/host", "-L", "^(firmware|fuzz)$", "--show-only=json-v1"]
_PYTEST = [sys.executable, "-m", "pytest", "-c", "tools/pyproject.toml", "--rootdir=.", "-q", "-x"]
_QUIET = ["-p", "no:cacheprovider", "-m", "not long"]  # as tools/test runs the scenarios
_SPARE = 5  # a mutant may compute for so many times as long as the firmware does


def tracked(tree: Path) -> list[str]:
    """Return the names of the files of a tree that git knows."""
    names = subprocess.check_output(["git", "ls-files", "-z"], cwd=tree, text=True).split("\0")
    return [name for name in names if (tree / name).is_file()]


def _times_of_files(folder: Path) -> dict[str, int]:
    files = (Path(one, name) for one, _, names in os.walk(folder) for name in names)
    return {os.path.relpath(path, folder): path.lstat().st_mtime_ns for path in files}


class Shop:
    """Judges one mutant after the other.

    Parameters
    ----------
    tree, folder : Path
        The tree, and the folder of the copy; what an earlier run built there is used.
    """

    def __init__(self, tree: Path, folder: Path) -> None:
        self._tree, self._build, self._clean = folder, folder / "build/host", folder / "build/clean"
        (folder / "build").mkdir(parents=True, exist_ok=True)
        for old in (path for path in folder.iterdir() if path.name != "build"):
            shutil.rmtree(old) if old.is_dir() else old.unlink()
        words = ["cp", "-p", "--parents", "-t", str(folder), *tracked(tree)]
        subprocess.run(words, cwd=tree, check=True)
        unity, link = tree / "build" / "_unity", folder / "build" / "_unity"
        if unity.exists() and not link.exists():
            link.symlink_to(unity.resolve())
        if self._clean.exists():  # the last run may have ended within a mutant
            self._restore()
        options = [f"-D{option}" for option in _OPTIONS]
        subprocess.run([*_CONFIGURE, *options], cwd=folder, stdout=DEVNULL, check=True)
        if not self._is_built("firmware_tests", "fuzz", "simulator"):
            raise SystemExit(f"{folder}: does not build before a change")
        tests = json.loads(subprocess.check_output(_CTEST, cwd=folder, text=True))["tests"]
        commands: dict[str, list[str]] = {test["name"]: test["command"] for test in tests}
        subprocess.run(commands.pop("fuzz.seeds"), check=True)
        self._words: dict[str, list[str]] = {}  # command line of each program
        self._programs = self._programs_of_rooms(commands)
        shutil.rmtree(self._clean, ignore_errors=True)
        shutil.copytree(self._build, self._clean, symlinks=True)
        self.times: dict[str, float] = {}  # processor time [s] of each program before a change

    def _restore(self) -> None:
        """Return the build folder to its state before a mutant."""
        made, clean = _times_of_files(self._build), _times_of_files(self._clean)
        for name in made.keys() - clean.keys():
            (self._build / name).unlink()
        for name in (name for name in clean if made.get(name) != clean[name]):
            shutil.copy2(self._clean / name, self._build / name)

    def _is_built(self, *targets: str) -> bool:
        ninja = ["ninja", "-C", str(self._build), "-j1", *targets]
        return subprocess.run(ninja, stdout=DEVNULL, stderr=DEVNULL, check=False).returncode == 0

    def _is_changed(self, name: str) -> bool:
        return (self._build / name).read_bytes() != (self._clean / name).read_bytes()

    def _programs_of_rooms(self, commands: dict[str, list[str]]) -> dict[str, list[str]]:
        """Return the test programs by room, with replays and scenarios as rooms of their own."""
        rooms: dict[str, list[str]] = {"replays": []}
        for test, command in commands.items():
            name = Path(command[0]).name
            folders = [path.parent.name for path in self._tree.glob(f"tests/unit/*/*/{name}.c")]
            room = [*folders, name.removeprefix("test_firmware_")][0]
            program = os.path.relpath(command[0], self._build)
            is_replay = test.startswith("fuzz.")
            self._words[program] = command if is_replay else command[:1]
            programs = rooms.setdefault("replays" if is_replay else room, [])
            if program not in programs:
                programs.append(program)
        return rooms | {"scenarios": [SCENARIOS]}

    def measure(self) -> dict[str, float]:
        """Return the times, all tests having passed."""
        for program in (one for programs in self._programs.values() for one in programs):
            failure, self.times[program] = self._test(program)
            if failure:
                raise SystemExit(f"{program} fails before a change: {failure}")
        return self.times

    def _test(self, program: str) -> tuple[str, float]:
        """Return the first failure of a program's tests or "", and the processor time [s]."""
        words = [*_PYTEST, *_QUIET, "tests/scenarios"]
        if program != SCENARIOS:
            words = ["stdbuf", "-oL", *self._words[program]]
        paths = {"CAMTURN_BUILD": self._build, "PYTHONPATH": f"{self._tree}/tools:{self._tree}"}
        env = os.environ | {key: str(value) for key, value in paths.items()}
        limit_s, failure = math.ceil(1 + _SPARE * self.times.get(program, 1e4)), ""
        with subprocess.Popen(
            words, cwd=self._tree, env=env, stdout=PIPE, stderr=DEVNULL
        ) as process:
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit_s, limit_s))
            for line in process.stdout or ():
                if b":FAIL" in line or line.startswith(b"FAILED "):
                    failure = line.decode("utf-8", "replace").rpartition("/")[2].strip()
                    os.kill(process.pid, signal.SIGKILL)  # kill() may reap it before wait4()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode and not failure:
            failure = "crash or no end" if process.returncode < 0 else "exit status"
        return failure, used.ru_utime + used.ru_stime

    def judge(self, mutant: Mutant) -> str:
        """Return `not compiled`, `same code`, `survived`, or `killed by` what."""
        if mutant.is_broken:
            return "not compiled"
        path = self._tree / mutant.file
        text, times = path.read_text("utf-8"), path.stat()
        path.write_text(mutant.applied(text), "utf-8")
        try:
            return self._verdict(path, path.parent.name)
        finally:
            path.write_text(text, "utf-8")
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            self._restore()

    def _verdict(self, path: Path, own: str) -> str:
        library = f"firmware/{own}/libcam_{own}.a"
        if not self._is_built(library):
            return "not compiled"
        is_same = not self._is_changed(library)
        if is_same and path.suffix == ".c":
            return "same code"
        for room in sorted(self._programs, key=lambda room: room != own):
            programs = self._programs[room]
            if not self._is_built(*programs, *(["host_sim/camsim"] if room == "scenarios" else [])):
                return "not compiled"
            for program in sorted(filter(self._is_changed, programs), key=self.times.__getitem__):
                is_same = False
                if failure := self._test(program)[0]:
                    return f"killed by {Path(program).name}: {failure}"
        return "same code" if is_same else "survived"
