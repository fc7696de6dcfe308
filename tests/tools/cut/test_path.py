"""How Z follows the turns: the worked numbers of MATHS.md (40) .. (43), ramps, tracks, scallops."""

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cut.path import LEAST_RAMP, ToolPath, highest_rpm, largest_feed_mm, ramp_of, step_of
from camtools.papers.paths import make_study, study_csv
from camtools.part.common import MachineLimits
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.turning import path_of
from camtools.table.image import pack, unpack
from tests.tools.cases.part_cases import PERKINS, parse_part, refused

# turns since the start, height of the ring-helix (0.2 mm), height of a plain helix (0.1 mm)
GOLDEN = """\
0 0.000000 0.000000
0.25 0.000000 0.025000
0.5 0.000000 0.050000
0.75 0.000000 0.075000
1 0.000000 0.100000
1.25 0.050000 0.125000
1.5 0.100000 0.150000
1.75 0.150000 0.175000
2 0.200000 0.200000
2.5 0.200000 0.250000
3 0.200000 0.300000
3.5 0.300000 0.350000
4 0.400000 0.400000
"""
RING = ToolPath("ring-helix", 0.0, 62.0, 0.2)
PLAIN = ToolPath("helix", 0.0, 62.0, 0.1)


def test_worked_numbers() -> None:
    """Heights to the printed digits; m rings take 2 m - 1 turns; the rest is a shorter step."""
    rows = [line.split() for line in GOLDEN.splitlines()]
    turns = np.array([float(row[0]) for row in rows])
    for column, path in ((1, RING), (2, PLAIN)):
        assert [f"{z:.6f}" for z in path.height_mm(turns)] == [row[column] for row in rows]
    assert (RING.n_rings, RING.turns, PLAIN.turns) == (311, 621.0, 620.0)
    assert RING.height_mm(np.array([620.0, 621.0])).tolist() == [62.0, 62.0]
    path = ToolPath("ring-helix", 0.0, 0.5, 0.2)
    assert (path.n_rings, path.turns) == (4, 7.0)
    assert path.height_mm(np.array([4.5, 6.0, 6.9])).tolist() == [0.4, 0.5, 0.5]
    assert path.height_mm(np.array([5.25, 5.5])) == pytest.approx([0.425, 0.45])


def test_rings_are_closed_and_at_the_drawings_heights() -> None:
    """In every even turn Z stands, with a ramp too."""
    for ramp in (0.0, 0.2):
        path = ToolPath("ring-helix", 0.0, 62.0, 0.2, ramp)
        turns = np.arange(0, 620, 2)[:, None] + np.linspace(0, 1, 9)
        heights = 0.2 * np.arange(310)[:, None] + np.zeros(9)
        np.testing.assert_allclose(path.height_mm(turns), heights, atol=1e-9)


@pytest.mark.parametrize("ramp", [0.05, 0.3, 0.5])
def test_ramp_has_its_speed_and_acceleration(ramp: float) -> None:
    """Speed never jumps; its highest and the acceleration are those of the formulas."""
    path = ToolPath("ring-helix", 0.0, 1.0, 0.2, ramp)
    turns = np.linspace(0, 3, 300_001)
    speed = np.gradient(path.height_mm(turns), turns)
    acceleration = np.gradient(speed, turns)
    assert speed.max() == pytest.approx(0.2 / (1 - ramp), rel=1e-3)
    assert np.abs(acceleration).max() == pytest.approx(0.2 / (ramp * (1 - ramp)), rel=1e-3)
    assert np.abs(np.diff(speed)).max() < 1e-3


@pytest.mark.parametrize(
    ("speed_mm_s", "acceleration_mm_s2"), [(200.0, 2000.0), (10.0, 2000.0), (200.0, 100.0)]
)
def test_highest_speed_is_the_edge(speed_mm_s: float, acceleration_mm_s2: float) -> None:
    """Just below the speed that a refusal names there is a ramp, just above there is none."""
    limits = MachineLimits(z_speed_mm_s=speed_mm_s, z_acceleration_mm_s2=acceleration_mm_s2)
    rpm = highest_rpm(0.2, limits)
    ramp = ramp_of(0.2, rpm * 0.9999, limits)
    assert 0 < ramp <= 0.5
    assert 0.2 * rpm / 60 / (1 - ramp) <= speed_mm_s * 1.0001
    with pytest.raises(CamtoolsError, match=rf"at {np.floor(rpm * 10) / 10:.1f} r/min at most"):
        ramp_of(0.2, rpm * 1.0001, limits)


def test_ramp_is_the_shortest() -> None:
    """Z's acceleration is used to the full; slowly turned parts have room for a 256th of a turn."""
    limits = MachineLimits()
    assert ramp_of(0.1, 10, limits) == LEAST_RAMP == 1 / 256
    ramp = ramp_of(0.2, 2500, limits)
    acceleration = 0.2 * (2500 / 60) ** 2 / (ramp * (1 - ramp))
    assert acceleration == pytest.approx(limits.z_acceleration_mm_s2)


def test_spacing_of_the_tracks() -> None:
    """At the long axis one track is double and the spacing dZ, opposite dZ/2, else s and 1 - s."""
    for angle, spacings in ((0.0, {0.0, 0.2}), (0.5, {0.1}), (0.25, {0.05, 0.15})):
        tracks = RING.tracks_mm(angle)
        assert set(np.round(np.diff(tracks), 9).tolist()) == spacings
    assert set(np.round(np.diff(PLAIN.tracks_mm(0.25)), 9).tolist()) == {0.1}


def with_process(text: str) -> SkirtPart:
    """Return the Perkins part with more lines in [process]."""
    good = PERKINS.read_text()
    return parse_part(good.replace("[process]", f"[process]\n{text}"))


def test_comparison_of_paths() -> None:
    """Turns, times and scallops are those of the formulas; means by integrals over the map."""
    ring, half, same = make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits()).rows
    assert [one.path.turns for one in (ring, half, same)] == [621, 620, 310]
    assert [one.time_s for one in (ring, half, same)] == pytest.approx([37.26, 37.2, 18.6])
    highest = [one.scallop_um.max() for one in (ring, half, same)]
    assert highest == pytest.approx([6.25, 1.5625, 6.25], rel=1e-3)
    # The mean over a spacing w is w^2 / (24 nose). The spacings s dZ and (1 - s) dZ hold shares s
    # and 1 - s of the surface, and over the turn the mean of s^3 + (1 - s)^3 is 1/2; the ramp,
    # 3 % of the turn, adds a little.
    assert half.scallop_um.mean() == pytest.approx(0.1**2 / (24 * 0.8) * 1000, rel=0.01)
    assert ring.scallop_um.mean() == pytest.approx(0.2**2 / (24 * 0.8) / 2 * 1000, rel=0.03)
    assert ring.z_acceleration_mm_s2 == pytest.approx(2000)
    assert ring.z_speed_mm_s == pytest.approx(0.2 * 1000 / 60 / (1 - ring.path.ramp))
    # where Z cannot follow a ring-helix it is compared at its highest speed
    ring, half, _ = make_study(0.0, 62.0, 1.0, 2500.0, 0.8, MachineLimits()).rows
    assert ring.rpm == pytest.approx(highest_rpm(1.0, MachineLimits()))
    assert half.rpm == 2500
    assert ring.path.ramp == pytest.approx(0.5, abs=1e-3)


def test_path_of_a_part() -> None:
    """The part file chooses the path; its limits choose the ramp."""
    assert path_of(with_process(""), 0, 62) == ToolPath("helix", 0, 62, 0.1)
    path = path_of(with_process('path = "ring-helix"'), 0, 62)
    assert (path.kind, path.n_rings) == ("ring-helix", 621)
    assert path.ramp == ramp_of(0.1, 2500, MachineLimits())


def test_table_tells_the_controller_its_path() -> None:
    """The table of a ring-helix is that of a helix but for the path; it is read back."""
    ring = generate(with_process('path = "ring-helix"')).table
    plain = generate(with_process("")).table
    images = [pack(ring), pack(plain)]
    differing = [i for i, (a, b) in enumerate(zip(*images, strict=True)) if a != b]
    assert [i for i in differing if i not in range(20, 24)] == [252]  # but for the CRC
    assert [unpack(image).is_ring_helix for image in images] == [True, False]


def test_no_table_for_a_path_that_z_cannot_follow(perkins: SkirtPart) -> None:
    """Numbers, the highest speed and the largest feed that would do; mkgcode for stepped paths."""
    assert refused(lambda: generate(with_limits(z_acceleration_mm_s2=400))) == (
        'process.path = "ring-helix": needs at least 694.444444 mm/s2 of Z, z_acceleration_mm_s2 '
        "is 400; turn at 1897.3 r/min at most, with a feed of 0.0576 mm at most, "
        'or with path = "helix"'
    )
    with pytest.raises(CamtoolsError, match=r"mm/s of Z, z_speed_mm_s is 4; turn at 2"):
        generate(with_limits(z_speed_mm_s=4))
    process = perkins.process.model_copy(update={"path": "stepped", "spindle_rpm": 500.0})
    with pytest.raises(CamtoolsError, match=r"process\.path: .*mkgcode.*ring-helix"):
        generate(perkins.model_copy(update={"process": process}))


def with_limits(**limits: float) -> SkirtPart:
    """Return the Perkins part along a ring-helix on another machine."""
    part = with_process('path = "ring-helix"')
    machine = part.machine.model_copy(
        update={"limits": part.machine.limits.model_copy(update=limits)}
    )
    return part.model_copy(update={"machine": machine})


@pytest.mark.parametrize(
    ("rpm", "speed_mm_s", "acceleration_mm_s2"),
    [(2500.0, 200.0, 2000.0), (2500.0, 5.0, 2000.0), (1.0, 0.1, 2000.0), (60.0, 200.0, 10.0)],
)
def test_largest_feed_is_the_edge(rpm: float, speed_mm_s: float, acceleration_mm_s2: float) -> None:
    """Just below the feed that a refusal names there is a ramp, just above there is none."""
    limits = MachineLimits(z_speed_mm_s=speed_mm_s, z_acceleration_mm_s2=acceleration_mm_s2)
    feed_mm = largest_feed_mm(rpm, limits)
    assert LEAST_RAMP <= ramp_of(feed_mm * 0.9999, rpm, limits) <= 0.5
    with pytest.raises(CamtoolsError, match="needs at least"):
        ramp_of(feed_mm * 1.0001, rpm, limits)


def test_stepped_path() -> None:
    """Z stands for every turn and jumps at its end, which must be possible; scallop of a helix."""
    path = ToolPath("stepped", 1.0, 1.5, 0.2)
    assert (path.n_rings, path.turns) == (4, 4.0)
    turns = np.array([0.0, 0.5, 0.999, 1.0, 1.999, 2.0, 3.0, 3.999, 4.0, 9.0])
    assert path.height_mm(turns) == pytest.approx([1, 1, 1, 1.2, 1.2, 1.4, 1.5, 1.5, 1.5, 1.5])
    with pytest.raises(CamtoolsError, match=r"turn at 2121\.3 r/min at most, feed less") as info:
        step_of(0.1, 2500.0, MachineLimits())
    assert "14.1 ms" in str(info.value)
    assert step_of(0.1, 2121.3, MachineLimits())[0] <= 0.5
    path = ToolPath("stepped", 0.0, 2.0, 0.1)
    z = np.linspace(0.5, 1.5, 2001)
    for angle in (0.0, 0.3, 0.7):
        assert path.scallop_mm(angle, z, 0.8).max() == pytest.approx(0.1**2 / 6.4, rel=1e-3)


def test_step_is_the_quickest_within_the_limits() -> None:
    """Speed and acceleration of Z, differenced from its heights, reach their limits, not more."""
    for feed_mm, rpm in ((0.1, 500.0), (2.0, 300.0)):
        limits = MachineLimits(z_speed_mm_s=40.0, z_acceleration_mm_s2=2000.0)
        share, ramp = step_of(feed_mm, rpm, limits)
        path = ToolPath("stepped", 0.0, 3 * feed_mm, feed_mm, ramp, share)
        t_s = np.linspace(0, 60 / rpm, 200_001)
        z = path.height_mm(t_s * rpm / 60)
        assert z[t_s * rpm / 60 < 1 - share - 1e-6] == pytest.approx(0.0)
        assert path.height_mm(np.array([1.0, 1.5])) == pytest.approx([feed_mm, feed_mm])
        speed = np.diff(z) / np.diff(t_s)
        bend = np.diff(z[::100], 2) / (t_s[100] - t_s[0]) ** 2
        v = min(40.0, np.sqrt(feed_mm * 2000))
        assert speed.max() == pytest.approx(v, rel=1e-3)
        assert np.abs(bend).max() == pytest.approx(2000, rel=1e-2)
        assert share == pytest.approx(rpm / 60 * (feed_mm / v + v / 2000), rel=1e-12)


def test_analysis_has_the_steps_beside_the_paths() -> None:
    """Time, speed and acceleration of Z, scallop and edge of the Perkins skirt at 500 r/min."""
    study = make_study(0.0, 62.0, 0.1, 500.0, 0.8, MachineLimits())
    *_, row = study_csv(study, 0.0062619048).splitlines()
    words = dict(zip(study_csv(study, 0.0).splitlines()[0].split(","), row.split(","), strict=True))
    assert words["path"] == '"stepped"'
    assert float(words["turns"]) == 621
    assert float(words["time_s"]) == pytest.approx(621 * 60 / 500)
    assert float(words["z_speed_mm_s"]) == pytest.approx(np.sqrt(0.1 * 2000), abs=1e-4)
    assert float(words["z_acceleration_mm_s2"]) == pytest.approx(2000, abs=0.01)
    assert float(words["step_turns"]) == pytest.approx(2 * np.sqrt(0.1 / 2000) * 500 / 60, abs=1e-6)
    assert float(words["scallop_max_um"]) == pytest.approx(1.5625, abs=1e-4)
    assert float(words["edge_um"]) == pytest.approx(0.6262, abs=1e-4)
    slow = make_study(0.0, 62.0, 0.1, 2500.0, 0.8, MachineLimits())
    assert slow.stepped.rpm == pytest.approx(2121.3, abs=0.05)
