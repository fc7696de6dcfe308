"""All kinds of parts: every package of camtools with a module `kind`.

>>> [kind.name for kind in kinds()]
['piston', 'cam', 'polygon']
"""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import camtools
from camtools.base.json_text import emit_json
from camtools.part.schema import Keys
from camtools.pipeline.kind import AnyKind, Kind
from camtools.sim.machine_schema import machine_schema


def kinds() -> list[AnyKind]:
    """Return all kinds by their rank."""
    found: list[AnyKind] = []
    for package in pkgutil.iter_modules(camtools.__path__, "camtools."):
        name = f"{package.name}.kind"
        if package.ispkg and name != Kind.__module__ and find_spec(name) is not None:
            kind = import_module(name).KIND
            assert isinstance(kind, Kind), name
            found.append(kind)
    return sorted(found, key=lambda kind: (kind.rank, kind.name))


@cache
def keys_of(name: str) -> Keys:
    """Return the keys of the part files of a kind."""
    known = {kind.name: kind.model for kind in kinds()}
    return Keys(known[name], tuple(known))


def schemas() -> dict[str, str]:
    """Return the JSON schemas of the files that people write, by the names of their files."""
    found = {kind.name: Keys(kind.model, (kind.name,)).published(kind.plural) for kind in kinds()}
    found["machine"] = machine_schema()
    return {f"{name}.schema.json": emit_json(schema) for name, schema in found.items()}


def kind_of(tree: dict[str, Any]) -> AnyKind:
    """Return the kind that the tables of a part file name, the first one where they name none."""
    part, known = tree.get("part"), kinds()
    name = part.get("kind") if isinstance(part, dict) else None
    return next((kind for kind in known if kind.name == name), known[0])
