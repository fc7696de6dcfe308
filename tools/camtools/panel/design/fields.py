# SPDX-License-Identifier: Apache-2.0
"""The form of a part file, made from the model of its kind: tables, fields, ranges, meanings.

>>> from camtools.skirt.part.part_file import SkirtPart
>>> tables = form_of("piston", SkirtPart, {"process.spindle_rpm": 2500})
>>> [process] = [one for one in tables if one.title == "process"]
>>> rpm = process.fields[0]
>>> rpm.name, rpm.value, rpm.unit, rpm.range_text
('spindle_rpm', 2500, 'r/min', '1 .. 60000')
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from camtools.panel.design.key_meanings import meaning_of
from camtools.part.model import TomlTable

Step = str | int
Schema = dict[str, Any]

_UNITS = (
    *(("_mm_per_mm", "mm/mm"), ("_mm_s3", "mm/s³"), ("_mm_s2", "mm/s²"), ("_mm_s", "mm/s")),
    *(("_rad_s2", "rad/s²"), ("_rad_s", "rad/s"), ("_deg_s2", "°/s²"), ("_deg_s", "°/s")),
    *(("_kgm2", "kg m²"), ("torque_nm", "N m"), ("_rpm", "r/min"), ("_hz", "Hz"), ("_um", "µm")),
    *(("feed_mm", "mm/turn"), ("_mm", "mm"), ("_deg", "°"), ("_percent", "%")),
)


@dataclass(frozen=True)
class FormField:
    """One key of a table.

    Attributes
    ----------
    path : tuple
        Of the key in the file; numbers are places in lists of tables.
    sort : str
        number, whole, choice, switch, text, numbers (one or a list) or other (the text alone).
    value : object
        That of the text; None where the text leaves it out.
    default : object
        What holds without it; None: nothing.
    """

    path: tuple[Step, ...]
    sort: str
    value: Any
    default: Any
    is_required: bool
    low: float | None = None
    high: float | None = None
    is_low_open: bool = False
    is_high_open: bool = False
    choices: tuple[str | int, ...] = ()
    meaning: str = ""

    @property
    def name(self) -> str:
        """Return the key."""
        return str(self.path[-1])

    @property
    def dotted(self) -> str:
        """Return the whole name."""
        return ".".join(map(str, self.path))

    @property
    def unit(self) -> str:
        """Return the unit, which the name ends with."""
        return next((unit for end, unit in _UNITS if self.name.endswith(end)), "")

    @property
    def range_text(self) -> str:
        """Return the range in words."""
        if self.low is None and self.high is None:
            return ""
        if self.low is None:
            return f"{'below' if self.is_high_open else 'at most'} {self.high:g}"
        low = f"above {self.low:g}" if self.is_low_open else f"{self.low:g}"
        return low if self.high is None else f"{low} .. {self.high:.9g}"


@dataclass(frozen=True)
class FormTable:
    """One table of the file."""

    path: tuple[Step, ...]
    fields: tuple[FormField, ...]
    meaning: str
    is_there: bool

    @property
    def title(self) -> str:
        """Return the name of the table."""
        return ".".join(map(str, self.path))


@cache
def _schema_of(model: type[TomlTable]) -> Schema:
    return model.model_json_schema()


class _Form:
    """The schema of a kind and the values of a text."""

    def __init__(self, kind: str, model: type[TomlTable], values: dict[str, Any]) -> None:
        self.kind, self.values = kind, values
        self.root = _schema_of(model)

    def tables(self) -> Iterator[FormTable]:
        yield from self._table(self.root, (), is_required=True)

    def _resolved(self, node: Schema) -> Schema:
        while "$ref" in node:
            node = self.root["$defs"][node["$ref"].rsplit("/", 1)[1]]
        return node

    def _variants(self, node: Schema) -> list[Schema]:
        """Return what a value may be, null left out."""
        found: list[Schema] = []
        for one in node.get("anyOf") or node.get("oneOf") or [node]:
            one = self._resolved(one)
            if "anyOf" in one or "oneOf" in one:
                found += self._variants(one)
            elif one.get("type") != "null":
                found.append(one)
        return found

    def _keys(self, path: tuple[Step, ...]) -> set[str]:
        """Return the next names below a path that the text has."""
        prefix = "".join(f"{one}." for one in path)
        return {
            name[len(prefix) :].split(".", 1)[0] for name in self.values if name.startswith(prefix)
        }

    def _table(
        self, node: Schema, path: tuple[Step, ...], *, is_required: bool
    ) -> Iterator[FormTable]:
        """Yield a table, and behind it those within it."""
        node = self._resolved(node)
        keys, needed = self._keys(path), set(node.get("required", ()))
        fields: list[FormField] = []
        within: list[Iterator[FormTable]] = []
        for name, one in node["properties"].items():
            at, variants = (*path, name), self._variants(one)
            tables = [v for v in variants if v.get("type") == "object"]
            if tables:
                there = self._keys(at)
                chosen = next((v for v in tables if there <= set(v["properties"])), tables[-1])
                if not there:
                    chosen = tables[-1]  # by points, the usual way
                within.append(self._table(chosen, at, is_required=name in needed))
            elif self._is_list_of_tables(variants):
                entry = self._resolved(variants[0]["items"])
                numbers = sorted(int(n) for n in self._keys(at) if n.isdigit())
                within += [self._table(entry, (*at, n), is_required=False) for n in numbers]
            else:
                fields.append(self._field(at, one, variants, is_required=name in needed))
        if path and (fields or not within):
            meaning = meaning_of(self.kind, path)
            yield FormTable(path, tuple(fields), meaning, bool(keys) or is_required)
        for one in within:
            yield from one

    def _is_list_of_tables(self, variants: list[Schema]) -> bool:
        first = variants[0] if variants else {}
        if first.get("type") != "array":
            return False
        return bool(self._resolved(first.get("items", {})).get("type") == "object")

    def _field(
        self, path: tuple[Step, ...], node: Schema, variants: list[Schema], *, is_required: bool
    ) -> FormField:
        dotted = ".".join(map(str, path))
        sort = _sort_of(variants)
        bounds = variants[0].get("items", variants[0]) if variants else {}
        choices: list[str | int] = [c for v in variants for c in v.get("enum", [])]
        low, high = bounds.get("minimum"), bounds.get("maximum")
        low_open, high_open = bounds.get("exclusiveMinimum"), bounds.get("exclusiveMaximum")
        return FormField(
            path,
            sort,
            self.values.get(dotted),
            node.get("default"),
            is_required,
            low if low is not None else low_open,
            high if high is not None else high_open,
            low_open is not None,
            high_open is not None,
            tuple(choices),
            meaning_of(self.kind, path),
        )


def _sort_of(variants: list[Schema]) -> str:
    """Return how a value is typed in."""
    types = {str(one.get("type", "")) for one in variants}
    if variants and all("enum" in one or "const" in one for one in variants):
        return "choice"
    if types == {"boolean"}:
        return "switch"
    if types == {"integer"}:
        return "whole"
    if types == {"number"}:
        return "number"
    if types == {"string"}:
        return "text"
    if "array" in types and all(_is_flat(one) for one in variants):
        return "numbers"
    return "other"


def _is_flat(node: Schema) -> bool:
    inner = node.get("items", {}).get("type", "number")
    return node.get("type") in ("array", "number", "integer") and inner in ("number", "integer")


def form_of(kind: str, model: type[TomlTable], values: dict[str, Any]) -> tuple[FormTable, ...]:
    """Return the tables of a form with the values of a text.

    Parameters
    ----------
    values : dict
        By dotted names, see `values.values_of`.
    """
    return tuple(_Form(kind, model, values).tables())


def typed(field: FormField, text: str) -> Any:  # noqa: ANN401 (a value of TOML)
    """Return what somebody typed as a value of the field; None where it was emptied.

    Whole numbers stay whole, so that 2500 does not become 2500.0 in the text.

    Raises
    ------
    ValueError
        It is no such value; the message says what is wanted.
    """
    text = text.strip()
    if not text:
        return None
    if field.sort == "text":
        return text
    if field.sort == "switch":
        return text == "true"
    if field.sort == "choice":
        return next((one for one in field.choices if str(one) == text), text)
    if field.sort == "numbers":
        inner = text.strip("[] \t")
        is_list = text.startswith("[") or "," in text or isinstance(field.value, list)
        numbers = [_number(one) for one in inner.replace(";", ",").split(",") if one.strip()]
        return numbers if is_list or len(numbers) != 1 else numbers[0]
    return _number(text)


def _number(text: str) -> float | int:
    text = text.strip()
    try:
        return int(text)
    except ValueError:
        pass
    try:
        found = float(text)
    except ValueError:
        problem = f"{text[:40]!r} is no number; give digits with a point"
        raise ValueError(problem) from None
    if found - found != 0:
        raise ValueError("give a finite number")
    return found


def step_of(value: float) -> float:
    """Return how far a step button moves a number: a tenth of its first digit's worth.

    >>> step_of(2500), step_of(0.1), step_of(0)
    (100.0, 0.01, 0.1)
    """
    if value == 0:
        return 0.1
    digits = f"{abs(value):e}"
    return float(f"1e{int(digits.split('e')[1]) - 1}")


def dial_of(field: FormField, value: float) -> tuple[float, float]:
    """Return the ends of a slider around a value: half of it to one and a half, within the range.

    >>> dial_of(FormField(("a",), "number", 4, None, True, low=3.0), 4.0)
    (3.0, 6.0)
    """
    ends = sorted((0.5 * value, 1.5 * value)) if value else [-1.0, 1.0]
    low = ends[0] if field.low is None else max(ends[0], field.low)
    high = ends[1] if field.high is None else min(ends[1], field.high)
    return low, high
