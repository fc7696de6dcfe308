# SPDX-License-Identifier: Apache-2.0
"""Surfaces as the simulator and instruments write them: units, separators, what is refused."""

import pytest

from camtools.base.errors import InputError
from camtools.measured.points import parse_points


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("turn,z_mm,radius_mm,error_nm", "0.25,10,46,-1500"),
        ("turn,z_mm,radius_mm,error_nm,control_nm", "0.25,10,46,-1500,7"),
        ("angle_deg,height_mm,deviation_um", "90,10,-1.5"),
        ("angle_deg;height_mm;deviation_um", "90,0;10;-1,5"),
        ("angle_turn height_um deviation_mm", "0.25  10000\t-0.0015"),
        ("deviation_nm, angle_deg, z_um", "-1500, 90, 10000"),
        ("Angle_deg;Height_mm;Radius_mm;DEVIATION_um", "90;10;46;-1,5"),
    ],
)
def test_units_and_separators(header: str, row: str) -> None:
    """The same point, however it is written."""
    found = parse_points(f"{header}\n{row}\n\n", "a.csv")
    assert (found.turn[0], found.z_mm[0]) == pytest.approx((0.25, 10.0))
    assert found.deviation_um[0] == pytest.approx(-1.5)
    assert (found.radius_mm is not None) == ("radius_mm" in header.lower())


def test_whole_turn_is_none() -> None:
    """360 degrees are 0."""
    assert parse_points("angle_deg,z_mm,error_um\n360,1,2\n", "a.csv").turn[0] == 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.csv: line 1: needs one column of the angle: turn, angle_turn, angle_deg"),
        ("angle,height_mm,deviation_um\n", "needs one column of the angle"),
        ("angle_deg,turn,height_mm,deviation_um\n", "needs one column of the angle"),
        ("angle_deg,height,deviation_um\n", "needs one column of the height: z_mm, height_mm"),
        ("angle_deg,height_mm,roundness\n", "needs one column of the deviation: deviation_um"),
        ("angle_deg,height_mm,deviation_um\n", "a.csv: has no point; gauge the part"),
        ("angle_deg,z_mm,error_nm\n1,2\n", "a.csv: line 2 = '1,2': no numbers"),
        ("angle_deg,z_mm,error_nm\n1,2,x\n", "a.csv: line 2: no numbers"),
        ("angle_deg,z_mm,error_nm\n\n400,2,3\n", "a.csv: line 3 = '400,2,3': beyond one turn"),
        ("turn,z_mm,error_nm\n90,2,3\n", "line 2 = '90,2,3': beyond one turn"),
        ("turn,z_mm,error_nm\n0,2,nan\n", "line 2 = '0,2,nan': no finite numbers"),
        ("turn,z_mm,error_nm\n0,2,2e7\n", "or a deviation of 15 mm"),
        ("turn,z_mm,error_nm\n0,2000,1\n", "a height of 1000 mm"),
    ],
)
def test_refusals(text: str, message: str) -> None:
    """File, line, value and remedy are named."""
    with pytest.raises(InputError) as caught:
        parse_points(text, "a.csv")
    assert message in str(caught.value)
    assert len(caught.value.lines) == 1
