# SPDX-License-Identifier: Apache-2.0
"""Keys and signatures: two implementations agree, and files that others can read are refused."""

import os
import stat
from functools import partial
from pathlib import Path

import pytest

from camtools.cli import keys, mktables
from camtools.table.signature import image_of, read_private, verify
from tests.tools.cases.camsim_cases import ROOT, camsim


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two pairs of keys and a table that the first one signed."""
    folder = tmp_path_factory.mktemp("keys")
    for name in ("one", "two"):
        assert keys.main(["make", str(folder / name)]) == 0
    part, key = str(ROOT / "tools" / "parts" / "perkins240.toml"), str(folder / "one.pem")
    assert mktables.main([part, "-o", str(folder), "--sign", key]) == 0
    return folder


_controller = partial(camsim, "verify")


def test_controller_takes_what_the_tools_sign(made: Path) -> None:
    """Cryptography signs, Monocypher verifies; each key alone and beside the other."""
    table, one, two = made / "perkins240.camtab", made / "one.pub", made / "two.pub"
    assert _controller(table, one).stdout == f"{table}: signed\n"
    assert _controller(table, two, one).returncode == 0
    refused = _controller(table, two)
    assert refused.returncode == 1
    assert refused.stdout == f"{table}: the table is signed by a key that is not trusted here\n"
    assert _controller(table).stdout == f"{table}: signature not checked\n"
    assert keys.main(["verify", str(table), str(two), str(one)]) == 0
    assert keys.main(["verify", str(table), str(two)]) == 1


def test_signing_again_replaces_the_signature(made: Path, tmp_path: Path) -> None:
    """The image stays as it is, and the second key counts."""
    data = (made / "perkins240.camtab").read_bytes()
    table = tmp_path / "again.camtab"
    table.write_bytes(data)
    assert keys.main(["sign", str(made / "two.pem"), str(table)]) == 0
    again = table.read_bytes()
    assert (len(again), image_of(again)) == (len(data), image_of(data))
    assert _controller(table, made / "two.pub").returncode == 0
    assert _controller(table, made / "one.pub").returncode == 1


_ORDER_8 = (
    "26e8958fc2b227b045c3f489f2ef98f0d5dfac05d3c63339b13802886d53fc",
    "c7176a703d4dd84fba3c0b760d10670f2a2053fa2c39ccc64ec7fd7792ac03",
)
_WEAK = (
    *(f"0{y}" + "00" * 30 + sign for y in (0, 1) for sign in ("00", "80")),
    *(f"{y:02x}" + "ff" * 30 + sign for y in (0xEC, 0xED, 0xEE, 0xFF) for sign in ("7f", "ff")),
    *(_ORDER_8[0] + sign for sign in ("05", "85")),
    *(_ORDER_8[1] + sign for sign in ("7a", "fa")),
)


@pytest.mark.parametrize("digits", _WEAK)
def test_weak_keys_are_refused_wherever_they_are_named(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], digits: str
) -> None:
    """For these anybody makes up signatures; keys, the controller's settings and camsim say no."""
    table, public = made / "perkins240.camtab", tmp_path / "weak.pub"
    public.write_text(digits + "\n")
    assert keys.main(["verify", str(table), str(made / "one.pub"), str(public)]) == 2
    assert f"{public}: a weak key, for which anybody" in capsys.readouterr().err
    refused = _controller(table, made / "one.pub", public)
    assert refused.returncode == 2
    assert "none of them weak" in refused.stderr


@pytest.mark.parametrize("at", [-1, -64, -128 + 16, -128 + 30])
def test_both_refuse_a_changed_block(made: Path, tmp_path: Path, at: int) -> None:
    """Signature, key and zeros."""
    data = bytearray((made / "perkins240.camtab").read_bytes())
    data[at] ^= 1
    table = tmp_path / "changed.camtab"
    table.write_bytes(data)
    assert _controller(table, made / "one.pub").returncode == 1
    public = bytes.fromhex((made / "one.pub").read_text())
    assert verify(bytes(data), [public]) != ""


def test_a_private_key_is_for_its_owner_alone(made: Path) -> None:
    """It is written so, and refused when others can read it."""
    file = made / "one.pem"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    try:
        for mode in (0o640, 0o604, 0o620):
            os.chmod(file, mode)  # noqa: PTH101
            with pytest.raises(Exception, match="chmod 600 it"):
                read_private(file)
    finally:
        file.chmod(0o600)


def test_name_may_have_the_ending(tmp_path: Path) -> None:
    """K.pem makes K.pem and K.pub."""
    assert keys.main(["make", str(tmp_path / "K.pem")]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["K.pem", "K.pub"]


def test_no_key_is_overwritten(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither of the two files; nothing changes."""
    before = (made / "one.pem").read_bytes()
    assert keys.main(["make", str(made / "one")]) == 2
    assert "give another" in capsys.readouterr().err
    assert (made / "one.pem").read_bytes() == before


def test_show_prints_what_ports_take(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As a line of C, of TOML, and plain."""
    public = (made / "one.pub").read_text().strip()
    capsys.readouterr()
    for option, expected in (
        ("--c", f"#define BOARD_TRUST_KEYS {{0x{public[:2].upper()}, "),
        ("--toml", f'key_1 = "{public}"'),
    ):
        assert keys.main(["show", option, str(made / "one.pub")]) == 0
        assert expected in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        (["sign", "one.pub", "perkins240.camtab"], "give a file of tools/keys make"),
        (["sign", "one.pem", "one.pub"], "make the table again"),
        (["verify", "perkins240.camtab", "one.pem"], "give a .pub file"),
        (["show", "none.pub"], "give a file of tools/keys make"),
    ],
)
def test_wrong_files_are_refused_by_name(
    made: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    remedy: str,
) -> None:
    """With what to give instead."""
    monkeypatch.chdir(made)
    if words[1] == "one.pub":
        (made / "one.pub").chmod(0o600)
    assert keys.main(words) == 2
    assert remedy in capsys.readouterr().err
