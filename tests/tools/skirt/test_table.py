"""Tables of skirts: tolerance kept, bounds true, runs, passes, feed laws, corrections."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PPoly

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.cut.correction import Correction, correction_of, nodes_of
from camtools.part.common import FeedLaw
from camtools.pipeline.load import Made, load, make
from camtools.skirt.geometry.belt import continued
from camtools.skirt.geometry.run_in import with_run
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.table.accuracy import DERIVATIVE_SHARE, UnreachableError
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.skirt.tool.turning import (
    TOLERANCE_NM,
    height_at_mm,
    largest_share,
    middle_nm,
    way_channel,
)
from camtools.table.channel import KIND_U, KIND_X, ImageError
from camtools.table.evaluate import evaluate_at, evaluate_x, jumps
from camtools.table.image import pack, unpack
from tests.tools.cases.camsim_cases import cut, refusal
from tests.tools.cases.cut_cases import PARTS, evaluated, made_skirt, tip_mm, written
from tests.tools.cases.part_cases import PERKINS, changed, load_part, refused, sure


def random_points(result: GeneratedSkirt, n: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Return turns (any sign) and heights in mm, both ends and the drawing's nodes included."""
    random = np.random.default_rng(7)
    first, last = result.geometry.z_first_mm, result.geometry.z_last_mm
    z_mm = random.uniform(first, last, n)
    nodes = result.geometry.breaks_mm()
    z_mm[: nodes.size] = nodes
    return random.uniform(-3, 3, n), z_mm


def errors_nm(result: GeneratedSkirt) -> tuple[float, float, float, float]:
    """Return errors of u, u' share, u'' share and x at random points, apart from the generator."""
    turn, z_mm = random_points(result)
    table = unpack(pack(result.table))
    u = evaluate_at(table.channel(KIND_U), turn, z_mm * 1e6)
    exact = result.geometry.delta(2 * np.pi * turn, z_mm)
    x = evaluate_x(table.channel(KIND_X), z_mm * 1e6).value - result.geometry.radius_mm(z_mm) * 1e6
    first, second = np.abs(exact.d1).max() * 1e6, np.abs(exact.d2).max() * 1e6
    return (
        float(np.abs(u.value - exact.delta * 1e6).max()),
        float(np.abs(u.d1 - exact.d1 * 1e6).max() / first) if first else 0.0,
        float(np.abs(u.d2 - exact.d2 * 1e6).max() / second) if second else 0.0,
        float(np.abs(x).max()),
    )


def test_perkins_keeps_1_nm_in_16_kib(generated: GeneratedSkirt) -> None:
    """The Perkins 240 table is within 1 nm in at most 16 KiB; what it reports covers its errors."""
    u_nm, first, second, x_nm = errors_nm(generated)
    assert u_nm <= generated.accuracy_u.value_nm <= 1.0
    assert x_nm <= generated.accuracy_x.value_nm <= 1.0
    assert generated.table.bounds.error_pm >= 1000 * max(u_nm, x_nm)
    assert max(first, second) <= DERIVATIVE_SHARE
    assert len(pack(generated.table)) <= 16 * 1024


def test_each_tolerance_is_kept_in_no_fewer_bytes(perkins: SkirtPart) -> None:
    """For values and derivatives; bytes never fall when the tolerance does."""
    sizes = []
    for tolerance_nm in (100.0, 10.0, 0.3, 0.05):
        made = generate(perkins, tolerance_nm)
        u_nm, first, second, x_nm = errors_nm(made)
        assert max(u_nm, x_nm) <= tolerance_nm
        assert max(first, second) <= DERIVATIVE_SHARE
        sizes.append(len(pack(made.table)))
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("tolerance_nm", [1e-9, 0.001])
def test_unreachable_tolerance_tells_the_best(perkins: SkirtPart, tolerance_nm: float) -> None:
    """A tolerance below what the format can do is refused, and the named best is reachable."""
    with pytest.raises(UnreachableError, match=r"tolerance_nm = .*best achievable is") as info:
        generate(perkins, tolerance_nm)
    assert len(info.value.lines) == 1
    result = generate(perkins, 1.2 * info.value.best_nm)
    assert max(errors_nm(result)[0], errors_nm(result)[3]) <= 1.2 * info.value.best_nm


def test_senseless_tolerance_is_refused(perkins: SkirtPart) -> None:
    """A tolerance that is no length is refused by name."""
    for tolerance_nm in (0.0, -1.0, float("nan"), float("inf"), 1e7):
        with pytest.raises(CamtoolsError, match="tolerance_nm"):
            generate(perkins, tolerance_nm)


def test_guaranteed_bounds_are_true(generated: GeneratedSkirt) -> None:
    """Nothing lies beyond the header's bounds nor far inside; nothing jumps at a knot."""
    bounds = generated.table.bounds
    turn, z_mm = random_points(generated, 20_000)
    turn[:1000], z_mm[:500], z_mm[500:1000] = np.linspace(0, 1, 1000), 62.0, 0.0
    u = evaluate_at(generated.table.channel(KIND_U), turn, z_mm * 1e6)
    assert bounds.u_min_nm <= u.value.min()
    assert u.value.max() <= bounds.u_max_nm <= u.value.max() + 3
    assert np.abs(u.d1).max() <= bounds.u1_peak_nm_per_rad <= 1.001 * np.abs(u.d1).max()
    assert np.abs(u.d2).max() <= bounds.u2_peak_nm_per_rad2 <= 1.001 * np.abs(u.d2).max()
    for channel in generated.table.channels:
        for place in jumps(channel):
            assert place == (0.0, 0.0, 0.0)


def part_of(**changes: object) -> SkirtPart:
    """Return a short skirt with some tables of the part file changed."""
    limits = {"u_stroke_mm": 30.0, "u_speed_mm_s": 1e5, "u_acceleration_mm_s2": 1e9}
    values = {f"piston.{name}": table for name, table in changes.items()}
    values |= {f"machine.limits.{name}": limit for name, limit in limits.items()}
    return changed(load_part(PERKINS), values)


def test_round_and_double_ellipse() -> None:
    """Without ovality the table is all zero; a double ellipse is deeper by G beta / 50."""
    result = generate(part_of(ovality={"height_mm": [0, 62], "ovality_mm": [0.0, 0.0]}))
    assert errors_nm(result)[0] == 0.0
    assert result.table.bounds.u2_peak_nm_per_rad2 <= 1
    result = generate(part_of(section={"shape": "double-ellipse", "beta": 2.0}))
    assert errors_nm(result)[0] <= 1.0
    u = evaluate_at(result.table.channel(KIND_U), np.array([0.125]), np.array([62e6]))
    assert u.value[0] == pytest.approx((0.3 / 4 + 0.3 * 2 / 50) * 1e6, abs=1.0)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
@given(
    heights=st.lists(st.integers(1, 79), min_size=1, max_size=4, unique=True),
    ovality_mm=st.lists(st.floats(0, 1), min_size=6, max_size=6),
    drop_mm=st.lists(st.floats(0, 0.3), min_size=6, max_size=6),
    diameter_mm=st.floats(40, 250),
    shape=st.sampled_from(["ellipse", "cosine", "double-ellipse"]),
    interpolation=st.sampled_from(["linear", "spline"]),
)
def test_random_parts_keep_the_tolerance(
    heights: list[int],
    ovality_mm: list[float],
    drop_mm: list[float],
    diameter_mm: float,
    shape: str,
    interpolation: str,
) -> None:
    """Any part that the generator accepts is within the tolerance at random points."""
    z = [0, *sorted(heights), 80]
    common = {"height_mm": z, "overshoot_um": 1e6}
    diameters_mm = [diameter_mm - drop for drop in drop_mm[: len(z)]]
    profile = common | {"diameter_mm": diameters_mm, "spline": "natural"}
    ovality = common | {"ovality_mm": ovality_mm[: len(z)], "interpolation": interpolation}
    section = {"shape": shape, "beta": 1.5 if shape == "double-ellipse" else 0.0}
    part = part_of(profile=profile, ovality=ovality, section=section)
    try:
        result = generate(part, 5.0)
    except CamtoolsError as error:
        assert "falls to" in str(error) or "unreachable" in str(error)
        return
    u_nm, first, second, x_nm = errors_nm(result)
    assert max(u_nm, x_nm) <= 5.0
    assert max(first, second) <= DERIVATIVE_SHARE


@pytest.mark.parametrize(
    ("limit", "value", "needed"),
    [
        ("u_stroke_mm", 0.1, 0.300),
        ("u_speed_mm_s", 20.0, 39.27),
        ("u_acceleration_mm_s2", 10_000.0, 20727.0),
        ("spindle_rpm", 2000.0, 2500.0),
    ],
)
def test_infeasible_part_is_refused_with_numbers(limit: str, value: float, needed: float) -> None:
    """A limit that is too low is refused with the number needed and the speed that would do."""
    weak = changed(load_part(PERKINS), {f"machine.limits.{limit}": value})
    line = refused(lambda: generate(weak))
    assert line.startswith(f"machine.limits.{limit} = {value:.9g}")
    assert float(line.split("needs ")[1].split()[0]) == pytest.approx(needed, rel=1e-3)
    assert "at most" in line or "no speed helps" in line


def part_with(**process: object) -> SkirtPart:
    """Return the example with a nose and other keys of [process]; None takes one away."""
    raw, nose_mm = example_part().model_dump(), process.pop("nose_mm", 0.0)
    wanted = raw["process"] | process
    raw["process"] = {key: value for key, value in wanted.items() if value is not None}
    raw["tool"] |= {"nose_radius_mm": nose_mm}
    return SkirtPart.model_validate(raw)


def test_curve_and_its_two_derivatives_go_on() -> None:
    """At both ends of random cubics value, slope and curvature have no jump, inside all is kept."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        x = np.sort(rng.uniform(0, 50, 5))
        curve = PPoly(rng.normal(0, 0.01, (4, 4)), x)
        curve.c[3] = 40 + rng.uniform(0, 1, 4)
        runs = rng.uniform(0.5, 5, 2)
        air = continued(curve, (x[0], x[-1]), list(runs))
        inside = rng.uniform(x[0], x[-1], 50)
        assert air(inside) == pytest.approx(curve(inside), abs=1e-11)
        for end, side in ((x[0], -1), (x[-1], 1)):
            for nu in range(3):
                near = float(air(end + side * 1e-9, nu=nu))
                assert near == pytest.approx(float(curve(end, nu=nu)), abs=1e-7)
        assert air(x[0] - runs[0], nu=2) == pytest.approx(0, abs=1e-9)
        assert air(x[-1] + runs[1], nu=2) == pytest.approx(0, abs=1e-9)


def test_run_follows_its_formula() -> None:
    """MATHS.md (102) below the lower and above the upper end; an ovality never falls below zero."""
    curve = PPoly(np.array([[0.001], [-0.02], [0.03], [45.0]]), np.array([0.0, 20.0]))
    air = continued(curve, (0.0, 20.0), [4.0, 3.0])
    d = -2.5
    assert air(d) == pytest.approx(45 + 0.03 * d - 0.04 * (d**2 / 2 + d**3 / 24), abs=1e-12)
    f0, f1, f2 = (float(curve(20.0, nu=n)) for n in range(3))
    d = 1.5
    assert air(20 + d) == pytest.approx(f0 + f1 * d + f2 * (d**2 / 2 - d**3 / 18), abs=1e-10)
    curve = PPoly(np.array([[0.05], [0.01]]), np.array([0.0, 2.0]))
    air = continued(curve, (0.0, 2.0), [3.0, 1.0], is_ovality=True)
    assert float(air(-3.0)) == pytest.approx(0.01)
    assert float(air(3.0)) == pytest.approx(0.16)


def test_half_axis_that_vanishes_is_refused() -> None:
    """A cone of 1 : 1 has no radius 60 mm below its end."""
    profile = {"height_mm": [0, 10, 20], "diameter_mm": [60, 80, 100]}
    values = {"piston.profile": profile, "piston.ovality.height_mm": [0, 10, 20]}
    geometry = make_geometry(changed(example_part(), values))
    assert with_run(geometry, 5.0, 0.0).z_first_mm == -5.0
    with pytest.raises(GeometryError, match="run_in_mm"):
        with_run(geometry, 60.0, 0.0)


def test_table_reaches_over_the_runs_and_keeps_its_error() -> None:
    """The table of a part with runs covers them, and the skirt is that without.

    The firmware needs a turn over all that is fed.
    """
    plain, run = generate(part_with()), generate(part_with(run_in_mm=3.0, run_out_mm=1.5))
    assert (run.table.z_first_nm, run.table.z_last_nm) == (-3_000_000, 63_500_000)
    assert run.part.height_mm == 66.5
    assert run.accuracy_u.value_nm <= 1
    assert run.accuracy_x.value_nm <= 1
    assert run.geometry.skirt_mm == plain.geometry.skirt_mm == (0.0, 62.0)
    z = np.linspace(0, 62, 101)
    assert run.geometry.radius_mm(z) == pytest.approx(plain.geometry.radius_mm(z), abs=0)


def test_u_about_the_mean() -> None:
    """Only the channels' offsets differ, by the reduction's middle; half the stroke is enough."""
    long, mean = generate(part_with()), generate(part_with(u_zero="mean"))
    middle = middle_nm(mean.geometry, "mean")
    assert middle == pytest.approx(75_000, abs=1)
    for one, other in zip(long.table.channels, mean.table.channels, strict=True):
        assert np.array_equal(one.knots, other.knots)
        assert one.value_offset - other.value_offset == middle
    bounds = mean.table.bounds
    assert bounds.u_max_nm == pytest.approx(-bounds.u_min_nm, abs=3)
    short = changed(part_with(), {"machine.limits.u_stroke_mm": 0.16})
    assert 'u_zero = "mean", which needs 0.15' in refused(lambda: generate(short))
    centred = generate(changed(short, {"process.u_zero": "mean"}))
    assert centred.table.limits.u_stroke_nm == 160_000


LAW = {"height_mm": [0.0, 10.0, 50.0, 62.0], "feed_mm": [0.05, 0.15, 0.15, 0.08]}
PASSES = [
    {"allowance_um": 60.0, "feed_mm": 0.3, "spindle_rpm": 1000.0},
    {"allowance_um": 10.0},
    {"allowance_um": 0.0, "feed_mm": 0.08},
]


def test_records_are_the_passes() -> None:
    """Feed and speed that a pass leaves out are those of the process; none keeps version 1.0."""
    table = generate(part_with(**{"pass": PASSES, "passes": None})).table
    assert [tuple(one) for one in table.passes] == [
        (60_000, 300_000, 1_000_000),
        (10_000, 100_000, 2_500_000),
        (0, 80_000, 2_500_000),
    ]
    assert (table.feed_nm, table.spindle_mrpm) == (80_000, 2_500_000)
    image = pack(table)
    assert image[12:16] == b"\x01\x00\x01\x00"
    assert unpack(image).passes == table.passes
    assert pack(generate(example_part()).table)[12:16] == b"\x01\x00\x00\x00"


@pytest.mark.parametrize(
    ("stock", "told"),
    [
        ([120.0, 0.0], "leaves 120 um of 100 um"),
        ([50.0, 50.0, 0.0], "number 2 leaves 50 um of 50 um"),
        ([50.0, 20.0], "last one leaves 20 um"),
    ],
)
def test_stock_must_fall_to_the_drawing(stock: list[float], told: str) -> None:
    """A pass without depth, or a last one that leaves stock, is refused."""
    passes = [{"allowance_um": one} for one in stock]
    with pytest.raises(ValidationError, match=told):
        part_with(**{"pass": passes, "passes": None})


def test_keys_of_a_cut_that_exclude_each_other() -> None:
    """One law of the speed is made for one depth; the mean of a feed law is the feed."""
    with pytest.raises(ValidationError, match="constant spindle speed"):
        part_with(**{"pass": PASSES, "passes": None, "mode": "equal-volume", "spindle_rpm": 100})
    with pytest.raises(ValidationError, match="cannot be combined"):
        part_with(feed_law=LAW)
    with pytest.raises(ValidationError, match="helix"):
        part_with(feed_law=LAW, feed_mm=None, path="ring-helix")


def test_pass_or_feed_that_cannot_be_is_refused() -> None:
    """A pass beyond the machine is named by its number; a feed far below its mean is refused."""
    passes = [PASSES[0], PASSES[1] | {"spindle_rpm": 3500.0}, PASSES[2]]
    line = refused(lambda: generate(part_with(**{"pass": passes, "passes": None})))
    assert "process.pass number 2: machine.limits.spindle_rpm" in line
    with pytest.raises(CamtoolsError, match="nearer together"):
        way_channel(FeedLaw(height_mm=[0.0, 1.0, 60.0], feed_mm=[0.0001, 0.5, 0.5]), (0, 62000000))


def test_mean_feed_is_height_over_turns() -> None:
    """By quadrature of 1 / f over the heights, run-in included."""
    part = part_with(feed_law=LAW, feed_mm=None, run_in_mm=2.0)
    law = FeedLaw(**LAW)
    turns = quad(lambda z: 1 / float(law.at_mm(np.array(z))), -2, 62, points=[0, 10, 50])[0]
    assert part.process.feed_mm == pytest.approx(64 / turns, rel=1e-8)


@pytest.mark.long
def test_way_is_the_solution_of_its_equation() -> None:
    """Z over the turns by Runge-Kutta of dZ/dt = f(Z), MATHS.md (103)."""
    law, ends = FeedLaw(**LAW), (0.0, 62.0)
    mean = law.mean_mm(*ends)
    turns = np.linspace(0, 62 / mean, 300)
    found = solve_ivp(
        lambda _, z: law.at_mm(z), (0, turns[-1]), [0.0], t_eval=turns, rtol=1e-9, atol=1e-10
    )
    assert height_at_mm(law, ends, mean * turns)[:-1] == pytest.approx(found.y[0][:-1], abs=1e-6)
    channel = way_channel(law, (0, 62_000_000))
    z_nm = np.minimum(mean * turns * 1e6, 62e6)
    ahead = evaluate_x(channel, z_nm).value
    assert np.abs(ahead + z_nm - found.y[0] * 1e6).max() < TOLERANCE_NM + 2
    assert largest_share(channel) == pytest.approx(0.15 / mean, rel=1e-3)


def test_table_with_a_way_is_accepted_and_checked() -> None:
    """The image is of version 1.1; a way that turns back or does not end at 0 is refused."""
    table = generate(part_with(feed_law=LAW, feed_mm=None)).table
    image = pack(table)
    assert image[12:16] == b"\x01\x00\x01\x00"
    assert unpack(image).way is not None
    way = sure(table.way)
    for place, column in ((-1, 0), (3, 1)):
        knots = way.knots.copy()
        knots[place, 0, column] -= way.v_max * (1 if column == 0 else 3)
        low, high = int(knots[..., 0].min()), int(knots[..., 0].max())
        wrong = replace(way, knots=knots, p_min=low, p_max=high, v_max=3 * way.v_max + 1)
        with pytest.raises(ImageError):
            unpack(pack(replace(table, channels=(*table.channels[:-1], wrong))))


ENDS, RUNS = (0.0, 62.0), {"run_in_mm": 2.0, "run_out_mm": 1.0}


def some_correction() -> Correction:
    """Return waves that `formula_mm` gives in closed form."""
    z = nodes_of(ENDS) + 0j
    waves = {0: 2e-3 * np.sin(z / 10), 1: 1e-3 * (1 + 0.5j) * np.ones_like(z)}
    return Correction(ENDS, waves | {2: 3e-3 * np.exp(1j * z / 30), 7: 5e-4 * (z / 62)})


def formula_mm(turn: Floats, z: Floats) -> Floats:
    """Return what `some_correction` takes off the radius."""
    phi = 2 * np.pi * turn
    one = 1e-3 * (np.cos(phi) + 0.5 * np.sin(phi))
    two = 3e-3 * np.cos(2 * phi - z / 30)
    return 2e-3 * np.sin(z / 10) + one + two + 5e-4 * z / 62 * np.cos(7 * phi)


@pytest.fixture(scope="module")
def corrected() -> Made:
    """Make the corrected table of the example."""
    return made_skirt(part_with(), correction=some_correction())


@pytest.mark.parametrize("process", [{}, {"direction": -1} | RUNS | {"u_zero": "mean"}])
def test_firmware_plays_drawing_less_correction(process: dict[str, Any], tmp_path: Path) -> None:
    """Both ways round, with run-in and U about its mean: within 4 nm of the drawing's formula."""
    part = part_with(**process)
    made = made_skirt(part, correction=some_correction())
    rng = np.random.default_rng(15)
    turn, z = rng.uniform(0, 1, 2000), rng.uniform(*ENDS, 2000).round(6)
    wanted = KIND.drawing(part).radius_mm(turn, z) - formula_mm(turn, z)
    found = tip_mm(evaluated(tmp_path, made.table.table, turn, z))
    assert np.abs(found - wanted).max() < 4e-6


@pytest.mark.long
def test_nose_follows_the_corrected_surface(tmp_path: Path) -> None:
    """A nose stands off the corrected surface by no less than off the drawing, to 20 nm."""
    part, rng = part_with(nose_mm=0.8), np.random.default_rng(16)
    turn, z = rng.uniform(0, 1, 500), rng.uniform(1, 61, 500).round(6)
    plain, other = (
        tip_mm(evaluated(tmp_path, made_skirt(part, correction=one).table.table, turn, z))
        for one in (Correction(ENDS, {}), some_correction())
    )
    assert np.abs(plain - other - formula_mm(turn, z)).max() < 2e-5


def test_part_is_judged_by_its_drawing(corrected: Made, tmp_path: Path) -> None:
    """The form error is the correction, the controller's own error that of the plain part."""
    # 6 um beyond the drawing are beyond the tolerance
    found = cut(written(corrected, tmp_path), "--feed", "0.5", status=1)
    turn, z = (one.ravel() for one in np.meshgrid(np.arange(720) / 720, np.linspace(*ENDS, 125)))
    largest_um = 1e3 * np.abs(formula_mm(turn, z)).max()
    assert found.form_error_um == pytest.approx(largest_um, abs=0.1)
    assert found.summary["control_error_um"]["max"] < 0.1


def test_breaks_that_differ_by_rounding() -> None:
    """The middle of 65 heights of 30 mm is not 15 mm to the last bit; the feed speed is finite."""
    heights = {"height_mm": [0.0, 15.0, 30.0]}
    profile = heights | {"diameter_mm": [79.99, 80.0, 80.01], "overshoot_um": 30.0}
    ovality = heights | {"ovality_mm": [0.3, 0.35, 0.4]}
    part = changed(example_part(), {"piston.profile": profile, "piston.ovality": ovality})
    ends = (0.0, 30.0)
    assert nodes_of(ends)[32] != 15.0
    correction = Correction(ends, {2: 1e-3 * np.ones(65, dtype=np.complex128)})
    made = made_skirt(part, correction=correction)
    assert 0 < KIND.summary(made.table)["motion"]["velocity_from_feed_mm_s"] < 1


def test_correction_is_read_back(corrected: Made, tmp_path: Path) -> None:
    """NAME.json has it to a nanometre; an order that is no whole number is refused by its place."""
    report = json.loads(corrected.files(with_plots=False)["example.json"])
    again = correction_of(report["correction"])
    rng = np.random.default_rng(17)
    phi, z = 2 * np.pi * rng.uniform(0, 1, 500), rng.uniform(*ENDS, 500)
    found = again.delta(phi, z)[0] + again.mean(z)
    assert np.abs(found - formula_mm(phi / (2 * np.pi), z)).max() < 1e-6
    assert report["design"].items() >= KIND.drawing(part_with()).document.items()
    table = written(corrected, tmp_path)
    path = table.with_suffix(".json")
    report = json.loads(path.read_text())
    report["target"]["correction"][1]["order"] = 2.5
    path.write_text(json.dumps(report))
    told = "target.correction[1].order: must be a whole number of 1 .. 64"
    assert told in refusal(table)


def test_other_kinds_refuse() -> None:
    """Cams and polygons have no corrected tables."""
    for name in ("cam-disc", "p3g-25"):
        loaded = load(PARTS / f"{name}.toml")
        with pytest.raises(CamtoolsError, match="are not corrected by gauged parts"):
            make(loaded, "part.toml", correction=Correction(ENDS, {}))
