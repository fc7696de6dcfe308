r"""Uncertain numbers of a machine: which, how they are spread, and what is judged by them.

The usual ones are the table `vary.toml`; tools/docs/FORECAST.md describes its keys. Forecasts draw
machines from it or from a file of the same form, `tools/run` cuts on a drive that is later than
believed, and `tools/tune` demands its margins over the spread of the mass.

>>> usual_spreads()["u.mass_kg"].margins
0.3
>>> read_spreads(b'[u.delay_us]\ndistribution = "normal"\nsd = 2\n', "v.toml")["u.delay_us"].sd
2.0
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from camtools.base.errors import CamtoolsError, InputError
from camtools.part.model import TomlTable, read_tree, validated, wrong

USUAL = Path(__file__).with_name("vary.toml")
_MOST_UNKNOWNS = 100

_KEYS = {  # of each distribution: those that it needs, and others
    "uniform": (("low", "high"), ()),
    "normal": (("sd",), ("mean", "low", "high")),
    "lognormal": (("factor",), ("median", "low", "high")),
}
Above0 = Annotated[float, Field(gt=0)]
Late = dict[Literal["position", "force"], Literal[-1, 1]]


class Spread(TomlTable):
    """[TABLE.KEY] of a V.toml: how one number is spread."""

    distribution: Literal["uniform", "normal", "lognormal"]
    of: Literal["nominal", "unit"] = "unit"
    low: float | None = None
    high: float | None = None
    mean: float | None = None
    sd: Above0 | None = None
    median: Above0 | None = None
    factor: Annotated[float, Field(gt=1)] | None = None
    drawn: bool = True  # by forecasts
    # Where it acts besides, read from the usual spreads only:
    later: Late = Field(default_factory=dict)  # sign of a change that makes a kind of U later
    margins: Annotated[float, Field(gt=0, lt=1)] | None = None  # share +-; a loop has its margins
    stable: Annotated[float, Field(gt=1)] | None = None  # factor */; a loop is stable

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        wanted, others = _KEYS[self.distribution]
        for name in ("low", "high", "mean", "sd", "median", "factor"):
            value = getattr(self, name)
            if value is None and name in wanted:
                problem = f"is missing; a {self.distribution} distribution needs it"
                raise wrong("missing", problem, f"add {name}", field=name)
            if value is not None and name not in (*wanted, *others):
                problem = f"does not belong to a {self.distribution} distribution"
                raise wrong("extra", problem, "remove it", field=name, value=value)
        if self.later and (self.distribution, self.of) != ("normal", "nominal"):
            problem = "is for a normal distribution of the nominal value"
            raise wrong("extra", problem, "remove it", field="later", value=self.later)
        if self.low is not None and self.high is not None and self.low >= self.high:
            problem = f"must be below high = {self.high:g}"
            raise wrong("order", problem, "give the lower end first", field="low", value=self.low)
        return self


def read_spreads(data: bytes, file: str) -> Mapping[str, Spread]:
    """Return the tables of a V.toml by key, as `table.key`; refuse what is none."""
    spreads: dict[str, Spread] = {}
    for table, keys in read_tree(data, file).items():
        if not isinstance(keys, dict) or not keys:
            problem = "not a table of a machine file"
            raise InputError(file, table, None, problem, "write [TABLE.KEY], as [u.bandwidth_hz]")
        for name, content in keys.items():
            key = f"{table}.{name}"
            if not isinstance(content, dict):
                problem = "not a table"
                raise InputError(file, key, None, problem, f"write [{key}] and its keys below")
            try:
                spreads[key] = validated(Spread, content, file, {})
            except CamtoolsError as error:
                begin = f"{file}: "
                lines = [f"{begin}{key}.{line.removeprefix(begin)}" for line in error.lines]
                raise CamtoolsError(lines) from error
    n_drawn = sum(spread.drawn for spread in spreads.values())
    if not 1 <= n_drawn <= _MOST_UNKNOWNS:
        problem = f"{n_drawn} numbers to vary"
        raise InputError(file, "", None, problem, f"give 1 .. {_MOST_UNKNOWNS}")
    return spreads


@cache
def usual_spreads() -> Mapping[str, Spread]:
    """Return the usual uncertain numbers of a machine by key."""
    return read_spreads(USUAL.read_bytes(), USUAL.name)
