"""What most parts keep: printed numbers, a known distribution, refusals of other forecasts."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from camtools.base.errors import CamtoolsError
from camtools.part.areas import ZonedTolerances
from camtools.sim.drawn_parts import (
    WHOLE,
    bound_of,
    cut_facts,
    drawn_parts,
    read_parts,
    refuse_zones,
)
from camtools.skirt.part.part_file import example_part
from tests.tools.cases.part_cases import sure


@pytest.mark.parametrize(("n", "place"), [(59, 1), (93, 2), (124, 3), (153, 4), (181, 5), (208, 6)])
def test_bounds_are_those_of_wilks(n: int, place: int) -> None:
    """MATHS.md (168): the printed sizes of samples from which the k-th largest is a 95/95 bound."""
    largest = np.random.default_rng(n).permutation(np.arange(1.0, n + 1))
    assert bound_of(largest) == n + 1 - place
    assert bound_of(np.arange(1.0, n)) == (np.inf if place == 1 else n + 1 - place)
    assert bound_of(np.where(largest > n - place, np.inf, largest)) == np.inf


def test_expanded_uncertainty_holds_the_parts() -> None:
    """At least 95 % of an exponential number are within value +- U, in 95 % of all forecasts."""
    rng, held, value = np.random.default_rng(3), 0, 0.4
    for _ in range(400):
        expanded = sure(drawn_parts(rng.exponential(size=80), [""] * 80).expanded(WHOLE, value))
        share = np.exp(-max(value - expanded, 0.0)) - np.exp(-value - expanded)
        held += int(share >= 0.95)
    assert held >= 0.95 * 400 - 3 * np.sqrt(400 * 0.95 * 0.05)


PART = example_part()
STRICT = PART.model_copy(update={"tolerances": ZonedTolerances(runout_um=3)})
ZONES = [{"name": "belt", "from_mm": 0, "to_mm": 9}]


def test_zones_have_no_bound() -> None:
    """The largest error of the whole part says nothing of a zone."""
    zoned = ZonedTolerances.model_validate({"zone": ZONES})
    refuse_zones(PART, "--sections")
    with pytest.raises(CamtoolsError, match=r"--sections: bounds the error of the whole part"):
        refuse_zones(PART.model_copy(update={"tolerances": zoned}), "--sections")


def test_parts_come_from_a_forecast_of_the_same_cut(tmp_path: Path) -> None:
    """Seed and tolerance of a cut are its own; all else must be the same. One line refuses."""
    asked = cut_facts(b"table", PART, "machine", ["--rpm", "2500.0"])
    with pytest.raises(CamtoolsError, match=r"--forecast .*: has no runs.parquet .* --sections"):
        read_parts(tmp_path, asked)
    rows = pa.table({"form_max_um": [0.2, float("nan")], "features": ['{"a": 0.1}', ""]})
    for bounds, words, match, part in (
        ([1], ["--rpm", "2500.0"], "of another cut: other part; run tools/forecast", STRICT),
        ([1], ["--rpm", "2000"], "of another cut: other options; run tools/forecast", PART),
        ([], ["--rpm", "2500.0"], "made without --sections; run", PART),
        ([1], ["--rpm", "2500.0", "--seed", "7", "--tolerance-um=3"], "", PART),
    ):
        about = json.dumps({"bounds": bounds, "cut": asked})
        table = rows.replace_schema_metadata({"camturn.forecast": about})
        pq.write_table(table, tmp_path / "runs.parquet")
        cut = cut_facts(b"table", part, "machine", words)
        if match:
            with pytest.raises(CamtoolsError, match=match):
                read_parts(tmp_path, cut)
    found = read_parts(tmp_path, cut).values
    assert {name: values.tolist() for name, values in found.items()} == {
        WHOLE: [0.2, np.inf],
        "a": [0.1, np.inf],
    }
