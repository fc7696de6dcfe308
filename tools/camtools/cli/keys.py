"""Command line of the keys for signed tables.

>>> main(["verify", "no.camtab", "no.pub"])
2
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.output import write_all
from camtools.table.signature import key_id, make_private, read_private, read_public, sign, verify

FAILED = 1


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(prog="tools/keys", description="Make keys, sign tables, verify signatures.")
    commands = parser.add_subparsers(dest="command", required=True)
    made = commands.add_parser("make", help="make a key pair: NAME.pem (private) and NAME.pub")
    made.add_argument("name", type=Path, metavar="NAME", help="name of the files without ending")
    shown = commands.add_parser(
        "show", help="print a public key in the form that a controller needs"
    )
    shown.add_argument("public", type=Path, metavar="NAME.pub", help="public key")
    shown.add_argument(
        "--c", action="store_true", help="print it for board_config.h of the STM32H743"
    )
    shown.add_argument(
        "--toml", action="store_true", help="print it for the settings file of the Linux port"
    )
    signed = commands.add_parser("sign", help="sign a table; its file changes")
    signed.add_argument("private", type=Path, metavar="NAME.pem", help="private key")
    signed.add_argument("table", type=Path, metavar="TABLE.camtab", help="table to sign")
    verified = commands.add_parser(
        "verify", help="check that one of these keys signed a table; exit status 1 if none did"
    )
    verified.add_argument("table", type=Path, metavar="TABLE.camtab", help="table to check")
    verified.add_argument("public", type=Path, nargs="+", metavar="NAME.pub", help="public keys")
    return parser.parse_args(argv)


def _read(table: Path) -> bytes:
    try:
        return table.read_bytes()
    except OSError as error:
        raise CamtoolsError(
            [f"{table}: {error.strerror}; give a table of tools/mktables"]
        ) from None


def _make(name: Path) -> int:
    name = name.with_suffix("") if name.suffix == ".pem" else name
    public_file = name.with_name(name.name + ".pub")
    if public_file.exists():
        raise CamtoolsError(
            [f"{public_file}: exists, and no key is overwritten; give another name"]
        )
    public = make_private(name.with_name(name.name + ".pem")).public_key().public_bytes_raw()
    write_all(name.parent, {public_file.name: f"{public.hex()}\n".encode()})
    print(f"key {key_id(public).hex()}: {name}.pem is private, {name}.pub is for the machines")
    return 0


def _show(arguments: argparse.Namespace) -> int:
    public = read_public(arguments.public)
    if arguments.c:
        print(f"// key {key_id(public).hex()}\n#define BOARD_TRUST_N_KEYS 1")
        print(f"#define BOARD_TRUST_KEYS {{{', '.join(f'0x{byte:02X}' for byte in public)}}}")
    elif arguments.toml:
        print(f'[trust]\nkey_1 = "{public.hex()}" # key {key_id(public).hex()}')
    else:
        print(f"{public.hex()}  key {key_id(public).hex()}")
    return 0


def _run(arguments: argparse.Namespace) -> int:
    if arguments.command == "make":
        return _make(arguments.name)
    if arguments.command == "show":
        return _show(arguments)
    if arguments.command == "sign":
        key, table = read_private(arguments.private), arguments.table
        write_all(table.parent, {table.name: sign(_read(table), key)})
        print(f"{table}: signed by key {key_id(key.public_key().public_bytes_raw()).hex()}")
        return 0
    problem = verify(_read(arguments.table), [read_public(file) for file in arguments.public])
    print(f"{arguments.table}: {problem or 'signed by one of these keys'}")
    return FAILED if problem else 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; 0 done, 1 not signed by these keys, 2 bad input, 128 + n on signal n."""
    return run_command("keys", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
