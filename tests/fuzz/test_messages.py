"""The functions that the firmware packs and unpacks messages by agree with cantools itself.

Random bytes of every message are unpacked by the generated C and by cantools; both read the same
numbers, and what both pack of them is the same again.
"""

import random
import subprocess
from pathlib import Path

import cantools
import pytest
from cantools.database.can import Database
from cantools.database.can.c_source import camel_to_snake_case

from tests.tools.cases.part_cases import ROOT

N_EACH = 400
GENERATED = ROOT / "firmware" / "remote" / "can"
DATABASE = cantools.database.load_file(GENERATED / "camturn.dbc")
assert isinstance(DATABASE, Database)  # a DBC describes no diagnostics
MESSAGES = DATABASE.messages


def printed(field: str, *, is_signed: bool) -> str:
    """Return the statement that prints a field of a message."""
    form, kind = ("%lld", "long long") if is_signed else ("%llu", "unsigned long long")
    return f'printf("{form} ", ({kind})m.{field});'


def harness() -> str:
    """Return a program that unpacks lines `NUMBER BYTES`, prints and packs the values again."""
    cases = []
    for number, message in enumerate(MESSAGES):
        name = f"camturn_{camel_to_snake_case(message.name)}"
        statements = "".join(
            printed(camel_to_snake_case(signal.name), is_signed=signal.is_signed)
            for signal in message.signals
        )
        cases.append(
            f"case {number}: {{ struct {name}_t m; memset(&m, 0, sizeof m);"
            f"if ({name}_unpack(&m, bytes, {message.length}) != 0) return 1; {statements}"
            f"if ({name}_pack(again, &m, {message.length}) != {message.length}) return 1; break; }}"
        )
    return f"""
#include "camturn.h"
#include <stdio.h>
#include <string.h>
int main(void) {{
    int number; unsigned byte;
    while (scanf("%d", &number) == 1) {{
        uint8_t bytes[64] = {{0}}, again[64] = {{0}};
        for (int i = 0; i < 64; i++) {{
            if (scanf("%2x", &byte) != 1) return 1;
            bytes[i] = (uint8_t)byte;
        }}
        switch (number) {{ {"".join(cases)} default: return 1; }}
        printf("|");
        for (int i = 0; i < 64; i++) printf("%02x", (unsigned)again[i]);
        printf("\\n");
    }}
    return 0;
}}
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the program."""
    folder = tmp_path_factory.mktemp("messages")
    source, built = folder / "harness.c", folder / "harness"
    source.write_text(harness(), "utf-8")
    words = ["gcc", f"-I{GENERATED}", str(source), str(GENERATED / "camturn.c"), "-o", str(built)]
    subprocess.run(words, check=True)
    return built


def test_generated_functions_agree_with_the_database(program: Path) -> None:
    """All values of all messages are the same in both, and packed again into the same bytes."""
    dice = random.Random(18)
    drawn = [
        (i, bytes(dice.choice((0, 1, 127, 128, 255, dice.randrange(256))) for _ in range(m.length)))
        for i, m in enumerate(MESSAGES)
        for _ in range(N_EACH)
    ]
    lines = "".join(f"{i} {data.ljust(64, bytes(1)).hex()}\n" for i, data in drawn)
    said = subprocess.check_output([program], input=lines, text=True).splitlines()
    assert len(said) == len(drawn)
    n_compared = dict.fromkeys((m.name for m in MESSAGES), 0)
    for (i, data), line in zip(drawn, said, strict=True):
        message = MESSAGES[i]
        values, packed = line.split("|")
        numbers = dict(
            zip((s.name for s in message.signals), map(int, values.split()), strict=True)
        )
        try:
            wanted = message.decode(data, decode_choices=False, scaling=False)
        except cantools.database.DecodeError:
            continue  # a page that there is not
        assert isinstance(wanted, dict)
        assert {name: numbers[name] for name in wanted} == wanted, message.name
        again = message.encode(wanted, scaling=False, strict=False)
        assert bytes.fromhex(packed)[: message.length] == again, message.name
        n_compared[message.name] += 1
    assert min(n_compared.values()) > 0, n_compared
