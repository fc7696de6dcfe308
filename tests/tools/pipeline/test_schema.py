"""The published schemas accept what the commands accept, and refuse what a schema can refuse."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from camtools.base.text import toml_tree
from camtools.cli.mktables import main as mktables
from camtools.pipeline.load import keys_of, kind_of, kinds, schemas
from tests.tools.cases.part_cases import ROOT

PARTS = sorted((ROOT / "tools" / "parts").glob("*.toml"))
MACHINES = sorted((ROOT / "host_sim" / "machines").glob("*.toml"))
NAMES = ("object", "array", "string", "boolean", "integer", "number")
TYPES = dict(zip(NAMES, ((dict,), (list,), (str,), (bool,), (int,), (int, float)), strict=True))


def is_valid(value: object, node: dict[str, Any], root: dict[str, Any]) -> bool:
    """Return whether a value fits a schema, by the words that the published ones use."""
    unknown = node.keys() - {
        *("$schema", "$defs", "$ref", "title", "description", "default", "type", "enum", "const"),
        *("minimum", "maximum", "exclusiveMinimum", "minItems", "maxItems", "items", "pattern"),
        *("minLength", "maxLength", "properties", "required", "additionalProperties"),
        *("anyOf", "oneOf"),
    }
    assert not unknown, unknown
    if "$ref" in node:
        return is_valid(value, root["$defs"][node["$ref"].rsplit("/")[-1]], root)
    if "anyOf" in node and not any(is_valid(value, one, root) for one in node["anyOf"]):
        return False
    if "oneOf" in node and sum(is_valid(value, one, root) for one in node["oneOf"]) != 1:
        return False
    if value not in node.get("enum", [value]) or value != node.get("const", value):
        return False
    if "type" in node and type(value) not in TYPES.get(str(node["type"]), (int, bool)):
        return False
    if isinstance(value, int | float):
        low, high = node.get("minimum", value), node.get("maximum", value)
        return bool(low <= value <= high and value > node.get("exclusiveMinimum", value - 1))
    if isinstance(value, list):
        is_long = node.get("minItems", 0) <= len(value) <= node.get("maxItems", len(value))
        return is_long and all(is_valid(one, node.get("items", {}), root) for one in value)
    if isinstance(value, dict):
        keys, others = node.get("properties", {}), node.get("additionalProperties", {})
        return (
            set(node.get("required", ())) <= value.keys()
            and (others is not False or value.keys() <= keys.keys())
            and all(is_valid(one, keys.get(name, others), root) for name, one in value.items())
        )
    return not isinstance(value, str) or bool(re.search(node.get("pattern", ""), value))


def accepts(text: str, kind: str) -> bool:
    """Return whether the schema of a kind accepts a text."""
    schema = json.loads(schemas()[f"{kind}.schema.json"])
    return is_valid(toml_tree(text), schema, schema)


@pytest.mark.parametrize("path", PARTS, ids=lambda path: path.stem)
def test_schema_accepts_every_example(path: Path) -> None:
    """Of its own kind, and of no other."""
    text = path.read_text("utf-8")
    name = kind_of(tomllib.loads(text)).name
    assert [kind.name for kind in kinds() if accepts(text, kind.name)] == [name]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("spindle_rpm = 2500", "spindel_rpm = 2500"),
        ("spindle_rpm = 2500", "spindle_rpm = 0"),
        ("spindle_rpm = 2500", 'spindle_rpm = "fast"'),
        ("spindle_rpm = 2500", ""),
        ('shape = "ellipse"', 'shape = "elipse"'),
        ("feed_mm = 0.1 ", "#"),
        ("direction = 1", "direction = 0"),
        ("[process]", "[cam]\n[process]"),
    ],
)
def test_schema_refuses_what_is_wrong(old: str, new: str) -> None:
    """An editor marks it."""
    text = (ROOT / "tools" / "parts" / "perkins240.toml").read_text("utf-8")
    assert old in text
    assert not accepts(text.replace(old, new), "piston")


@pytest.mark.parametrize(
    "text",
    [
        "[u]\ndelay_us = -1\n",
        "[u]\nkind = 'soft'\n",
        "[encoder]\nsign = 0\n",
        "[cars]\n",
        "[believed.machine]\ntick_hz = 500\n",
        "[believed.u]\ndelay = 1\n",
        "[controller]\nk1_ns = 0.5\n",
    ],
)
def test_schema_refuses_a_wrong_machine(text: str) -> None:
    """A range, a choice, a sign, a table, a key."""
    assert not accepts(text, "machine")


def test_schema_accepts_every_machine_and_has_the_defaults() -> None:
    """Those that come with the simulator; the default machine has every key."""
    assert all(accepts(path.read_text("utf-8"), "machine") for path in MACHINES)
    schema = json.loads(schemas()["machine.schema.json"])["properties"]
    listed = toml_tree((ROOT / "host_sim" / "machines" / "default.toml").read_text("utf-8"))
    defaults = {
        table: {name: key.get("default", "default") for name, key in one["properties"].items()}
        for table, one in schema.items()
        if table not in ("controller", "believed")
    }
    assert defaults == {name: keys for name, keys in listed.items() if keys}
    assert schema["u"]["properties"]["kind"]["description"].startswith("a drive that takes")


@pytest.mark.parametrize("kind", [kind.name for kind in kinds()])
def test_every_key_is_explained(kind: str) -> None:
    """By its meaning, its unit or its choices."""
    keys = [key for table in keys_of(kind).tables() for key in table.keys]
    assert [key.dotted for key in keys if not (key.meaning or key.unit or key.choices)] == []


def test_command_writes_the_schemas(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They need no part; a table does."""
    assert mktables(["--schema", "-o", str(tmp_path)]) == 0
    assert {one.name: one.read_text("utf-8") for one in tmp_path.iterdir()} == schemas()
    with pytest.raises(SystemExit) as caught:
        mktables(["-o", str(tmp_path)])
    assert caught.value.code == 2
    assert "required: PART.toml" in capsys.readouterr().err
