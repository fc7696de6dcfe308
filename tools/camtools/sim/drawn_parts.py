"""Parts cut on machines drawn by a forecast: what most of them keep, and decisions by that.

>>> decision(4.0, 0.5, 5.0), decision(4.7, 0.5, 5.0), decision(5.6, 0.5, 5.0)
('pass', 'not decided', 'fail')
>>> bound_of(np.arange(1.0, 60.0)), bound_of(np.arange(1.0, 59.0))
(59.0, inf)
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.base.text import Json
from camtools.part.model import TomlTable

RUNS, ABOUT = "runs.parquet", "camturn.forecast"  # table of a forecast, and its metadata
SHARE = CONFIDENCE = 0.95  # of the parts that keep a bound; that a bound is one
LEAST_CUTS = 59  # with which the largest value is a bound: 0.95^59 < 0.05
PASS, FAIL, NOT_DECIDED = "pass", "fail", "not decided"
WHOLE = "whole part: form error [µm]"
_FREE = ("--seed", "--tolerance-um")  # options of camsim that a cut may have of its own


def bound_of(values: Floats) -> float:
    """Return what 95 % of all parts keep at 95 % confidence, MATHS.md (168); infinite: nothing.

    `values` are those of independent parts, infinite where one has none.
    """
    test = scipy.stats.quantile_test(values, p=SHARE, alternative="less")
    high = float(test.confidence_interval(CONFIDENCE).high)
    return np.inf if np.isnan(high) else high


def decision(value: float, expanded: float | None, limit: float) -> str:
    """Return whether a size with its expanded uncertainty keeps a limit, by ISO 14253-1."""
    if expanded is None:
        return NOT_DECIDED
    if value + expanded <= limit:
        return PASS
    return FAIL if value - expanded > limit else NOT_DECIDED


class DrawnParts(NamedTuple):
    """What was gauged of each part."""

    values: Mapping[str, Floats]  # by feature, shape (parts,); infinite: not gauged
    folder: str = ""  # of the forecast

    @property
    def n_parts(self) -> int:
        """Return how many parts were cut."""
        return int(self.values[WHOLE].size)

    def expanded(self, name: str, value: float) -> float | None:
        """Return U: 95 % of the parts are within value +- U; none: that is not known."""
        values = self.values.get(name)
        found = np.inf if values is None else bound_of(np.abs(values - value))
        return found if np.isfinite(found) else None


def drawn_parts(form_um: Floats, features: Sequence[str], folder: str = "") -> DrawnParts:
    """Return what was gauged of parts: the largest form error, the features as JSON or nothing."""
    cuts: list[dict[str, float]] = [json.loads(text or "{}") for text in features]
    names = dict.fromkeys(name for cut in cuts for name in cut)
    values = {name: np.array([cut.get(name, np.inf) for cut in cuts]) for name in names}
    return DrawnParts({WHOLE: form_um} | values, folder)


def cut_facts(table: bytes, part: TomlTable, machine: str, words: Sequence[str]) -> Json:
    """Return what a cut shares with its forecast: table, part, machine file, options of camsim."""
    kept = (
        word
        for before, word in zip(["", *words], words, strict=False)
        if not {before, word.split("=")[0]} & {*_FREE}
    )
    tables = {"table": table, "part": part_bytes(part), "machine": machine.encode()}
    digests = {name: hashlib.sha256(data).hexdigest() for name, data in tables.items()}
    return digests | {"options": [*kept]}


def part_bytes(part: TomlTable) -> bytes:
    """Return the keys of a part: its drawing, windows, datum and tolerances."""
    return part.model_dump_json().encode()


def refuse_zones(part: TomlTable, option: str) -> None:
    """Refuse what bounds the largest error of a part that has tolerances by zone."""
    if getattr(getattr(part, "tolerances", None), "zones", ()):
        problem = "bounds the error of the whole part, and this part has zones of tolerance"
        raise CamtoolsError([f"{option}: {problem}; leave it out, or remove [[tolerances.zone]]"])


def read_parts(folder: Path, cut: Json) -> DrawnParts:
    """Return the parts of a forecast of this cut.

    Raises `CamtoolsError`: there is none, it has no sections, it is of another cut.
    """
    import pyarrow as pa  # slow to load
    import pyarrow.parquet as pq

    begin = f"--forecast {folder}: "
    again = f"run tools/forecast PART.toml --sections -o {folder} with the options of this cut"
    try:
        rows = pq.read_table(folder / RUNS)
        about = json.loads(rows.schema.metadata[ABOUT.encode()])
        features = rows["features"].to_pylist()
        form_um = rows["form_max_um"].to_numpy()
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError) as error:
        raise CamtoolsError([f"{begin}has no {RUNS} of a forecast; {again}"]) from error
    if not about.get("bounds"):
        raise CamtoolsError([f"{begin}was made without --sections; {again}"])
    if other := [name for name, value in cut.items() if about["cut"][name] != value]:
        raise CamtoolsError([f"{begin}is of another cut: other {', '.join(other)}; {again}"])
    gauged_um = np.where(np.isfinite(form_um) & np.array([*map(bool, features)]), form_um, np.inf)
    return drawn_parts(gauged_um, features, str(folder))
