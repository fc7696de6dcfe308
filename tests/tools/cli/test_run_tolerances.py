# SPDX-License-Identifier: Apache-2.0
"""A tolerance that the drawing states counts as much as the form error does."""

import json
from pathlib import Path

import pytest

from camtools.cli.run import main
from tests.tools.cases.part_cases import PERKINS


@pytest.mark.parametrize(("roundness_um", "status"), [(0.001, 1), (1.0, 0)])
@pytest.mark.usefixtures("undrawn")
def test_stated_roundness_decides(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], roundness_um: float, status: int
) -> None:
    """Beyond it the part is not good, in every place that tells, though its form error is."""
    part = tmp_path / "part.toml"
    part.write_text(f"{PERKINS.read_text()}\n[tolerances]\nroundness_um = {roundness_um}\n")
    out = tmp_path / "out"
    assert main([str(part), "--feed", "1", "-o", str(out)]) == status
    summary = json.loads((out / "summary.json").read_text())
    assert summary["form_error_um"]["max"] < 0.2
    assert summary["is_good"] == (status == 0)
    assert bool(summary["sheets_out_of_tolerance"]) == (status == 1)
    said = capsys.readouterr().out.splitlines()[0]
    page = (out / "report.html").read_text()
    verdict = "out of tolerance" if status else "within tolerance"
    assert verdict in said
    assert f": {verdict}</title>" in page.lower()
