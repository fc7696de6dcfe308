"""Files of strangers that would keep the panel busy for hours; questions that are out of date."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest

from camtools.base.errors import CamtoolsError
from camtools.link import kept_values
from camtools.panel.design.document import edited, lines_of
from camtools.panel.operate import command_card
from camtools.panel.operate.command_card import CommandCard
from camtools.panel.orders.snapshot import Snapshot
from camtools.part.model import read_tree
from camtools.sim.machine_file import read_machine

HOSTILE = {
    "dotted key": "a." * 400_000 + "a = 1",
    "dotted with spaces": "a . " * 200_000 + "a = 1",
    "quoted names": '"a b" . ' * 100_000 + "a = 1",
    "literal names": "'a.b'." * 100_000 + "a = 1",
    "header": "[" + "a." * 400_000 + "a]",
    "in a list": "x = [\n{" + "a." * 400_000 + "a = 1}]",
    "behind a string": 'x = """\\"""\n"""\n' + "a." * 400_000 + "a = 1",
    "lists in lists": "a = " + "[" * 400_000,
    "tables in tables": "a = " + "{a=" * 300_000,
}
READERS: dict[str, Callable[[str], object]] = {
    "part": lambda text: read_tree(text.encode(), "a.toml"),
    "machine": lambda text: read_machine(text, "a.toml"),
    "parameters": lambda text: kept_values.parse(text.encode(), "a.toml"),
    "learned": lambda text: kept_values.learned_values(text.encode(), "a.toml"),
    "form": lambda text: edited(text, ("part", "name"), "a"),
}


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("reader", READERS)
def test_a_file_of_a_stranger_keeps_nobody_busy(reader: str, kind: str) -> None:
    """Each is refused at once, in one line; tomllib would take hours, or end the link's thread."""
    with pytest.raises(CamtoolsError) as caught:
        READERS[reader](HOSTILE[kind])
    (line,) = caught.value.lines
    assert "more than 32 names" in line or "nested too deeply" in line


def test_numbers_and_texts_with_many_points_are_no_long_keys() -> None:
    """Of a list in one line, in strings and comments."""
    text = f"x = [{'0.5, ' * 1000}]\ny = '{'a.' * 100}'\n# {'a.' * 100}\nz = \"{'b.' * 99}\"\n"
    assert set(read_tree(text.encode(), "a.toml")) == {"x", "y", "z"}


def test_lines_are_found_in_texts_that_are_none() -> None:
    """In time that rises with the length, not with its square or cube."""
    for text in ("[" + " " * 300_000, '"\\' * 300_000, '"""\\' * 100_000, "x " * 300_000):
        assert lines_of(text, ["x.y"]) == {}


READY = Snapshot(is_connected=True, state="ready", table_name="a part", signals={"table_crc": 1.0})


@pytest.mark.parametrize(
    ("change", "is_started"),
    [
        ({}, True),
        ({"table_name": "another part"}, False),
        ({"signals": {"table_crc": 2.0}}, False),
        ({"state": "fault"}, False),
        ({"since_s": 2.0}, False),
    ],
)
def test_an_old_question_starts_nothing_else(
    monkeypatch: pytest.MonkeyPatch, change: dict[str, Any], is_started: bool
) -> None:
    """While it was open another had the command, took another table into use, or a fault came."""
    told: list[str] = []
    commander = SimpleNamespace(holder="me", since_s=1.0)
    service = SimpleNamespace(snapshot=lambda: READY)

    async def give(name: str) -> None:
        told.append(name)

    async def agreed(*_words: str) -> bool:
        commander.since_s = change.get("since_s", 1.0)
        shown = {name: value for name, value in change.items() if name != "since_s"}
        service.snapshot = lambda: replace(READY, **shown)
        return True

    monkeypatch.setattr(command_card, "confirmed", agreed)
    card = CommandCard.__new__(CommandCard)
    card._orders = orders = MagicMock(visitor="me", why_no_rights="", give=give)
    orders.context.commander, orders.context.service = commander, service
    orders.refuse = lambda name, why: told.append(why)
    asyncio.run(card.start())
    assert (told == ["start"]) is is_started
    assert is_started or told == [command_card._CHANGED]
