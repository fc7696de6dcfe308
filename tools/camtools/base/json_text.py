r"""JSON documents as text.

>>> emit_json({"b": 1, "a": [0.5]})
'{\n "a": [\n  0.5\n ],\n "b": 1\n}\n'
"""

from __future__ import annotations

import json
from typing import Any

Json = dict[str, Any]


def emit_json(summary: Json) -> str:
    """Return a summary as JSON text: sorted keys, full double precision, deterministic."""
    return json.dumps(summary, indent=1, sort_keys=True, allow_nan=False) + "\n"
