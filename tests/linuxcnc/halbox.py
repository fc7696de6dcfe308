"""LinuxCNC's HAL for tests: its own programs in a folder of their own, run by an ordinary user.

The programs look for their modules in a place that is compiled in. Copies of two of them get the
present folder instead, so that neither root nor an installation is needed. HAL is one per machine:
a lock keeps two boxes apart.
"""

import fcntl
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from checks.patience import until
from tests.tools.cases.part_cases import ROOT

NOBODY = 65534
PLACES = {b"/usr/lib/linuxcnc/modules": b"./modules", b"/usr/bin/rtapi_app": b"./rtapi_app"}
# Shared memory and semaphores of HAL, of its owner, and of the buffers in linuxcnc.nml.
KEYS = ("0x48414c32", "0x48484c34", *map(str, range(1001, 1006)))
LOCK = Path(tempfile.gettempdir()) / "camturn-hal.lock"


def build(root: Path, folder: Path, *words: str | Path) -> str:
    """Call make in `folder` with LinuxCNC's tools below `root`; return what it says, or fail.

    A link in `folder` stands for the project, whose path may have spaces, which make cannot use.
    """
    link = folder / "camturn"
    if not link.exists():
        link.symlink_to(ROOT)
    words = tuple(link / w.relative_to(ROOT) if isinstance(w, Path) else w for w in words)
    tools = (link / root.relative_to(ROOT) if root.is_relative_to(ROOT) else root) / "usr"
    env = os.environ | {"PYTHONPATH": str(tools / "lib" / "python3" / "dist-packages")}
    done = subprocess.run(
        ["make", f"HALCOMPILE={tools / 'bin' / 'halcompile'}", f"prefix={tools}", *map(str, words)],
        cwd=folder, env=env, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def _relocated(program: Path) -> bytes:
    image = program.read_bytes()
    for place, here in PLACES.items():
        image = image.replace(place + b"\0", here.ljust(len(place) + 1, b"\0"))
    return image


@dataclass(frozen=True)
class Halbox:
    """A folder in which HAL runs."""

    folder: Path

    def run(self, *words: str, to: str = "said.txt", **more: str) -> int:
        """Run a program, `more` in its environment; what it and the threads say is a file."""
        env = {
            "PATH": os.environ["PATH"],
            "HOME": str(self.folder),
            "LD_LIBRARY_PATH": "lib",
            "RTAPI_FIFO_PATH": str(self.folder / "fifo"),
            **more,
        }
        user = NOBODY if os.getuid() == 0 else None
        with (self.folder / to).open("a") as said:
            return subprocess.run(
                words, cwd=self.folder, env=env, stdin=subprocess.DEVNULL, stdout=said,
                stderr=said, user=user, group=user, extra_groups=[] if user else None,
                check=False,
            ).returncode  # fmt: skip

    def load(self, script: str) -> int:
        """Carry out lines of a HAL file; return the exit status."""
        (self.folder / "test.hal").write_text(script)
        return self.run("./halcmd", "-f", "test.hal")

    def get(self, pin: str) -> str:
        """Return the value of a pin or parameter."""
        return self.ask("getp", pin).strip()

    def ask(self, *words: str) -> str:
        """Return what a command of halcmd prints."""
        answer = self.folder / "answer.txt"
        answer.write_text("")
        assert self.run("./halcmd", *words, to=answer.name) == 0, self.said() + answer.read_text()
        return answer.read_text()

    def wait(self, pin: str, value: str) -> None:
        """Wait for a pin to have a value."""
        self._until(lambda: self.get(pin) == value, f"{pin} = {value}")

    def _until(self, condition: Callable[[], bool], what: str) -> None:
        try:
            until(condition, what)
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.said()}") from None

    def said(self) -> str:
        """Return everything that was printed."""
        path = self.folder / "said.txt"
        return path.read_text() if path.exists() else ""

    def wait_said(self, text: str) -> None:
        """Wait until a text is printed: HAL prints lines of its threads later, in another one."""
        self._until(lambda: text in self.said(), f"printing {text}")

    def stop(self) -> None:
        """End the threads, unload everything."""
        for words in (("./halcmd", "stop"), ("./halcmd", "unload", "all"), ("./rtapi_app", "exit")):
            self.run(*words)
        self.forget()

    def forget(self) -> None:
        """Remove what is shared; an interrupted test may have left it."""
        options = (word for key in KEYS for option in ("-M", "-S") for word in (option, key))
        self.run("ipcrm", *options, to="ipcrm.txt")


def _fill(folder: Path, root: Path, modules: list[Path]) -> None:
    (folder / "modules").mkdir()
    (folder / "lib").mkdir()
    libraries = root / "usr" / "lib"
    for module in (*(libraries / "linuxcnc" / "modules").glob("*.so"), *modules):
        shutil.copy(module, folder / "modules")
    for library in (*libraries.glob("*.so.0"), *(libraries / "x86_64-linux-gnu").glob("*.so*")):
        shutil.copy(library, folder / "lib")
    for name in ("rtapi_app", "halcmd"):
        (folder / name).write_bytes(_relocated(root / "usr" / "bin" / name))
        (folder / name).chmod(0o755)
    if os.getuid() == 0:
        os.chown(folder, NOBODY, NOBODY)
    folder.chmod(0o755)


def _remove(folder: Path) -> None:
    """Remove a folder, in which a program that ends may still exchange a file for a moment."""

    def is_gone() -> bool:
        shutil.rmtree(folder, ignore_errors=True)
        return not folder.exists()

    until(is_gone, f"the removal of {folder}", 5.0)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Wait until no other test of this machine, of whichever user, holds the lock; hold it."""
    with suppress(FileExistsError):  # of another user, who need not let this one write
        path.touch(exist_ok=False)
        path.chmod(0o644)  # whatever the umask
    with path.open() as lock:
        while not _is_taken(lock):
            print("another test has LinuxCNC", flush=True)  # output is progress to hang.py
            time.sleep(1.0)
        yield


def _is_taken(lock: TextIO) -> bool:
    with suppress(BlockingIOError):
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


@contextmanager
def halbox(root: Path, modules: list[Path]) -> Iterator[Halbox]:
    """Make a folder with HAL and modules in it; nothing of it is left afterwards."""
    folder = Path(tempfile.mkdtemp(prefix="camturn-hal-"))
    with locked(LOCK):
        box = Halbox(folder)
        try:
            _fill(folder, root, modules)
            box.forget()
            yield box
        finally:
            box.stop()
            _remove(folder)
