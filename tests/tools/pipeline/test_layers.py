"""Every package stands in the layers of pyproject.toml, or is a kind."""

from __future__ import annotations

import tomllib

from part_cases import ROOT

TOOLS = ROOT / "tools"


def test_every_package_has_its_layer() -> None:
    """A package that the import check does not know would see everything."""
    settings = tomllib.loads((TOOLS / "pyproject.toml").read_text())
    contracts = settings["tool"]["importlinter"]["contracts"]
    [layers] = [one["layers"] for one in contracts if one["type"] == "layers"]
    named = {name.strip() for layer in layers for name in layer.split("|")}
    packages = {path.parent for path in (TOOLS / "camtools").glob("*/__init__.py")}
    kinds = {path.name for path in packages if (path / "kind.py").exists()} - {"pipeline"}
    assert {path.name for path in packages} - kinds <= named
    assert kinds >= {"skirt", "lobe"}
