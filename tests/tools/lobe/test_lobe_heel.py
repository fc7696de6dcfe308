"""The heel of a swung tool against brute force and the closed form of a hollow."""

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.lobe.generate import generate_lobes
from camtools.lobe.heel import check_lobe_heel, nearest_heel, needed_clearance_deg
from camtools.lobe.motion import ShaftLobe, example_lobe, make_lobes
from camtools.lobe.part import LobePart
from camtools.lobe.summary import emit_lobe_text, make_lobe_summary
from camtools.lobe.undercut import all_round
from camtools.part.tool import SwungTool


def hollow_part(**tables: object) -> LobePart:
    """Return a turned cam whose flanks are hollow: 8 mm of lift within 32 degrees."""
    tree = example_lobe().model_dump(exclude_unset=True)
    tree["cam"]["lobe"][0] |= {"half_angle_deg": 32}
    tree["cam"] |= {"base_radius_mm": 40}
    tree["machine"] = {"limits": {"swing_deg": 60, "swing_acceleration_deg_s2": 1e6}}
    return LobePart.model_validate(tree | tables)


def rubs(lobe: ShaftLobe, clearance_deg: float, heel_mm: float, direction: int) -> bool:
    """Return whether any point of a flank lies inside the lobe, at any of its contacts."""
    touch = all_round(lobe.law, lobe.base_mm, lobe.roller_mm)
    order = np.argsort(np.mod(touch.alpha, 2 * np.pi))
    polar, radius = np.mod(touch.alpha, 2 * np.pi)[order], touch.radius[order]
    alpha, t = np.radians(clearance_deg), np.geomspace(1e-2, heel_mm, 100)
    for i in range(0, touch.theta.size, 160):
        outward = np.exp(1j * (touch.theta[i] - touch.gamma[i]))
        back = -1j * direction * outward
        edge = touch.radius[i] * np.exp(1j * touch.alpha[i])
        flank = edge + t * (np.cos(alpha) * back + np.sin(alpha) * outward)
        work = np.interp(np.mod(np.angle(flank), 2 * np.pi), polar, radius, period=2 * np.pi)
        if (np.abs(flank) < work - 1e-9).any():
            return True
    return False


@pytest.mark.parametrize(("heel_mm", "direction"), [(1.0, 1), (5.0, -1)])
def test_needed_clearance_against_brute_force(heel_mm: float, direction: int) -> None:
    """A tenth of a degree more clears the hollow flank, a tenth less lies in it."""
    [lobe] = make_lobes(hollow_part())
    assert lobe.shape.hollow_radius_mm < 200
    needed = nearest_heel([lobe], heel_mm, direction).needed_deg
    assert needed > 0.1
    assert not rubs(lobe, needed + 0.1, heel_mm, direction)
    assert rubs(lobe, needed - 0.1, heel_mm, direction)


def test_a_hollow_needs_the_angle_of_its_chord() -> None:
    """A circle touched from inside, as a hollow of 50 mm: asin(heel / 2 R)."""
    turn = np.exp(2j * np.pi * np.arange(20_000) / 20_000)
    needed = needed_clearance_deg(50 * turn[::-1], -turn[::-1], 5.0, 1)
    assert needed.max() == pytest.approx(np.degrees(np.arcsin(5 / 100)), abs=0.01)


def test_the_tool_of_a_hollow_cam_is_refused_with_what_does() -> None:
    """With the angle and with the length of the message the same cam is taken."""
    part = hollow_part(tool={"clearance_deg": 1.0, "heel_mm": 8.0})
    lobes = make_lobes(part)
    with pytest.raises(CamtoolsError) as refused:
        generate_lobes(part)
    (line,) = refused.value.lines
    assert line.startswith("tool.clearance_deg: the heel of 1 degrees rubs on the hollow flank of")
    least_deg = float(line.split("give a tool with at least ")[1].split(",")[0])
    longest_mm = float(line.split("heel_mm at most ")[1])
    assert 0 < longest_mm < 8
    check_lobe_heel(lobes, SwungTool(clearance_deg=least_deg, heel_mm=8), 1)
    check_lobe_heel(lobes, SwungTool(clearance_deg=1.0, heel_mm=longest_mm), 1)
    with pytest.raises(CamtoolsError):
        check_lobe_heel(lobes, SwungTool(clearance_deg=1.0, heel_mm=longest_mm + 0.3), 1)


def test_a_convex_cam_needs_nothing_and_a_wheel_has_no_heel() -> None:
    """What the sections need stands in the report of a turned cam only."""
    assert "mm, required 0.00\n" in emit_lobe_text(
        make_lobe_summary(generate_lobes(example_lobe()))
    )
    ground = example_lobe("grinding").model_dump(exclude_unset=True)
    with pytest.raises(ValueError, match='no meaning for operation = "grinding"'):
        LobePart.model_validate(ground | {"tool": {"clearance_deg": 7}})
