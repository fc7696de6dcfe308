# SPDX-License-Identifier: Apache-2.0
"""Rounded points of profile and ovality, smoothed within a band, against the curve they round."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.cli.mktables import main
from camtools.part.tolerances import Tolerances
from camtools.skirt.geometry.profile import ovality_spline, profile_spline
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.geometry.smooth_points import (
    noise_facts,
    smoothing_facts,
    smoothing_takes_um,
    smoothing_texts,
    tolerances_left,
)
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.part.profile_keys import Ovality, Profile
from tests.tools.cases.part_cases import PERKINS, Command

Z_MM = np.arange(0.0, 63)
DENSE_MM = np.linspace(0, 62, 2000)


def barrel(z_mm: Floats) -> tuple[Floats, Floats]:
    """Return diameter and its second derivative of a barrel of the fourth degree [mm]."""
    off = (z_mm - 25) / 37
    return 92 - 0.05 * off**2 - 0.21 * off**4, -(0.1 + 2.52 * off**2) / 37**2


def listed(**keys: object) -> dict[str, Any]:
    """Return the profile as a list of micrometres."""
    diameter_mm = np.round(barrel(Z_MM)[0], 3).tolist()
    return {"height_mm": Z_MM.tolist(), "diameter_mm": diameter_mm} | keys


def test_curvature_is_that_of_the_barrel_before_rounding() -> None:
    """Points each mm, rounded to 1 um: met within the band, with the bend of the curve."""
    exact = barrel(DENSE_MM)[1]
    raw, smooth = (
        profile_spline(Profile.model_validate(listed(**keys))) for keys in ({}, {"smooth_um": 0.5})
    )
    inner = slice(100, -100)  # at the ends a spline has no neighbours to one side
    off = [np.abs(2 * one(DENSE_MM, 2) - exact)[inner].max() for one in (raw, smooth)]
    peak = np.abs(exact).max()
    assert off[0] > 0.5 * peak and off[1] < 0.08 * peak
    off_um = 1000 * (2 * smooth(Z_MM) - np.round(barrel(Z_MM)[0], 3))
    assert 0.4 < np.abs(off_um).max() <= 0.5 + 1e-6


def test_ovality_is_smoothed_and_never_below_zero() -> None:
    """A band wider than the least ovality leaves it at 0 or above."""
    ovality_mm = [0.002, 0, 0.001, 0.004, 0.003, 0.006, 0.005, 0.009]
    keys = {"height_mm": [float(9 * i) for i in range(8)], "ovality_mm": ovality_mm}
    found = ovality_spline(Ovality.model_validate(keys | {"smooth_um": 3.0}))(keys["height_mm"])
    assert found.min() >= 0 and np.abs(found - ovality_mm).max() <= 0.003 + 1e-9
    assert np.abs(np.diff(found, 3)).max() < 0.1 * np.abs(np.diff(ovality_mm, 3)).max()


def part_text(profile: dict[str, Any]) -> str:
    """Return the Perkins skirt with another profile over its heights."""
    before, _, rest = PERKINS.read_text().partition("[piston.profile]")
    after = rest[rest.index("[piston.ovality]") :]
    rows = "".join(f"{key} = {value}\n" for key, value in profile.items())
    return f"{before}[piston.profile]\n{rows}\n{after}"


def test_residuals_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], run: Command
) -> None:
    """JSON, text and picture of mktables, and the report of a cut."""
    profile = listed(smooth_um=0.5)
    text = part_text(profile).replace("form_error_um = 0.2", "form_error_um = 5")
    (tmp_path / "p.toml").write_text(text)
    assert main([str(tmp_path / "p.toml"), "-o", str(tmp_path), "--plot"]) == 0
    [summary] = [json.loads(path.read_text()) for path in tmp_path.glob("*.json")]
    found = summary["smoothing"]["profile"]
    off_um = 2000 * profile_spline(Profile.model_validate(profile))(Z_MM)
    off_um -= 1000 * np.array(profile["diameter_mm"])
    assert found["largest_um"] == pytest.approx(np.abs(off_um).max(), abs=1e-6)
    assert found["rms_um"] == pytest.approx(np.sqrt(np.mean(off_um**2)), rel=1e-6)
    bends = found["bend_per_mm"]
    assert bends["after"] == pytest.approx(np.abs(barrel(Z_MM)[1]).max(), rel=0.25)  # at an end
    assert bends["before"] > 1.2 * bends["after"]
    shown = capsys.readouterr().out
    assert "profile smoothed within 0.5 um: largest residual 0.5 um" in shown
    assert "  smoothing takes 0.25 um of the tolerance of 5 um\n" in shown
    assert [path.read_bytes()[1:4] for path in tmp_path.glob("*_smoothing.png")] == [b"PNG"]
    done = run("p.toml", "--feed", "2", "-o", "out", draws=False)
    assert done.returncode in (0, 1), done.stderr
    share = "against the smoothed drawing (4.75 um left: smoothing takes 0.25 um"
    assert share in done.stdout and "against the drawing" not in done.stdout
    assert (tmp_path / "out" / "cut_smoothing.png").exists()
    assert "profile smoothed within 0.5 um" in (tmp_path / "out" / "report.html").read_text()


def test_segments_are_not_smoothed() -> None:
    """Lines and arcs are exact."""
    tree = example_part().model_dump()
    cone = {"to_mm": 62, "diameter_mm": 91.7}
    start = {"interpolation": "segments", "height_mm": [0], "diameter_mm": [91], "smooth_um": 1}
    tree["piston"]["profile"] = start | {"segment": [cone]}
    with pytest.raises(ValidationError, match="only points are smoothed"):
        SkirtPart.model_validate(tree)


def bent(**process: float) -> SkirtPart:
    """Return a part whose profile has a point that is 20 um off a barrel."""
    tree = example_part().model_dump()
    diameter_mm = barrel(Z_MM)[0]
    diameter_mm[30] += 0.02
    profile = {"interpolation": "linear", "height_mm": Z_MM.tolist(), "smooth_um": 40}
    tree["piston"]["profile"] = profile | {"diameter_mm": diameter_mm.tolist()}
    tree["process"] |= process
    return SkirtPart.model_validate(tree)


def test_smoothing_beyond_the_form_error_is_refused() -> None:
    """Half of a diameter's residual counts, with the number that would do."""
    with pytest.raises(GeometryError, match=r"piston\.profile\.smooth_um: ") as refused:
        make_geometry(bent(form_error_um=5.0))
    found = re.search(r"by up to ([0-9.]+) um, .* above ([0-9.]+)$", refused.value.lines[0])
    assert found is not None
    taken_um, least_um = map(float, found.groups())
    assert 8 < taken_um <= 20 and taken_um <= least_um
    enough = bent(form_error_um=least_um + 0.1)
    make_geometry(enough)
    assert smoothing_takes_um(enough) == pytest.approx(taken_um, rel=0.01)


def test_tolerances_of_the_sheets_are_reduced() -> None:
    """A diameter by the whole residual, the form of a line by the same, no phase."""
    part = bent(form_error_um=100.0)
    stated = Tolerances(diameter_um=50, straightness_um=1, phase_deg=1)
    left = tolerances_left(part.model_copy(update={"tolerances": stated}))
    taken_um = 2 * smoothing_takes_um(part)
    assert left.diameter_um == pytest.approx(50 - taken_um)
    assert (left.straightness_um, left.phase_deg, left.ovality_um) == (0, 1, None)


def test_rounded_profile_is_warned_about() -> None:
    """The warning names a band that lowers the bend; a band that raises it is warned about."""
    tree = example_part().model_dump()
    tree["piston"]["profile"] = listed()
    piston = SkirtPart.model_validate(tree).piston
    noise = noise_facts(piston)
    assert set(noise) == {"profile"} and 0.2 < noise["profile"]["smooth_um"] < 2.5
    [line] = smoothing_texts({}, noise, 5.0)
    assert line.startswith("warning: the profile is noisy or rounded coarsely: piston.profile.")
    assert noise_facts(example_part().piston) == {}
    risen = noise["profile"] | {"bend_per_mm": {"before": 0.001, "after": 0.002}}
    told = smoothing_texts({"profile": risen}, {}, 5.0)
    assert told[1].startswith("warning: smoothing raises the largest second derivative")


def test_smoothing_that_changes_nothing_says_so() -> None:
    """Three points have no third derivative, and a parabola is smooth already."""
    with pytest.raises(ValidationError, match="changes nothing with 3 points, it needs 4"):
        Profile.model_validate(
            {"height_mm": [0, 31, 62], "diameter_mm": [91, 92, 91.5], "smooth_um": 1}
        )
    tree = example_part().model_dump()
    parabola = (92 - 1e-4 * (Z_MM - 25) ** 2).tolist()
    tree["piston"]["profile"] = listed(smooth_um=0.5) | {"diameter_mm": parabola}
    found = smoothing_facts(SkirtPart.model_validate(tree).piston)
    [line] = smoothing_texts(found, {}, 5.0)
    assert line.endswith("within 0.5 um: nothing changes, because its points are smooth already")
