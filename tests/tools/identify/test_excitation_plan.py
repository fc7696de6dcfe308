# SPDX-License-Identifier: Apache-2.0
"""Excitations within the limits of U."""

from dataclasses import replace

import pytest

from camtools.base.errors import CamtoolsError
from camtools.identify.configured_drive import Believed
from camtools.identify.excitation_plan import Excitation, Wishes, plan

DEFAULT = Believed(20_000.0, 742_723, 281_448, 100_000, 0, 10, 1_200_000, 400_000, 250_000)


def within(excitation: Excitation, believed: Believed) -> bool:
    """Return whether a wave keeps to stroke, speed and acceleration."""
    peaks = excitation.wave.peaks
    far_nm = abs(excitation.place_nm) + peaks.travel_mm * 1e6
    return (
        far_nm <= believed.u_stroke_nm / 2
        and peaks.speed_mm_s * 1e3 <= believed.u_speed_um_per_s
        and peaks.acceleration_mm_s2 <= believed.u_acceleration_mm_per_s2
    )


def test_amplitude_is_that_of_the_scale() -> None:
    """25 um, and as much of 100 um as 250 m/s2 allow for a scale of 1 um."""
    assert plan(DEFAULT, Wishes()).wave.rms_nm == 25_000
    coarse = plan(replace(DEFAULT, u_scale_nm=1000), Wishes())
    assert 35_000 < coarse.wave.rms_nm < 40_000
    assert within(coarse, DEFAULT)
    strong = replace(DEFAULT, u_scale_nm=1000, u_acceleration_mm_per_s2=2_000_000)
    strong = replace(strong, u_speed_um_per_s=1_000_000, u_stroke_nm=2_000_000)
    assert plan(strong, Wishes()).wave.rms_nm == 100_000


@pytest.mark.parametrize("stroke_nm", [30_000, 100_000, 800_000, 24_000_000])
@pytest.mark.parametrize("speed_um_per_s", [5000, 400_000])
@pytest.mark.parametrize("acceleration_mm_per_s2", [5000, 20_000, 2_000_000])
def test_limits_are_kept(stroke_nm: int, speed_um_per_s: int, acceleration_mm_per_s2: int) -> None:
    """Whatever they are, or it is refused with the amplitude that is left."""
    believed = replace(
        DEFAULT,
        u_stroke_nm=stroke_nm,
        u_speed_um_per_s=speed_um_per_s,
        u_acceleration_mm_per_s2=acceleration_mm_per_s2,
    )
    try:
        assert within(plan(believed, Wishes()), believed)
    except CamtoolsError as error:
        assert "U: its limits leave 0." in str(error)


@pytest.mark.parametrize(
    ("wishes", "says"),
    [
        (Wishes(rms_nm=60_000), "--rms-um 60: too large: acceleration of U 3"),
        (Wishes(rms_nm=25_000, carrier_nm=600_000), "--rms-um 25: too large: travel of U 1.3"),
    ],
)
def test_what_is_asked_for_is_checked(wishes: Wishes, says: str) -> None:
    """With the numbers and the remedy."""
    with pytest.raises(CamtoolsError) as error:
        plan(DEFAULT, wishes)
    assert error.value.lines[0].startswith(says)
    assert "; give at most --rms-um " in error.value.lines[0]
