"""The generator: tolerance kept, bounds true, bytes few and always the same."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import omega_rad_s
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.skirt.table.search import DERIVATIVE_SHARE, UnreachableError
from camtools.table.channel import KIND_U, KIND_X
from camtools.table.evaluate import evaluate_at, evaluate_x, jumps
from camtools.table.image import pack, unpack
from tests.tools.cases.part_cases import PERKINS, load_part


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
    """The Perkins 240 table is within 1 nm of the exact geometry in at most 16 KiB."""
    u_nm, first, second, x_nm = errors_nm(generated)
    assert max(u_nm, x_nm) <= 1.0
    assert max(first, second) <= DERIVATIVE_SHARE
    assert len(pack(generated.table)) <= 16 * 1024


def test_reported_error_covers_random_points(generated: GeneratedSkirt) -> None:
    """The achieved error in header and report is not smaller than what random points show."""
    u_nm, _, _, x_nm = errors_nm(generated)
    assert u_nm <= generated.accuracy_u.value_nm <= 1.0
    assert x_nm <= generated.accuracy_x.value_nm <= 1.0
    assert generated.table.bounds.error_pm >= 1000 * max(u_nm, x_nm)


@pytest.mark.parametrize("tolerance_nm", [100.0, 10.0, 0.1, 0.05])
def test_tolerance_is_kept(perkins: SkirtPart, tolerance_nm: float) -> None:
    """Each tolerance is kept, for values and derivatives."""
    u_nm, first, second, x_nm = errors_nm(generate(perkins, tolerance_nm))
    assert max(u_nm, x_nm) <= tolerance_nm
    assert max(first, second) <= DERIVATIVE_SHARE


def test_smaller_tolerance_needs_no_fewer_bytes(perkins: SkirtPart) -> None:
    """Bytes never fall when the tolerance does."""
    sizes = [len(pack(generate(perkins, nm).table)) for nm in (100.0, 10.0, 1.0, 0.3, 0.05)]
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("tolerance_nm", [1e-9, 0.001])
def test_unreachable_tolerance_tells_the_best(perkins: SkirtPart, tolerance_nm: float) -> None:
    """A tolerance below what the format can do is refused, and the named best is reachable."""
    with pytest.raises(UnreachableError, match=r"tolerance_nm = .*best achievable is") as info:
        generate(perkins, tolerance_nm)
    assert len(info.value.lines) == 1
    result = generate(perkins, 1.2 * info.value.best_nm)
    assert max(errors_nm(result)[0], errors_nm(result)[3]) <= 1.2 * info.value.best_nm


@pytest.mark.parametrize("tolerance_nm", [0.0, -1.0, float("nan"), float("inf"), 1e7])
def test_senseless_tolerance_is_refused(perkins: SkirtPart, tolerance_nm: float) -> None:
    """A tolerance that is no length is refused by name."""
    with pytest.raises(CamtoolsError, match="tolerance_nm"):
        generate(perkins, tolerance_nm)


def test_guaranteed_bounds_are_true(generated: GeneratedSkirt) -> None:
    """No evaluated value, slope or curvature lies beyond the header's bounds, nor far inside."""
    bounds = generated.table.bounds
    turn, z_mm = random_points(generated, 20_000)
    turn[:1000], z_mm[:500], z_mm[500:1000] = np.linspace(0, 1, 1000), 62.0, 0.0
    u = evaluate_at(generated.table.channel(KIND_U), turn, z_mm * 1e6)
    assert bounds.u_min_nm <= u.value.min()
    assert u.value.max() <= bounds.u_max_nm <= u.value.max() + 3
    assert np.abs(u.d1).max() <= bounds.u1_peak_nm_per_rad <= 1.001 * np.abs(u.d1).max()
    assert np.abs(u.d2).max() <= bounds.u2_peak_nm_per_rad2 <= 1.001 * np.abs(u.d2).max()


def test_quantised_table_is_continuous(generated: GeneratedSkirt) -> None:
    """Value, first and second derivative do not jump at knots nor at the wrap, exactly."""
    for channel in generated.table.channels:
        for place in jumps(channel):
            assert place == (0.0, 0.0, 0.0)


def part_of(**changes: object) -> SkirtPart:
    """Return a short skirt with some tables of the part file changed."""
    tree = load_part(PERKINS).model_dump()
    tree["piston"] |= changes
    tree["machine"]["limits"] |= {"u_stroke_mm": 30.0, "u_speed_mm_s": 1e5}
    tree["machine"]["limits"] |= {"u_acceleration_mm_s2": 1e9}
    return SkirtPart.model_validate(tree)


def test_round_piston_is_possible() -> None:
    """Without ovality the table is all zero and still valid."""
    result = generate(part_of(ovality={"height_mm": [0, 62], "ovality_mm": [0.0, 0.0]}))
    assert errors_nm(result)[0] == 0.0
    assert result.table.bounds.u2_peak_nm_per_rad2 <= 1


@pytest.mark.parametrize("nodes", [[0, 17.3, 62], [0, 13.7, 29.3, 62], [-5, 20.1, 41.7, 70]])
def test_kinks_at_odd_heights_are_met(nodes: list[float]) -> None:
    """Linear ovality with nodes anywhere keeps the tolerance at the kinks too."""
    ovality = {"height_mm": nodes, "ovality_mm": [0.15, 0.2, 0.22, 0.3][: len(nodes)]}
    u_nm, _, _, x_nm = errors_nm(generate(part_of(ovality=ovality)))
    assert max(u_nm, x_nm) <= 1.0


def test_beta_is_in_the_table() -> None:
    """A double ellipse keeps the tolerance and is deeper at 45 degrees by G beta / 50."""
    result = generate(part_of(section={"shape": "double-ellipse", "beta": 2.0}))
    assert errors_nm(result)[0] <= 1.0
    u = evaluate_at(result.table.channel(KIND_U), np.array([0.125]), np.array([62e6]))
    assert u.value[0] == pytest.approx((0.3 / 4 + 0.3 * 2 / 50) * 1e6, abs=1.0)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
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
    profile = {
        "height_mm": z,
        "diameter_mm": [diameter_mm - drop for drop in drop_mm[: len(z)]],
        "spline": "natural",
        "overshoot_um": 1e6,
    }
    ovality = {
        "overshoot_um": 1e6,
        "height_mm": z,
        "ovality_mm": ovality_mm[: len(z)],
        "interpolation": interpolation,
    }
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


def limited(**limits: float) -> SkirtPart:
    """Return the Perkins skirt for a weaker machine."""
    tree = load_part(PERKINS).model_dump()
    tree["machine"]["limits"] |= limits
    return SkirtPart.model_validate(tree)


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
    with pytest.raises(CamtoolsError) as info:
        generate(limited(**{limit: value}))
    (line,) = info.value.lines
    assert line.startswith(f"machine.limits.{limit} = {value:.9g}")
    assert float(line.split("needs ")[1].split()[0]) == pytest.approx(needed, rel=1e-3)
    assert "at most" in line or "no speed helps" in line


@pytest.mark.parametrize(
    ("limit", "value"), [("u_speed_mm_s", 20.0), ("u_acceleration_mm_s2", 10_000.0)]
)
def test_highest_speed_is_where_the_limit_is_met(limit: str, value: float) -> None:
    """The reported highest speed makes the deciding peak equal to its limit, and is accepted."""
    tree = limited(**{limit: value}).model_dump()
    tree["process"]["spindle_rpm"] = 600.0
    best = generate(SkirtPart.model_validate(tree)).highest_speed
    assert best.decides == limit
    peak_mm = {"u_speed_mm_s": 0.15, "u_acceleration_mm_s2": 0.30242}[limit]
    power = {"u_speed_mm_s": 1, "u_acceleration_mm_s2": 2}[limit]
    assert peak_mm * omega_rad_s(best.rpm) ** power == pytest.approx(value, rel=1e-3)
    tree["process"]["spindle_rpm"] = float(np.floor(best.rpm))
    generate(SkirtPart.model_validate(tree))
