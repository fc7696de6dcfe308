"""A command in a tree that belongs to another user says so, and what to do."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import ROOT

NOBODY = 65534
pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="another user's tree needs root")


def started(tree: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of a tree as another user."""
    return subprocess.run(
        [tree / "tools" / "run"],
        user=NOBODY,
        group=NOBODY,
        capture_output=True,
        text=True,
        check=False,
        cwd="/",
    )


@pytest.mark.parametrize(
    ("made", "named"),
    [((), "tree"), (("build",), "build"), (("build", "build/host.lock"), "host.lock")],
)
def test_a_foreign_tree_is_refused(
    tmp_path_factory: pytest.TempPathFactory, made: tuple[str, ...], named: str
) -> None:
    """Not built at all, built by its owner, and built once by another user in one's own tree."""
    tree = Path("/tmp") / tmp_path_factory.mktemp("foreign").name / "tree"
    shutil.rmtree(tree.parent, ignore_errors=True)
    try:
        (tree / "tools").mkdir(parents=True)
        for name in ("run", "setup.sh"):
            shutil.copy(ROOT / "tools" / name, tree / "tools" / name)
        for name in made:
            place = tree / name
            place.touch() if place.suffix else place.mkdir()
        if len(made) > 1:
            os.chown(tree / "build", NOBODY, NOBODY)
        done = started(tree)
        assert done.returncode == 2 and not done.stdout
        (line,) = done.stderr.splitlines()
        assert f"{named} cannot be written by nobody, it belongs to root: use a clone" in line
    finally:
        shutil.rmtree(tree.parent, ignore_errors=True)
