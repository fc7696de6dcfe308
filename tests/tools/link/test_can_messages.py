# SPDX-License-Identifier: Apache-2.0
"""camturn.dbc against the C sources that it describes, and the C made of it."""

import itertools
import math
import re
from pathlib import Path

import cantools
import pytest
from cantools.database.can import Database, Message

from camtools.cli.can_source import generate, main
from camtools.link.faults import FAULTS
from camtools.link.learned_file import LAYOUT
from camtools.link.messages import FAULT_TEXTS

ROOT = Path(__file__).resolve().parents[3]
DBC = ROOT / "firmware" / "remote" / "can" / "camturn.dbc"
FIRMWARE = ROOT / "firmware"
HAL = ROOT / "hal" / "include" / "hal" / "hal.h"
QUICK = {
    "speed": ("spindle_mrpm", 1e-3),
    "feed": ("feed_nm", 1e-6),
    "amplitude": ("amplitude_ppm", 1e-4),
    "phase": ("phase_udeg", 1e-6),
}


@pytest.fixture(scope="module")
def database() -> Database:
    """Return the DBC, loaded strictly: no overlap, nothing outside of its message."""
    loaded = cantools.database.load_file(DBC, strict=True)
    assert isinstance(loaded, Database)
    return loaded


def choices(message: Message, signal: str) -> dict[int, str]:
    """Return a value table as plain names."""
    table = message.get_signal_by_name(signal).choices
    assert table is not None
    return {int(number): str(name) for number, name in table.items()}


def header_of(name: str) -> str:
    """Return the text of a header of the firmware, whichever room it is in."""
    [path] = FIRMWARE.rglob(name)
    return path.read_text("utf-8")


def rows(header: str, macro: str) -> list[list[str]]:
    """Return the arguments of every X() of an X-macro."""
    text = header_of(header)
    body = text.split(f"#define {macro}(X)")[1].split("\n\n")[0]
    found = re.findall(r"X\(([^\n]*)\)\s*\\?\n?", body + "\n")
    return [[word.strip().strip('"') for word in row.split(",")] for row in found]


def enumerators(text: str, type_name: str, prefix: str) -> dict[int, str]:
    """Return the enumerators of a C enumeration by their numbers, without their prefix."""
    body = text.split(f"}} {type_name};")[0].rpartition("typedef enum")[2]
    body = re.sub(r"//[^\n]*", "", body)
    number, found = -1, {}
    for name, value in re.findall(
        r"(\w+)\s*(?:=\s*(-?\d+))?\s*[,}\n]", body.split("{", 1)[1] + ","
    ):
        number = int(value) if value else number + 1
        found[number] = name.removeprefix(prefix)
    return found


# Each table of numbers: a message and its signal, or a value table; and the enumeration in C.
ENUMERATIONS = [
    ("State.state", "cam_state.h", "cam_state_t", "cam_state_"),
    ("State.reset_reason", "hal.h", "hal_reset_t", "hal_reset_"),
    ("Detail.params_kept", "cam_machine.h", "cam_kept_t", "cam_kept_"),
    ("Detail.learn_phase", "cam_ilc.h", "cam_ilc_phase_t", "cam_ilc_"),
    ("Detail.learn_reason", "cam_ilc.h", "cam_ilc_reason_t", "cam_ilc_"),
    ("Detail.hand_phase", "cam_config.h", "cam_jog_phase_t", "cam_jog_"),
    ("Detail.hand_end", "cam_config.h", "cam_jog_end_t", "cam_jog_"),
    ("Detail.recorder_use", "cam_scope.h", "cam_scope_use_t", "cam_scope_"),
    ("Detail.recorder_phase", "cam_scope.h", "cam_scope_phase_t", "cam_scope_"),
    ("scope_use", "cam_scope.h", "cam_scope_use_t", "cam_scope_"),
    ("scope_phase", "cam_scope.h", "cam_scope_phase_t", "cam_scope_"),
    ("scope_end", "cam_scope.h", "cam_scope_end_t", "cam_scope_"),
    ("trigger", "cam_scope.h", "cam_trigger_kind_t", "cam_trigger_"),
    ("excited", "cam_machine.h", "cam_excited_t", "cam_excited_"),
    ("refusal_field", "cam_machine.h", "cam_refusal_field_t", "cam_refusal_"),
]
MACROS = [
    ("Command.parameter", "cam_param.h", "CAM_PARAMS"),
    ("Answer.parameter", "cam_param.h", "CAM_PARAMS"),
    ("scope_signal", "cam_scope.h", "CAM_SCOPE_SIGNALS"),
    ("scope_field", "cam_scope.h", "CAM_SCOPE_FIELDS"),
]


def numbered(database: Database, name: str) -> dict[int, str]:
    """Return the names of a value table, or of a signal: "Message.signal"."""
    message, _, signal = name.rpartition(".")
    if message:
        return choices(database.get_message_by_name(message), signal)
    assert database.dbc is not None
    return {int(number): str(word) for number, word in database.dbc.value_tables[name].items()}


@pytest.mark.parametrize(("name", "header", "type_name", "prefix"), ENUMERATIONS)
def test_names_are_those_of_an_enumeration(
    database: Database, name: str, header: str, type_name: str, prefix: str
) -> None:
    """Every enumerator has its name, and there are no others; their number is none of them."""
    text = HAL.read_text("utf-8") if header == HAL.name else header_of(header)
    words = enumerators(text, type_name, prefix)
    if re.match(r"(cam_)?n(_|$)", list(words.values())[-1]):
        words.popitem()
    assert words and numbered(database, name) == words


@pytest.mark.parametrize(("name", "header", "macro"), MACROS)
def test_names_are_those_of_a_list(database: Database, name: str, header: str, macro: str) -> None:
    """Numbers follow the order of the list."""
    told = [row[0] for row in rows(header, macro)]
    assert len(told) > 10
    assert numbered(database, name) == dict(enumerate(told))


@pytest.mark.parametrize("name", ["Answer.result", "State.table_result"])
def test_errors_are_those_of_the_firmware(database: Database, name: str) -> None:
    """Results of commands and of the table's check are cam_err_t."""
    text = header_of("cam_err.h")
    errors = {int(number): name for name, number in re.findall(r"X\((\w+), +(-\d+),", text)}
    assert len(errors) > 30
    assert numbered(database, name) == errors | {0: "done"}


def test_faults_are_those_of_the_firmware(database: Database) -> None:
    """One signal for each fault, with its text, and no other; a title, a cause and a remedy."""
    told = {
        name: f"{what[0].upper()}{what[1:]}." for name, what in rows("cam_state.h", "CAM_FAULTS")
    }
    assert len(told) > 10
    signals = database.get_message_by_name("State").signals
    texts = {one.name: str(one.comment) for one in signals if one.name.startswith("fault_")}
    assert texts == {f"fault_{name}": text for name, text in told.items()}
    assert list(FAULTS) == list(told) == list(FAULT_TEXTS)
    for fault in FAULTS.values():
        assert fault.title and not fault.title.endswith(".")
        for text in (fault.cause, fault.remedy):
            assert len(text) > 15 and text.endswith(".") and text[0].isupper()
            assert not re.search(r"[`\[\]]", text), "marks of Markdown are gone"


def test_kept_values_are_those_of_learning() -> None:
    """The file of learned values has the groups of cam_ilc.h, each as long as there."""
    body = header_of("cam_ilc.h").split("    cam_ilc_value_speed,")[1].split("};")[0]
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


def test_quick_commands_have_the_ranges_of_their_parameters(database: Database) -> None:
    """Speed, feed, amplitude, phase: factor and range are those of the parameter behind."""
    ranges = {row[0]: (int(row[1]), int(row[3])) for row in rows("cam_param.h", "CAM_PARAMS")}
    command = database.get_message_by_name("Command")
    for name, (parameter, factor) in QUICK.items():
        signal = command.get_signal_by_name(name)
        low, high = ranges[parameter]
        assert signal.scale == pytest.approx(factor)
        assert signal.minimum == pytest.approx(low * factor)
        assert signal.maximum == pytest.approx(high * factor)


def test_commands_and_answers_agree(database: Database) -> None:
    """Both messages number the commands alike, and every command with a value has its signal."""
    command = database.get_message_by_name("Command")
    answer = database.get_message_by_name("Answer")
    assert choices(command, "command") == choices(answer, "command")
    numbers = set(choices(command, "command"))
    for message in (command, answer):
        for signal in message.signals:
            assert set(signal.multiplexer_ids or []) <= numbers


def test_every_message_and_unit_is_told(database: Database) -> None:
    """Messages carry a comment; ids are those of node 64 and collide with no PDO of others."""
    assert all(message.comment for message in database.messages)
    ids = {message.frame_id for message in database.messages}
    assert ids == {0x640, 0x5C0, 0x1C0, 0x2C0, 0x3C0, 0x4C0, 0x440, 0x340, 0x240, 0x540, 0x6C0}


def test_nodes_of_every_number_stand_on_one_bus(database: Database) -> None:
    """No id of one node is another's, nor SYNC, NMT, an emergency message or a heartbeat."""
    shifts = [message.frame_id - 64 for message in database.messages]
    taken = [shift + node for node in range(1, 128) for shift in shifts]
    others = [0, *range(0x80, 0x100), *range(0x700, 0x780)]
    assert len(set(taken + others)) == len(taken) + len(others)


def test_same_dbc_gives_the_same_bytes_without_floating_point() -> None:
    """Twice the same; no day, no version, no double."""
    text = DBC.read_text("utf-8")
    first, second = generate(text, "camturn"), generate(text, "camturn")
    assert first == second
    for made in first:
        assert not re.search(r"\b(double|float|20\d\d \d|version)\b", made.split("*/", 1)[1])
        assert not re.search(r"cantools version|\b20[2-9]\d\b", made)
        assert "phys_range" not in made
    assert "int camturn_state_pack(" in first[0]
    assert "int camturn_state_pack(" in first[1]


@pytest.mark.parametrize(
    "text", ["", "BO_ rubbish", 'BO_ 1 A: 8 X\n SG_ a : 60|8@1+ (1,0) [0|0] "" X']
)
def test_bad_dbc_is_bad_input(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is missing or no DBC ends with status 2 and one line that has the path."""
    file = tmp_path / "bad.dbc"
    if text:
        file.write_text(text)
    assert main([str(file), str(tmp_path)]) == 2
    assert "bad.dbc" in capsys.readouterr().err
    assert not (tmp_path / "bad.c").exists()
