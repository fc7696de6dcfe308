"""Patterns of shafts: one for each profile, shared by its lobes, and what lies between two."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, Ints
from camtools.lobe.channels import choose_angle, choose_lift, patterns_of
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.motion import ShaftLobe, example_lobe, make_lobes
from camtools.table.channel import MAX_CHANNEL_BYTES
from camtools.table.image import pack
from tests.tools.cases.lobe_cases import NM, cam, evaluate
from tests.tools.cases.part_cases import ROOT

PARTS = ROOT / "tools" / "parts"
TEXT = (PARTS / "cam-345.toml").read_text()
GROUND = TEXT.replace('"turning"', '"grinding"')
SHARED_BYTES = 65_536
KEPT_OFF_MM = 0.02


def pitched(n: int, width_mm: float, gap_mm: float) -> list[tuple[float, float]]:
    """Return places of lobes of one width, apart by one gap."""
    pitch_mm = width_mm + gap_mm
    return [(round(i * pitch_mm, 6), round(i * pitch_mm + width_mm, 6)) for i in range(n)]


def shaft(text: str, places: list[tuple[float, float]], n_profiles: int = 2) -> str:
    """Return the part with lobes of several profiles at places and angles of their own."""
    start, end = text.index("[[cam.lobe]]"), text.index("[process]")
    lobes = ""
    for i, z_mm in enumerate(places):
        lobe = text[start:end].replace("[0, 12]", str(list(z_mm)))
        lobe = lobe.replace("phase_deg = 0", f"phase_deg = {i * 37.123457 % 360:.6f}")
        lobes += lobe.replace("lift_mm = 8", f"lift_mm = {8 - i % n_profiles * 0.25}")
    return text[:start] + lobes + text[end:].replace("spindle_rpm = 60", "spindle_rpm = 10")


SHAFTS = [
    (pitched(8, 14, 31), 2),
    (pitched(64, 10, 5), 2),
    ([(0, 3), (3.2, 6.2)], 2),
    (pitched(1, 700, 0), 1),
    ([(-300.0, -100.0), (0.0, 100.0), (100.2, 300.0)], 3),
]


def share_of(z_mm: Floats, places: list[tuple[float, float]]) -> tuple[Ints, Floats]:
    """Return the lobe and the share of its lift at heights, by the words of the format."""
    edges = np.array(places)
    middles = (edges[1:, 0] + edges[:-1, 1]) / 2
    i = np.searchsorted(middles, z_mm, side="right")
    beside = np.maximum(edges[i, 0] - z_mm, z_mm - edges[i, 1]) - KEPT_OFF_MM
    between = edges[1:, 0] - edges[:-1, 1]
    gaps = np.concatenate([[np.inf], between, [np.inf]])
    half = np.where(z_mm < edges[i, 0], gaps[i], gaps[i + 1]) / 2 - KEPT_OFF_MM
    s = np.clip(beside / half, 0, 1)
    return i, 1 - s**3 * (10 - 15 * s + 6 * s**2)


def check_lift(result: GeneratedLobes, places: list[tuple[float, float]], folder: Path) -> None:
    """Compare camsim eval with the exact lift on every lobe and between them."""
    edges = np.array(places).ravel()
    heights = np.unique(np.concatenate([edges, np.linspace(edges[0], edges[-1], 301)]))
    turn = np.linspace(0, 1, 73)
    got = evaluate(folder, result, np.tile(turn, heights.size), np.repeat(heights, turn.size))
    i_lobe, share = share_of(np.round(heights, 6), places)
    lift = np.array([lobe.at(2 * np.pi * turn).lift for lobe in result.lobes])
    exact_mm = share[:, None] * lift[i_lobe]
    u_mm = got["u_nm"].reshape(exact_mm.shape) * NM
    assert np.abs(u_mm - exact_mm).max() <= 1.05e-5  # 10 nm, and the height's own rounding
    assert u_mm.min() >= -1e-5 and u_mm.max() <= lift.max() + 1e-5
    angle_deg = np.degrees(np.array([lobe.at(2 * np.pi * turn).angle for lobe in result.lobes]))
    off_deg = got["contact_deg"].reshape(exact_mm.shape) - share[:, None] * angle_deg[i_lobe]
    assert np.abs(off_deg).max() <= 1.05e-4


@pytest.mark.parametrize("text", [TEXT, GROUND], ids=["turned", "ground"])
@pytest.mark.parametrize(("places", "n_profiles"), SHAFTS)
def test_shafts_are_exact_on_every_lobe_and_between(
    places: list[tuple[float, float]], n_profiles: int, text: str, tmp_path: Path
) -> None:
    """Every lobe has its lift; between two the follower goes down to the base circle and up."""
    result = generate_lobes(cam(shaft(text, places, n_profiles)))
    image = pack(result.table)
    if n_profiles <= 2:
        assert len(image) <= SHARED_BYTES
    counts = {one.n_slices for one in result.table.channels if one.has_patterns}
    assert counts == {max(2, n_profiles)}
    check_lift(result, places, tmp_path)


def test_table_of_eight_lobes_holds_two_profiles() -> None:
    """The example part: 8 lobes of 14 mm at a pitch of 45 mm, in at most 64 KiB at 10 nm."""
    result = generate_lobes(cam((PARTS / "camshaft8.toml").read_text()))
    assert [lobe.profile for lobe in result.lobes] == [0, 1] * 4
    assert len(pack(result.table)) <= SHARED_BYTES
    assert result.lift.error <= 10


def test_speed_of_each_lobe_goes_to_the_mean_in_the_gap(tmp_path: Path) -> None:
    """The ratio of a lobe is kept while U moves, and is 1 in the middle of the gap."""
    places = pitched(2, 10, 5)
    text = shaft(GROUND.replace('"uniform"', '"constant-surface"'), places)
    result = generate_lobes(cam(text.replace("spindle_rpm = 10\n", "spindle_rpm = 60\n", 1)))
    turn = np.linspace(0, 1, 181)
    heights = np.array([5.0, 10.0, 10.6, 11.875, 12.5, 14.4, 15.0])
    got = evaluate(tmp_path, result, np.tile(turn, heights.size), np.repeat(heights, turn.size))
    ratio = got["speed_ratio"].reshape(heights.size, -1)
    lift = got["u_nm"].reshape(heights.size, -1)
    assert np.array_equal(ratio[0], ratio[1])
    assert np.abs(ratio[2] - ratio[0]).max() <= 1e-3 < np.abs(lift[2]).max() * NM
    assert np.abs(lift[3]).max() == 0 and np.abs(ratio[3] - 1).max() > 0.1
    assert np.all(ratio[4] == 1) and np.all(lift[4] == 0)
    assert np.abs(lift[5] - lift[6]).max() * NM > 1


def test_too_many_profiles_are_told_how_many_would_do() -> None:
    """1 MiB at 2048 knots is 42 patterns; what is asked for is taken."""
    [lobe] = make_lobes(example_lobe())
    lobes = [replace(lobe, z_mm=z_mm, profile=i) for i, z_mm in enumerate(pitched(43, 5, 5))]
    with pytest.raises(GeometryError) as info:
        choose_angle(lobes, is_swung=True)
    assert info.value.lines == [
        "cam.lobe: has 43 different profiles: the swing channel needs 2048 knots of each, 1056768 "
        "bytes, and may have 1048576; make tables of at most 42 profiles each"
    ]
    assert choose_angle(lobes[:42], is_swung=True).channel.size <= MAX_CHANNEL_BYTES


def test_phase_is_part_of_the_error() -> None:
    """A phase is rounded to 2^-32 turn; the error that is told holds what that does to u."""
    lobes = make_lobes(cam(shaft(TEXT, pitched(2, 5, 5), 1)))
    alone: list[ShaftLobe] = patterns_of(lobes)
    shared, bare = choose_lift(lobes, 10.0), choose_lift(alone, 10.0)
    assert shared.error - bare.error == pytest.approx(1.2e7 * 2 * np.pi / 2**33, rel=0.1)
