"""Results in a folder that others can write to, and what killed runs leave behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.files import growing, staged, write_all
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.part_cases import environment

NOBODY = 65534
KILLED = """
import sys, time
from pathlib import Path
from camtools.base.files import growing, staged
folder = Path(sys.argv[1])
with staged(folder) as stage, growing(folder / "log.txt") as stream:
    (stage.folder / "half").write_text("1")
    stream.write("1")
    stream.flush()
    print("begun", flush=True)
    time.sleep(60)
"""
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="another user's link needs root")


def published(folder: Path, *more: str) -> None:
    """Publish files by a stage."""
    with staged(folder) as stage:
        for name in ("a.txt", *more):
            (stage.folder / name).write_text("new")
        stage.publish()


def grown(folder: Path) -> None:
    """Write one file bit by bit."""
    with growing(folder / "a.txt") as stream:
        stream.write("new")


def written(folder: Path, *more: str) -> None:
    """Write files whole."""
    write_all(folder, dict.fromkeys(("a.txt", *more), b"new"))


WAYS = [published, grown, written]


@pytest.mark.parametrize("way", [published, written])
def test_files_of_one_name_are_replaced_together(tmp_path: Path, way: Callable[..., None]) -> None:
    """Others stay; when one name cannot be given, as that of a folder, none is."""
    for name in ("a.txt", "c.txt"):
        (tmp_path / name).write_text("old")
    (tmp_path / "b.txt").mkdir()
    with pytest.raises(CamtoolsError, match=r"/b\.txt: cannot write: Is a directory; "):
        way(tmp_path, "b.txt")
    assert {path.name for path in tmp_path.iterdir()} == {"a.txt", "b.txt", "c.txt"}
    assert (tmp_path / "a.txt").read_text() == "old"
    way(tmp_path)
    assert [(tmp_path / name).read_text() for name in ("a.txt", "c.txt")] == ["new", "old"]


@as_root
@pytest.mark.parametrize("way", WAYS)
def test_a_planted_link_is_not_followed(tmp_path: Path, way: Callable[[Path], None]) -> None:
    """Neither under the name of a result nor as the folder; one's own link is."""
    mine, shared = tmp_path / "mine", tmp_path / "shared"
    mine.mkdir()
    shared.mkdir()
    (mine / "a.txt").write_text("old")
    link = shared / "a.txt"
    link.symlink_to(mine / "a.txt")
    os.lchown(link, NOBODY, NOBODY)
    with pytest.raises(CamtoolsError, match=r"a\.txt: is a link of another user"):
        way(shared)
    assert (mine / "a.txt").read_text() == "old"
    assert [path.name for path in shared.iterdir()] == ["a.txt"]
    os.lchown(link, 0, 0)
    way(shared)
    assert (mine / "a.txt").read_text() == "new" and link.is_symlink()


@as_root
@pytest.mark.parametrize("way", [published, written])
def test_a_planted_folder_is_not_followed(tmp_path: Path, way: Callable[[Path], None]) -> None:
    """The output folder itself may be a link as well."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "mine")
    os.lchown(tmp_path / "out", NOBODY, NOBODY)
    with pytest.raises(CamtoolsError, match="out: is a link of another user"):
        way(tmp_path / "out")
    assert not list((tmp_path / "mine").iterdir())


@as_root
def test_camsim_follows_no_planted_link(tmp_path: Path) -> None:
    """The simulator by itself refuses before it reads a table."""
    (tmp_path / "mine").write_text("old")
    (tmp_path / "trace.csv").symlink_to(tmp_path / "mine")
    os.lchown(tmp_path / "trace.csv", NOBODY, NOBODY)
    done = camsim("run", tmp_path / "none.camtab", "--trace", tmp_path / "trace.csv")
    assert done.returncode == 2
    assert (tmp_path / "mine").read_text() == "old"


def hidden(folder: Path) -> list[Path]:
    """Return the temporary names in a folder."""
    return sorted(path for path in folder.iterdir() if path.name.startswith("."))


def age(paths: list[Path]) -> None:
    """Wait until names are no longer new."""
    made = max(path.lstat().st_ctime for path in paths)
    while time.time() - made <= 1.05:
        time.sleep(0.05)


def test_the_next_run_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    """While its process lives it stays, even when it is old; afterwards it goes."""
    command = [sys.executable, "-c", KILLED, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment()) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        begun = hidden(tmp_path)
        assert len(begun) == 2
        age(begun)
        published(tmp_path)
        grown(tmp_path)
        assert hidden(tmp_path) == begun
        process.send_signal(signal.SIGKILL)
    assert hidden(tmp_path) == begun
    published(tmp_path)
    with growing(tmp_path / "log.txt") as stream:
        stream.write("1")
    assert not hidden(tmp_path)


@as_root
def test_what_others_left_stays(tmp_path: Path) -> None:
    """A folder of another user, a link and what has another name are no left-overs of ours."""
    (tmp_path / ".run.a.tmp").mkdir()
    os.chown(tmp_path / ".run.a.tmp", NOBODY, NOBODY)
    (tmp_path / "kept").mkdir()
    (tmp_path / ".run.b.tmp").symlink_to(tmp_path / "kept")
    (tmp_path / ".run.c.other").mkdir()
    age(list(tmp_path.iterdir()))
    before = sorted(tmp_path.iterdir())
    written(tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "a.txt"])
