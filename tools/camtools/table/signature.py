"""Signatures of table images, as firmware/table/TABLE_FORMAT.md, "Signature", lays them out.

The package cryptography signs here; controllers verify with another library.

>>> key = Ed25519PrivateKey.from_private_bytes(bytes(32))
>>> public = key.public_key().public_bytes_raw()
>>> key_id(public).hex()
'7dd5cfc679ab6342'
"""

from __future__ import annotations

import hashlib
import os
import stat
import struct
from pathlib import Path

from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)

from camtools.base.errors import CamtoolsError
from camtools.table.channel import ImageError
from camtools.table.image import SIGNATURE_MAGIC, SIGNATURE_SIZE, unpack, without_signature

VERSION, ID_SIZE, KEY_SIZE, SIGNED_SIZE = 1, 8, 32, 64
_FIELDS = struct.Struct("<8sII8s40x")
_PRIME = 2**255 - 19
_WEAK = (  # y of the eight points of small order, with which everybody signs
    0,
    1,
    _PRIME - 1,
    0x05FC536D880238B13933C6D305ACDFD5F098EFF289F4C345B027B2C28F95E826,
    0x7A03AC9277FDC74EC6CC392CFA53202A0F67100D760B3CBA4FD84D3D706A17C7,
)
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def key_id(public: bytes) -> bytes:
    """Return the name of a public key: the first bytes of its SHA-512."""
    return hashlib.sha512(public).digest()[:ID_SIZE]


def is_weak(public: bytes) -> bool:
    r"""Return whether no honest key looks so: a point of small order, or a number too large.

    >>> is_weak(bytes(32)), is_weak(b"\xed" + b"\xff" * 30 + b"\x7f"), is_weak(b"\x02" + bytes(31))
    (True, True, False)
    """
    y = int.from_bytes(public, "little") % 2**255
    return y >= _PRIME or y in _WEAK


def image_of(data: bytes) -> bytes:
    """Return the image of a table file, checked, without its signature.

    Raises
    ------
    CamtoolsError
        It is no table.
    """
    try:
        unpack(data)
    except ImageError as error:
        raise CamtoolsError([f"{error}; make the table again with tools/mktables"]) from error
    return without_signature(data, struct.unpack_from("<I", data, 16)[0])


def sign(data: bytes, key: Ed25519PrivateKey) -> bytes:
    """Return a table with a signature behind it, in place of the one that is there."""
    image = image_of(data)
    public = key.public_key().public_bytes_raw()
    signed = image + _FIELDS.pack(SIGNATURE_MAGIC, VERSION, len(image), key_id(public))
    return signed + key.sign(signed)


def verify(data: bytes, public_keys: list[bytes]) -> str:
    """Return what is wrong with the signature of a table, "" when one of the keys signed it."""
    image = image_of(data)
    block = data[len(image) :]
    if not block:
        return "not signed; sign it by tools/keys sign"
    magic, version, size, name = _FIELDS.unpack_from(block)
    is_known = (magic, version, size) == (SIGNATURE_MAGIC, VERSION, len(image))
    if not is_known or any(block[24:SIGNED_SIZE]) or len(block) != SIGNATURE_SIZE:
        return "its signature has another format; sign it again with tools/keys sign"
    public = next((key for key in public_keys if key_id(key) == name), None)
    if public is None:
        return f"signed by key {name.hex()}, which is not among those given; give its public key"
    try:
        signed = data[: len(image) + SIGNED_SIZE]
        Ed25519PublicKey.from_public_bytes(public).verify(block[SIGNED_SIZE:], signed)
    except InvalidSignature:
        return "its signature is wrong: it was changed after it was signed; sign what is right"
    return ""


def make_private(file: Path) -> Ed25519PrivateKey:
    """Make a private key and write it to a new file that only its owner can read.

    Raises
    ------
    CamtoolsError
        The file is there, or cannot be written.
    """
    key = Ed25519PrivateKey.generate()
    pem = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    try:
        number = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        with os.fdopen(number, "wb") as stream:
            stream.write(pem)
            os.fsync(stream.fileno())
    except FileExistsError:
        problem = f"{file}: exists, and a key is never overwritten; give another name"
        raise CamtoolsError([problem]) from None
    except OSError as error:
        raise CamtoolsError([f"{file}: {error.strerror}; give a place you can write"]) from error
    return key


def read_private(file: Path) -> Ed25519PrivateKey:
    """Return the private key of a file.

    Raises
    ------
    CamtoolsError
        Others than its owner can read it, or it holds no such key.
    """
    try:
        with file.open("rb") as stream:
            if os.fstat(stream.fileno()).st_mode & _OTHERS:
                problem = f"{file}: other users can read this private key"
                raise CamtoolsError(
                    [f"{problem}; chmod 600 it, and make a new key if somebody did"]
                )
            key = load_pem_private_key(stream.read(65536), None)
    except OSError as error:
        raise CamtoolsError([f"{file}: {error.strerror}; give a file of tools/keys make"]) from None
    except (ValueError, TypeError, UnsupportedAlgorithm):
        key = None
    if not isinstance(key, Ed25519PrivateKey):
        problem = f"{file}: not an Ed25519 private key without a password"
        raise CamtoolsError([f"{problem}; give a file of tools/keys make"])
    return key


def read_public(file: Path) -> bytes:
    """Return the public key of a file that holds its 64 hexadecimal digits.

    Raises
    ------
    CamtoolsError
        It holds something else.
    """
    try:
        key = bytes.fromhex(file.read_text("ascii").strip())
    except OSError as error:
        raise CamtoolsError([f"{file}: {error.strerror}; give a file of tools/keys make"]) from None
    except ValueError:
        key = b""
    if len(key) != KEY_SIZE:
        raise CamtoolsError([f"{file}: no public key; give a .pub file of tools/keys make"])
    if is_weak(key):
        problem = f"{file}: a weak key, for which anybody can forge signatures"
        raise CamtoolsError([f"{problem}; give a .pub file of tools/keys make"])
    return key
