# SPDX-License-Identifier: Apache-2.0
"""What a report tells of the surface between the tracks, which the form error does not see."""

from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.cli.run import main as run
from camtools.part.tool import Tool, check_tracks
from camtools.pipeline.job import RunJob
from camtools.skirt.part.part_file import example_part
from camtools.skirt.report.tool_text import track_row
from camtools.skirt.table.generate import generate
from tests.tools.cases.part_cases import PERKINS, ROOT

RINGS = """\
path = "ring-helix"
[[process.pass]]
allowance_um = 30
[[process.pass]]
allowance_um = 0
[machine.limits]"""


def test_ridges_are_told() -> None:
    """1.5 mm of feed and a nose of 0.8 mm leave a thread 0.522 mm deep."""
    told = track_row({"cut": {"feed_mm": 1.5}}, Tool(nose_radius_mm=0.8)).value
    assert told.startswith("522 µm in theory")
    fed = track_row({"cut": {"feed_mm": 0.5}}, Tool(nose_radius_mm=0.8), peak=3.0).value
    assert fed == told
    assert "do not meet" in track_row({"cut": {"feed_mm": 1.6}}, Tool(nose_radius_mm=0.8)).value
    assert "not judged" in track_row({"cut": {"feed_mm": 0.1}}, Tool()).value
    with_nose = {"cut": {"feed_mm": 1.5}, "tool": {"nose_mm": 0.8}}
    assert track_row(with_nose, Tool()).value == told


@pytest.mark.usefixtures("undrawn")
def test_rings_in_passes_claim_no_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The forces of rings are not measured, so none is told; the table may be less accurate."""
    text = PERKINS.read_text().replace("[machine.limits]", RINGS)
    part = tmp_path / "rings.toml"
    part.write_text(text.replace("spindle_rpm = 2500", "spindle_rpm = 500"))
    words = [str(part), "--feed", "4", "--tolerance-nm", "3", "-o", str(tmp_path / "out")]
    assert run(words) == 0
    lines = capsys.readouterr().out.splitlines()
    passes = [line for line in lines if line.lstrip().startswith("pass ")]
    assert len(passes) == 2
    assert not any("force" in line for line in passes)
    assert any("accurate to 2.8 nm" in line for line in lines)


def test_bad_tolerance_of_a_run_is_refused() -> None:
    """As mktables refuses it, before anything is made."""
    with pytest.raises(CamtoolsError, match=r"tolerance_nm = 1e\+09: must be above 0"):
        RunJob([str(ROOT / "none.toml"), "--tolerance-nm", "1e9"])


def test_tracks_that_do_not_meet_are_refused() -> None:
    """A nose of 0.8 mm covers 1.6 mm along the axis; what lies beyond stays on the part."""
    check_tracks(Tool(nose_radius_mm=0.8), 1.59)
    check_tracks(Tool(), 2.0)
    with pytest.raises(CamtoolsError, match=r"metal stays; feed less than 1\.6 mm"):
        check_tracks(Tool(nose_radius_mm=0.8), 1.6)
    part = example_part().model_copy(update={"tool": Tool(nose_radius_mm=0.04)})
    with pytest.raises(CamtoolsError, match=r"feed of 0\.1 mm"):
        generate(part)
    with pytest.raises(CamtoolsError, match=r"feed of 0\.5 mm"):
        RunJob(["--feed", "0.5"]).check_feed(part)
