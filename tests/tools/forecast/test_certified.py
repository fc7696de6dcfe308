"""The bound of a section, by 200 machines that are drawn, cut and gauged without the forecast."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import scipy

from camtools.base.quantities import Floats
from camtools.cli.forecast import main
from camtools.cli.run import main as run
from tests.tools.cases.part_cases import PERKINS
from tests.tools.forecast.test_forecast import cuts_of

MACHINES, DRAWN = 200, 256
CUT = (str(PERKINS), "--feed", "0.5")
SECTION = re.compile(r"height (\S+) mm: form: largest deviation, unfiltered \[µm\]")


def largest_um(folder: Path, heights_mm: list[str]) -> Floats:
    """Return the largest deviation of each section on each machine, shape (machines, heights)."""
    words, found = (*CUT[1:], "--sections-mm", ",".join(heights_mm)), []
    for one in cuts_of(folder, MACHINES, 43, *words, tables=("sections",)):
        rows = one.sections
        whole = [rows["deviation_nm"][rows["section"] == at + 1] for at in range(len(heights_mm))]
        found.append([1e-3 * np.abs(nm).max() if nm.size == 3600 else np.inf for nm in whole])
    return np.array(found)


@pytest.mark.long
def test_parts_of_independent_machines_keep_the_bounds(tmp_path: Path) -> None:
    """Of 200 parts 190 +- 3.1 keep the true 95 % quantile, and the bound is rarely below that.

    It is the 250th of 256 values, which 97.3 +- 1.0 % of all parts keep; in FORECAST.md are the
    figures of this test. The same cut judged by the forecast passes, or is open, by its bound.
    """
    forecast = tmp_path / "forecast"
    words = ("--sections", "--runs", str(DRAWN), "--workers", "1", "-o", str(forecast))
    assert main([*CUT, *words]) == 0
    about = json.loads((forecast / "forecast.json").read_text())
    bounds_um = {
        named[1]: one["bound"]
        for one in about["bounds"]
        if (named := SECTION.match(one["feature"]))
    }
    assert len(bounds_um) == 5
    found_um = largest_um(tmp_path / "table", [*bounds_um])
    for (height, bound_um), errors_um in zip(bounds_um.items(), found_um.T, strict=True):
        n_kept = int((errors_um <= bound_um).sum())
        share = scipy.stats.binomtest(n_kept, MACHINES).proportion_ci(method="exact")
        quantile_um = np.sort(errors_um)[189]
        print(height, bound_um, n_kept, share.low, share.high, quantile_um, bound_um / quantile_um)
        assert n_kept >= 181
        assert bound_um <= 1.5 * quantile_um
    options = ["--forecast", str(forecast), "-o", str(tmp_path / "run")]
    status = run([*CUT, *options, "--", "--tolerance-um", "1.5"])
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    certified, form = summary["certified"], summary["form_error_um"]
    assert form["max"] + certified["form_error_u_um"] < form["tolerance"]
    assert (summary["verdict"], certified["parts"], status) == ("pass", DRAWN, 0)
    assert "U (k = 2)" in (tmp_path / "run" / "report.html").read_text()
