"""tools/uml without its kernel: what it says of one that breaks down, and which one it takes."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.linux.kernel import UML, uml
from tests.tools.cases.camsim_cases import ROOT

FakeKernel = Callable[[str], None]
BROKEN = 134
PANIC = """\
[    0.010000] Some message at boot
[    0.620000] userspace - ptrace set fp regs failed, errno = 14
[    0.620000] Kernel panic - not syncing: Attempted to kill init! exitcode=0x0000000b
[    0.620000] CPU: 0 PID: 1 Comm: init Not tainted 6.1.0 #1
"""
CAUSE = "userspace - ptrace set fp regs failed, errno = 14; "
DEATH = "Kernel panic - not syncing: Attempted to kill init! exitcode=0x0000000b"


def say_version(folder: Path, version: str) -> None:
    """Put an apt-cache in front that knows the kernel's source in a version."""
    program = folder / "apt-cache"
    program.write_text(f"#!/bin/sh\necho '  Candidate: {version}'\n")
    program.chmod(0o755)


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder whose programs are found first; kernels lie in a folder of the test."""
    folder = tmp_path / "programs"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    say_version(folder, "6.1.0-1")
    return folder


@pytest.fixture
def fake_kernel(programs: Path) -> FakeKernel:
    """Return a function that puts a text, executable, where the kernel would lie."""

    def put(text: str) -> None:
        path = Path(uml("path").stdout.strip())
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    return put


def script(*lines: str) -> str:
    """Return a kernel that is a shell script; its words set UML_FOLDER, as the real one's do."""
    return "\n".join(["#!/bin/bash", 'export "${@: -1}"', *lines, ""])


def panics(log: str = PANIC) -> str:
    """Return lines of a kernel that says its log and dies as User-Mode Linux does."""
    return f"cat >&2 <<'END'\n{log}END\nulimit -c 0\nkill -ABRT $$"


@pytest.mark.parametrize(
    ("log", "last_words"),
    [
        (PANIC, CAUSE + DEATH),
        (PANIC.replace("\n", "\r\n"), CAUSE + DEATH),
        (f"[    0.1] {DEATH}\n[    0.1] CPU: 0\n", DEATH),
        ("Checking that ptrace can change system call numbers...\nptrace: no permission\n\n",
         "ptrace: no permission"),
        ("", "it said nothing"),
    ],
    ids=["panic", "carriage returns", "panic only", "no panic", "silent"],
)  # fmt: skip
def test_kernel_that_panics_has_the_last_word(
    fake_kernel: FakeKernel, log: str, last_words: str
) -> None:
    """All its output is shown, and the last line names the panic and its cause."""
    fake_kernel(script(panics(log)))
    done = uml("run", "true")
    assert done.returncode == BROKEN
    assert done.stderr.startswith(log.replace("\r\n", "\n"))
    said = f"camturn: tools/uml: the kernel broke down (exit status {BROKEN}): {last_words}"
    assert done.stderr.splitlines()[-1] == said


def test_status_of_the_command_counts_more_than_the_kernels_end(fake_kernel: FakeKernel) -> None:
    """A panic when the kernel is switched off does not hide what the command said."""
    fake_kernel(script('echo 7 >"$UML_FOLDER/status"', panics()))
    assert uml("run", "true").returncode == 7


def test_kernel_that_hangs_is_ended(fake_kernel: FakeKernel) -> None:
    """Exit status 124, and how to give more time."""
    fake_kernel(script("exec sleep 600"))
    done = uml("run", "-t", "1", "true")
    assert done.returncode == 124
    assert done.stderr == "camturn: tools/uml: nothing was done in 1 s; give more by -t\n"


def test_version_configuration_and_each_patch_decide_which_kernel(
    programs: Path, tmp_path: Path
) -> None:
    """Another of any of them is another file; the same again is the same file."""
    root = tmp_path / "copy"
    (root / "tools").mkdir(parents=True)
    shutil.copy(UML, root / "tools")
    shutil.copy(ROOT / "tools" / "setup.sh", root / "tools")
    recipe = shutil.copytree(ROOT / "tools" / "linux_kernel", root / "tools" / "linux_kernel")
    path = uml("path", root=root).stdout
    assert path == uml("path").stdout
    seen = {path}
    patches = sorted(recipe.glob("*.patch"))
    assert [patch.name for patch in patches] == ["gpio_sim.patch", "register_area.patch"]
    for file in (recipe / "config", *patches):
        file.write_text(file.read_text() + "\n")
        seen.add(uml("path", root=root).stdout)
    say_version(programs, "6.1.0-2")
    seen.add(uml("path", root=root).stdout)
    assert len(seen) == 5
