"""camturn.dbc against the C sources that it describes."""

import itertools
import math
import re
from pathlib import Path

import cantools
import pytest
from cantools.database.can import Database

from camtools.link.kept_values import LAYOUT
from camtools.link.messages import FAULT_TEXTS, choices_of
from camtools.link.refusal_text import FAULTS

ROOT = Path(__file__).resolve().parents[3]
DBC = ROOT / "firmware" / "remote" / "can" / "camturn.dbc"
FIRMWARE = ROOT / "firmware"


@pytest.fixture(scope="module")
def database() -> Database:
    """Return the DBC, loaded strictly: no overlap, nothing outside of its message."""
    loaded = cantools.database.load_file(DBC, strict=True)
    assert isinstance(loaded, Database)
    return loaded


def test_every_fault_is_explained() -> None:
    """FAULTS.md has the faults of the firmware in order, each with title, cause and remedy."""
    assert list(FAULTS) == list(FAULT_TEXTS)
    for fault in FAULTS.values():
        assert fault.title and not fault.title.endswith(".")
        for text in (fault.cause, fault.remedy):
            assert len(text) > 15 and text.endswith(".") and text[0].isupper()
            assert not re.search(r"[`\[\]]", text), "marks of Markdown are gone"


def test_kept_values_are_those_of_learning() -> None:
    """The file of learned values has the groups of cam_learning.h, each as long as there."""
    header = FIRMWARE / "learning" / "cam_learning.h"
    body = header.read_text("utf-8").split("    cam_ilc_value_speed,")[1].split("};")[0]
    numbers = {"cam_ilc_value_speed": 0, "cam_ilc_terms": 17, "cam_ilc_harmonics": 16}
    last = 0
    for name, value in re.findall(r"(\w+)(?: = ([^,\n]*))?,?\n", body):
        text = re.sub(r"[a-z]\w*", lambda word: str(numbers[word[0]]), value)
        factors = [part.split(" * ") for part in text.split(" + ")] if value else []
        last = sum(math.prod(map(int, part)) for part in factors) if value else last + 1
        numbers[name] = last
    begins = [value for name, value in numbers.items() if "_value_" in name]
    assert last == sum(LAYOUT.values())
    assert [b - a for a, b in itertools.pairwise([*begins, last])] == list(LAYOUT.values())
    told = [name.removeprefix("cam_ilc_value_") for name in numbers if "_value_" in name]
    assert told == [name.rpartition("_")[0] for name in LAYOUT]


def test_commands_and_answers_agree(database: Database) -> None:
    """Both messages number the commands alike, and every command with a value has its signal."""
    command = database.get_message_by_name("Command")
    answer = database.get_message_by_name("Answer")
    assert choices_of(command, "command") == choices_of(answer, "command")
    numbers = set(choices_of(command, "command"))
    for message in (command, answer):
        for signal in message.signals:
            assert set(signal.multiplexer_ids or []) <= numbers


def test_every_message_and_unit_is_told(database: Database) -> None:
    """Messages carry a comment; ids are those of node 64 and collide with no PDO of others."""
    assert all(message.comment for message in database.messages)
    ids = {message.frame_id for message in database.messages}
    assert ids == {0x640, 0x5C0, 0x1C0, 0x2C0, 0x3C0, 0x4C0, 0x440, 0x340, 0x540, 0x6C0}


def test_nodes_of_every_number_stand_on_one_bus(database: Database) -> None:
    """No id of one node is another's, nor SYNC, NMT, an emergency message or a heartbeat."""
    shifts = [message.frame_id - 64 for message in database.messages]
    taken = [shift + node for node in range(1, 128) for shift in shifts]
    others = [0, *range(0x80, 0x100), *range(0x700, 0x780)]
    assert len(set(taken + others)) == len(taken) + len(others)
