"""What lies in build/run: only runs are counted, and only runs are removed."""

import os
from pathlib import Path

import pytest

from camtools.pipeline.run import drop_all_but, kept_text, runs


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Return a folder with three runs, the first the oldest, and with what is none."""
    for made_s, name in enumerate(("old", "middle", "new")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "trace.parquet").write_bytes(bytes(1000))
        summary = tmp_path / name / "summary.json"
        summary.write_text('{"run_wall_time_s": 1.5}', "ascii")
        os.utime(summary, (made_s, made_s))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "summary.json").write_text("{}", "ascii")
    (tmp_path / "torn").mkdir()
    (tmp_path / "torn" / "summary.json").write_text('{"run_wall_', "ascii")
    (tmp_path / "notes.txt").write_text("run_wall_time_s", "ascii")
    (tmp_path / "link").symlink_to(tmp_path / "new")
    return tmp_path


def test_the_oldest_go_and_nothing_else(place: Path) -> None:
    """The newest come first, with what they take; what is no run stays, a link's target, too."""
    found = [(run.name, run.n_bytes) for run in runs(place)]
    assert found == [("new", 1024), ("middle", 1024), ("old", 1024)]
    assert kept_text(place) == "3 runs, 3.1 kB: new, middle, old"
    assert [run.name for run in drop_all_but(place, 1)] == ["middle", "old"]
    left = sorted(path.name for path in place.iterdir())
    assert left == ["link", "mine", "new", "notes.txt", "torn"]
    assert (place / "new" / "trace.parquet").exists()
    assert kept_text(place / "run") == "no runs"
