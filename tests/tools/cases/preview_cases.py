"""Previews for tests: what the worker answers, without a process of its own."""

from pathlib import Path
from typing import Any

from camtools.base.cache import Memory
from camtools.panel.design.preview_worker import answers_to
from tests.tools.cases.part_cases import ROOT

PARTS = ROOT / "tools" / "parts"


def text_of(name: str) -> str:
    """Return the text of an example."""
    return (PARTS / f"{name}.toml").read_text(encoding="utf-8")


def answers(
    text: str, folder: Path = PARTS, height_mm: float | None = None, memory: Memory | None = None
) -> list[dict[str, Any]]:
    """Return all answers to a preview of a text."""
    request = {
        "id": 1,
        "do": "preview",
        "text": text,
        "folder": str(folder),
        "height_mm": height_mm,
    }
    return list(answers_to(request, memory or Memory(8)))


def stage(found: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """Return the last answer of a stage."""
    return [one for one in found if one["stage"] == name][-1]


def problems(found: list[dict[str, Any]]) -> list[str]:
    """Return what a preview complains of."""
    return [one["text"] for answer in found for one in answer.get("problems", [])]
