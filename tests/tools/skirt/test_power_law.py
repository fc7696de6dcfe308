# SPDX-License-Identifier: Apache-2.0
"""Profile and ovality by formula: exact curves, tables, refusals."""

from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.part.power_law import LAW_ERROR_MM
from camtools.skirt.table.generate import generate
from tests.tools.cases.part_cases import ROOT, load_part, parse_part

LAW = ROOT / "tools" / "parts" / "perkins240_law.toml"


def changed(part: SkirtPart, **piston: object) -> SkirtPart:
    """Return the part with tables of [piston] changed."""
    tree: dict[str, Any] = part.model_dump(exclude_none=True)
    for name, values in piston.items():
        tree["piston"][name] |= values
    return SkirtPart.model_validate(tree)


@pytest.fixture(scope="module")
def law() -> SkirtPart:
    """Load the part of the repository that is drawn by formula."""
    return load_part(LAW)


@pytest.mark.parametrize(
    ("exponent", "peak_mm", "drop_mm"),
    [(2.0, 20.0, 0.13), (3.0, 20.0, 0.13), (2.2, 31.0, 0.3), (2.5, -7.0, 0.2), (4.0, 62.0, 1.0)],
)
def test_pieces_are_the_formula(
    law: SkirtPart, exponent: float, peak_mm: float, drop_mm: float
) -> None:
    """Everywhere within LAW_ERROR_MM, and the slope is the formula's derivative."""
    far = max(abs(62 - peak_mm), abs(peak_mm))
    k = drop_mm / far**exponent
    profile = {"exponent": exponent, "peak_height_mm": peak_mm, "coefficient": k}
    geometry = make_geometry(changed(law, profile=profile))
    z = np.linspace(0, 62, 100_001)
    off = np.abs(z - peak_mm)
    a = 46 - k * off**exponent
    assert np.abs(geometry.radius_mm(z) - a).max() <= LAW_ERROR_MM * 1.001
    slope = -k * exponent * np.sign(z - peak_mm) * off ** (exponent - 1)
    assert np.abs(geometry.radius_mm(z, 1) - slope).max() <= 1e-7


def test_part_by_formula_is_the_papers(law: SkirtPart) -> None:
    """The known facts: 92 mm at 20, 91.737 at 62, ovality 0.2 at 20 and 0.3 at 62."""
    geometry = make_geometry(law)
    assert 2 * float(geometry.radius_mm(20.0)) == pytest.approx(92.0, abs=1e-12)
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(91.737, abs=2e-6)
    assert geometry.ovality_mm([20.0, 62.0]) == pytest.approx([0.2, 0.3], abs=2e-8)


def test_switch_turns_a_round_skirt(law: SkirtPart) -> None:
    """With p = 0 there is no reduction anywhere."""
    geometry = make_geometry(changed(law, ovality={"is_oval": False}))
    assert float(np.abs(geometry.delta(np.linspace(0, 6, 50), 30.0).delta).max()) == 0.0


def test_table_of_a_formula_keeps_its_tolerance(law: SkirtPart) -> None:
    """An exponent that no cubic has makes a table within a nanometre as well."""
    made = generate(changed(law, profile={"exponent": 2.3, "coefficient": 2.4e-5}))
    assert made.accuracy_x.value_nm <= 1.0


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"power"', '"cubic"', r"piston\.profile\.law = 'cubic': Input should be 'power'"),
        ("exponent = 2", "exponent = 1.5", r"piston\.profile\.exponent = 1\.5: .*at least 2"),
        (
            "coefficient = 7.4546e-5",
            "coefficient = 1",
            r"piston\.profile\.coefficient = 1\.0: makes",
        ),
        ("range_mm = [0, 62]", "range_mm = [62, 0]", r"profile\.range_mm.*must increase"),
        ("[0, 62]\npeak_height_mm = 62", "[5, 62]\npeak_height_mm = 62", r"must cover .* 0"),
        (
            "fall_mm_per_mm = 0.00238",
            "fall_mm_per_mm = 1 # ",
            r"fall_mm_per_mm = 1\.0: makes the oval",
        ),
        ("peak_diameter_mm = 92", "diameter_mm = 92", r"profile\.diameter_mm = 92: unknown key"),
    ],
)
def test_wrong_formulas_are_refused(old: str, new: str, told: str) -> None:
    """One line with the field, its value and a remedy; no word of how keys are told apart."""
    text = LAW.read_text()
    assert old in text, old
    with pytest.raises(CamtoolsError, match=told) as info:
        parse_part(text.replace(old, new, 1).encode(), "law.toml")
    assert "(law)" not in str(info.value)
    assert "(points)" not in str(info.value)
