"""The keys of a file, read from the model of its tables: for the form, the manual and editors.

>>> from camtools.skirt.part.part_file import SkirtPart
>>> tree = {"process": {"spindle_rpm": 2500}}
>>> [process] = [row for row in Keys(SkirtPart, ()).tables(tree) if row.title == "process"]
>>> rpm = process.keys[0]
>>> rpm.name, rpm.value, rpm.unit, rpm.range_text, rpm.is_required
('spindle_rpm', 2500, 'r/min', '1 .. 60000', True)
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from camtools.part.model import TomlTable

Step = str | int
Schema = dict[str, Any]

DRAFT = "http://json-schema.org/draft-07/schema#"  # the one that editors of TOML know
_MOST_ENTRIES = 1000  # of a list of tables: more are changed in the text
_MOST_NAMED = 3  # choices before a meaning
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_UNITS = (
    *(("_mm_per_mm", "mm/mm"), ("_mm_s3", "mm/s³"), ("_mm_s2", "mm/s²"), ("_mm_s", "mm/s")),
    *(("_rad_s2", "rad/s²"), ("_rad_s", "rad/s"), ("_deg_s2", "°/s²"), ("_deg_s", "°/s")),
    *(("_kgm2", "kg m²"), ("torque_nm", "N m"), ("_rpm", "r/min"), ("_hz", "Hz"), ("_um", "µm")),
    *(("feed_mm", "mm/turn"), ("_mm", "mm"), ("_deg", "°"), ("_percent", "%")),
)


def unit_of(name: str) -> str:
    """Return the unit, which a name ends with."""
    return next((unit for end, unit in _UNITS if name.endswith(end)), "")


def plain(meaning: str) -> str:
    """Return a meaning without the marks of Markdown."""
    return _LINK.sub(r"\1", meaning).replace("`", "")


@dataclass(frozen=True)
class Key:
    """One key of a table."""

    path: tuple[Step, ...]  # of the key in the file; numbers are places in lists of tables
    sort: str  # number, whole, choice, switch, text, numbers (one or a list) or other
    value: Any  # that of the text; None where the text leaves it out
    default: Any  # what holds without it; None: nothing
    is_required: bool
    is_needed: bool = False  # by some choices of another key
    low: float | None = None
    high: float | None = None
    choices: tuple[str | int, ...] = ()
    range_text: str = ""
    meaning: str = ""  # Markdown

    @property
    def name(self) -> str:
        """Return the name in its table."""
        return str(self.path[-1])

    @property
    def dotted(self) -> str:
        """Return the whole name."""
        return ".".join(map(str, self.path))

    @property
    def unit(self) -> str:
        """Return the unit."""
        return unit_of(self.name)


@dataclass(frozen=True)
class Table:
    """One table of a file."""

    path: tuple[Step, ...]
    keys: tuple[Key, ...]
    meaning: str  # Markdown
    is_there: bool  # in the text, or required
    without: str = ""  # what holds without it: all keys have their defaults, or none
    most: int | None = None  # of a list of tables: how many there may be; 0: any number

    @property
    def title(self) -> str:
        """Return the name of the table."""
        return ".".join(map(str, self.path))


class Keys:
    """The tables and keys of a model; `kinds`: what `part.kind` may be."""

    def __init__(self, model: type[TomlTable], kinds: Sequence[str]) -> None:
        self.schema = model.model_json_schema()
        if kinds:
            part = self._resolved(self.schema["properties"]["part"])
            part["properties"]["kind"] |= {"enum": list(kinds)}

    def tables(self, tree: Any = None) -> list[Table]:  # noqa: ANN401 (tables of TOML)
        """Return the tables: those of a text with its values, or all that there may be."""
        return list(self._tables(self.schema, (), tree, Table((), (), "", True)))

    def published(self, title: str) -> Schema:
        """Return the JSON schema for editors, with meanings and units in plain words."""
        return {"$schema": DRAFT} | self._published(self.schema, "") | {"title": title}

    def _published(self, node: Schema, name: str) -> Schema:
        found: Schema = {}
        for word, value in node.items():
            if word in ("properties", "$defs"):
                found[word] = {key: self._published(inner, key) for key, inner in value.items()}
            elif word == "anyOf":  # TOML has no null
                kept = [self._published(v, "") for v in value if v.get("type") != "null"]
                found |= kept[0] if len(kept) == 1 else {word: kept}
            elif word == "oneOf":
                found[word] = [self._published(inner, "") for inner in value]
            elif word == "items":
                found[word] = self._published(value, "")
            elif word == "pattern":
                found[word] = value.replace(r"\z", "$")  # that of JavaScript
            elif not word.startswith("x-") and word != "title" and value is not None:
                found[word] = list(value) if word == "required" else value
        keys = node.get("properties", {})
        needed = found.get("required", [])
        others = {
            key: [other for other in keys[key].get("x-or", ()) if other in keys] for key in needed
        }
        left_out = [key for key in needed if others[key]]
        if left_out:  # each of the others stands for all of them
            found["required"] = [key for key in needed if key not in left_out]
            either = [left_out, *([other] for other in others[left_out[0]])]
            found["anyOf"] = [{"required": names} for names in either]
        meaning, unit = plain(_meaning_of(node)), unit_of(name) if name else ""
        text = f"{meaning} [{unit}]" if unit and not meaning.endswith("]") else meaning
        return found | ({"description": text.strip()} if text else {})

    def _resolved(self, node: Schema) -> Schema:
        while "$ref" in node:
            node = self.schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
        return node

    def _variants(self, node: Schema) -> list[Schema]:
        node = self._resolved(node)
        inner = node.get("anyOf") or node.get("oneOf")
        if inner:
            return [found for variant in inner for found in self._variants(variant)]
        return [] if node.get("type") == "null" else [node]

    def _tables(
        self,
        node: Schema,
        path: tuple[Step, ...],
        tree: Any,  # noqa: ANN401 (a table of TOML)
        about: Table,
    ) -> Iterator[Table]:
        values = tree if isinstance(tree, dict) else {}
        keys: list[Key] = []
        within: list[Iterator[Table]] = []
        for name, child in node["properties"].items():
            at, variants, value = (*path, name), self._variants(child), values.get(name)
            is_required = name in node.get("required", ())
            first = variants[0]
            entry = self._resolved(first.get("items", {}))
            if first.get("type") == "object":
                without = "none" if "default" in child else "all"
                inner = Table((), (), "", is_required, "" if is_required else without)
                chosen = variants[::-1] if tree is None else [_chosen(variants, value)]
                inside = value if tree is None or isinstance(value, dict) else {}
                within += [self._tables(v, at, inside, inner) for v in chosen]
            elif entry.get("type") == "object":
                without, most = "" if is_required else "none", first.get("maxItems", 0)
                inner = Table((), (), "", is_required, without, most)
                rows = value if isinstance(value, list) else []
                for i, row in enumerate(rows[:_MOST_ENTRIES]):
                    within.append(self._tables(entry, (*at, i), row, inner))
                within += [self._tables(entry, at, None, inner)] if tree is None else []
            else:
                keys.append(_key_of(at, child, variants, value, is_required=is_required))
        if path and (keys or not within):
            is_there = bool(values) or about.is_there
            meaning = _meaning_of(node)
            yield Table(path, tuple(keys), meaning, is_there, about.without, about.most)
        for tables in within:
            yield from tables


def _meaning_of(node: Schema) -> str:
    """Return the meaning of a key with the choices that it is for, or that of a table."""
    text = str(node.get("description", ""))
    if node.get("type") == "object":
        return text.split("\n")[0].partition("]: ")[2].removesuffix(".")
    only = node.get("x-only", ())
    named = ", ".join(only) if len(only) <= _MOST_NAMED else ""
    return ": ".join(filter(None, (named, text)))


def _chosen(variants: list[Schema], value: object) -> Schema:
    """Return the table that has all keys of a text; without a text the last one, by points."""
    there = set(value) if isinstance(value, dict) else set()
    fitting = (variant for variant in variants if there and there <= set(variant["properties"]))
    return next(fitting, variants[-1])


def _key_of(
    path: tuple[Step, ...],
    node: Schema,
    variants: list[Schema],
    value: object,
    *,
    is_required: bool,
) -> Key:
    bounds = variants[0].get("items", variants[0])
    return Key(
        path,
        _sort_of(variants),
        value,
        node.get("default"),
        is_required,
        node.get("x-needed", False),
        bounds.get("minimum", bounds.get("exclusiveMinimum")),
        bounds.get("maximum", bounds.get("exclusiveMaximum")),
        tuple(choice for variant in variants for choice in _choices_of(variant)),
        _range_of(variants),
        _meaning_of(node),
    )


def _choices_of(node: Schema) -> list[str | int]:
    return [node["const"]] if "const" in node else list(node.get("enum", ()))


def _range_of(variants: list[Schema]) -> str:
    found: list[str] = []
    for variant in variants:
        if "items" in variant:
            least, most = variant.get("minItems", 1), variant.get("maxItems")
            number = least if least == most else f"{least} .. {most}"
            text = f"{_range_of([variant['items']])}, {number} of them"
        elif choices := _choices_of(variant):
            text = ", ".join(f'"{c}"' if isinstance(c, str) else str(c) for c in choices)
        elif variant.get("type") == "boolean":
            text = "true, false"
        elif "maxLength" in variant and "pattern" not in variant:
            text = f"{variant.get('minLength', 0)} .. {variant['maxLength']} characters"
        else:
            text = _bounds_text(variant)
        found += [text] if text else []
    if len(found) > 1 and found[0].startswith(f"{found[-1]}, "):  # the numbers of a list, or one
        return found[0].replace(f"{found[-1]}, ", f"{found[-1]}, one or ", 1)
    return "; ".join(found)


def _bounds_text(node: Schema) -> str:
    low, high = node.get("minimum"), node.get("maximum")
    above = node.get("exclusiveMinimum")
    start = f"above {above:.9g}" if above is not None else "" if low is None else f"{low:.9g}"
    if not start or high is None:
        return f"{start} or more" if start else "" if high is None else f"at most {high:.9g}"
    return f"{start}, to {high:.9g}" if above is not None else f"{start} .. {high:.9g}"


def _sort_of(variants: list[Schema]) -> str:
    types = {str(variant.get("type", "")) for variant in variants}
    if all(_choices_of(variant) for variant in variants):
        return "choice"
    names = {"boolean": "switch", "integer": "whole", "number": "number", "string": "text"}
    if len(types) == 1 and types <= set(names):
        return names[types.pop()]
    is_flat = all(
        variant.get("items", variant).get("type") in ("number", "integer") for variant in variants
    )
    return "numbers" if "array" in types and is_flat else "other"
