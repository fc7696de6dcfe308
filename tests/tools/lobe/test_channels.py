"""Slices of shafts: the fewest that fit the gaps, and what is told where none do."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import GeometryError
from camtools.lobe.channels import choose_angle, choose_lift, slices_of
from camtools.lobe.generate import generate_lobes
from camtools.lobe.motion import ShaftLobe, example_lobe, make_lobes
from camtools.table.image import MAX_CHANNEL_BYTES
from lobe_cases import NM, cam, evaluate
from part_cases import ROOT

PARTS = ROOT / "tools" / "parts"
TEXT = (PARTS / "cam-345.toml").read_text()


def shaft(*places: tuple[float, float]) -> list[ShaftLobe]:
    """Return the worked lobe at several places of a shaft."""
    [lobe] = make_lobes(example_lobe())
    return [replace(lobe, z_mm=z_mm) for z_mm in places]


def pitched(n: int, width_mm: float, gap_mm: float) -> list[tuple[float, float]]:
    """Return places of lobes of one width, apart by one gap."""
    pitch_mm = width_mm + gap_mm
    return [(round(i * pitch_mm, 6), round(i * pitch_mm + width_mm, 6)) for i in range(n)]


SHAFTS = [
    (pitched(6, 10, 5), 24),
    (pitched(8, 14, 8), 24),
    (pitched(10, 14, 14), 30),
    ([(0, 3), (3.2, 6.2)], 40),
    ([(0, 1), (1.2, 2.2)], 16),
    (pitched(1, 335.545, 0), 22),
    ([(0, 14.3), (19.1, 33), (41.7, 56), (60, 74), (83.2, 97), (101.3, 115)], 40),
]


@pytest.mark.parametrize(("places", "n_slices"), SHAFTS)
def test_ordinary_camshafts_fit(
    places: list[tuple[float, float]], n_slices: int, tmp_path: Path
) -> None:
    """Every lobe is exact from edge to edge, in channels of at most 1 MiB."""
    start, end = TEXT.index("[[cam.lobe]]"), TEXT.index("[process]")
    lobes = "".join(
        TEXT[start:end].replace("[0, 12]", str(list(z_mm))).replace("= 0\n", f"= {i * 37}\n")
        for i, z_mm in enumerate(places)
    )
    text = TEXT[:start] + lobes + TEXT[end:].replace("spindle_rpm = 60", "spindle_rpm = 10")
    result = generate_lobes(cam(text))
    assert max(channel.size for channel in result.table.channels) <= MAX_CHANNEL_BYTES
    assert {channel.n_slices for channel in result.table.channels} == {n_slices}
    turn = np.linspace(0, 1, 101)
    z_mm = np.repeat(np.ravel(places), turn.size)
    got = evaluate(tmp_path, result, np.tile(turn, 2 * len(places)), z_mm)
    exact = [lobe.at(2 * np.pi * turn) for lobe in result.lobes for _ in range(2)]
    assert np.abs(got["u_nm"] - np.ravel([one.lift for one in exact]) / NM).max() <= 10
    swing = np.degrees(np.ravel([one.angle for one in exact]))
    assert np.abs(got["swing_deg"] - swing).max() <= 1e-4


def changes_in(gap: tuple[int, int], span: int, n: int) -> bool:
    """Return whether two of n slices are inside a gap [nm], 20 um off its edges."""
    low, high = gap[0] + 20_000, gap[1] - 20_000
    at = [Fraction(i * span, n - 1) for i in range(n)]
    return any(low <= below and above <= high for below, above in pairwise(at))


@pytest.mark.parametrize("seed", range(4))
def test_slices_are_the_fewest_that_change_in_the_gaps(seed: int) -> None:
    """Lobes at random: each of fewer slices fails in one of the gaps, looked at one by one."""
    rng = np.random.default_rng(seed)
    ends = np.cumsum(rng.integers(1500, 9000, 8)) * 1000
    edges = (ends - ends[0]).tolist()
    gaps, span = list(zip(edges[1:-1:2], edges[2::2], strict=True)), edges[-1]
    lobes = shaft(*((a * NM, b * NM) for a, b in zip(edges[::2], edges[1::2], strict=True)))
    slices = slices_of(lobes)
    assert all(changes_in(gap, span, slices.size) for gap in gaps)
    for n in range(2, slices.size):
        assert not all(changes_in(gap, span, n) for gap in gaps)
    at = np.arange(slices.size) * span / (slices.size - 1)
    for i, lobe in enumerate(lobes):
        inside = (at > lobe.z_mm[0] / NM - 20_000) & (at < lobe.z_mm[1] / NM + 20_000)
        assert np.all(slices[inside] == i)


def refused(places: list[tuple[float, float]]) -> str:
    """Return what is told of a shaft whose swing does not fit."""
    with pytest.raises(GeometryError) as info:
        choose_angle(shaft(*places), is_swung=True)
    [line] = info.value.lines
    return line


def test_shaft_that_no_table_holds_is_told_which_gap_would_do() -> None:
    """The pair, its gap, bytes and limit are told; the gap asked for is taken."""
    line = refused(pitched(12, 12, 6))
    assert line == (
        "cam.lobe.1.z_mm: with a gap of 6 mm above cam.lobe.0 the swing channel needs 48 slices "
        "of 2048 knots, 1179648 bytes, and may have 1048576; make every gap at least 6.7 mm wide "
        "or make tables of fewer lobes each"
    )
    assert choose_angle(shaft(*pitched(12, 12, 6.7)), is_swung=True).channel.size <= 1 << 20
    line = refused([(0, 30), (50, 80), (80.4, 110), (130, 160)])
    assert line.startswith("cam.lobe.2.z_mm: with a gap of 0.4 mm above cam.lobe.1 the swing")
    wide_mm = float(line.partition("every gap at least ")[2].partition(" ")[0])
    moved = [(80 + wide_mm, 109.6 + wide_mm), (129.6 + wide_mm, 159.6 + wide_mm)]
    assert choose_angle(shaft((0, 30), (50, 80), *moved), is_swung=True).error <= 1e-4


def test_shaft_beyond_the_format_is_told_which_gap_would_do() -> None:
    """No 4096 slices change over inside the gap; the one that is told suits the angle's bytes."""
    places = [(-300.0, -100.0), (0.0, 100.0), (100.2, 300.0)]
    line = refused(places)
    begin = "cam.lobe.2.z_mm: with a gap of 0.2 mm above cam.lobe.1 "
    assert line.startswith(f"{begin}there is none of 37 .. 4096 slices that fits; make every gap")
    wide_mm = float(line.partition("every gap at least ")[2].partition(" ")[0])
    places[2] = (100 + wide_mm, 299.8 + wide_mm)
    assert choose_angle(shaft(*places), is_swung=True).channel.size <= MAX_CHANNEL_BYTES


def test_long_lobe_is_told_how_long_one_may_be() -> None:
    """1 MiB at 2048 knots is 42 slices; what is asked for is taken."""
    line = refused([(0, 700)])
    assert line == (
        "cam.lobe: reaches over 700 mm, the swing channel needs 43 slices of 2048 knots, 1056768 "
        "bytes, and may have 1048576; make tables of pieces of at most 687.865 mm"
    )
    assert choose_angle(shaft((0, 687.865)), is_swung=True).channel.n_slices == 42


@pytest.mark.slow
def test_larger_tolerance_is_told_where_it_helps() -> None:
    """Where u alone is too large; not where the angle would be too."""
    [lobe] = make_lobes(example_lobe("grinding"))
    lobes = [replace(lobe, z_mm=z_mm) for z_mm in pitched(12, 12, 6)]
    with pytest.raises(GeometryError, match="the u channel needs 48 slices of 2048") as info:
        choose_lift(lobes, 0.205)
    tolerance_nm = float(info.value.lines[0].rpartition(" a tolerance_nm of at least ")[2])
    assert choose_lift(lobes, tolerance_nm).channel.size <= MAX_CHANNEL_BYTES
    with pytest.raises(GeometryError, match="the u channel needs 836 slices of 256") as info:
        choose_lift(shaft((0, 50), (50.2, 100)), 10.0)
    assert "tolerance" not in info.value.lines[0]
