# SPDX-License-Identifier: Apache-2.0
"""Names what lies at an address by the types of an image: g_cam.motion.axis[1].pos_q10."""

from __future__ import annotations

from pathlib import Path

from elftools.dwarf.die import DIE
from elftools.elf.elffile import ELFFile

_WRAPPERS = ("DW_TAG_typedef", "DW_TAG_const_type", "DW_TAG_volatile_type", "DW_TAG_atomic_type")


def _plain(die: DIE) -> DIE:
    """Return the type behind typedefs and qualifiers."""
    while die.tag in _WRAPPERS:
        die = die.get_DIE_from_attribute("DW_AT_type")
    return die


def _number(die: DIE, name: str, default: int = 0) -> int:
    return int(die.attributes[name].value) if name in die.attributes else default


def _size(die: DIE) -> int:
    plain = _plain(die)
    if plain.tag != "DW_TAG_array_type":
        return _number(plain, "DW_AT_byte_size")
    n = 1
    for one in plain.iter_children():
        n *= _number(one, "DW_AT_upper_bound", -1) + 1
    return n * _size(plain.get_DIE_from_attribute("DW_AT_type"))


def _name(die: DIE) -> str:
    name = die.attributes["DW_AT_name"].value
    return name.decode() if isinstance(name, bytes) else str(name)


def _array(die: DIE, offset: int) -> str:
    element = die.get_DIE_from_attribute("DW_AT_type")
    size = _size(element)
    return f"[{offset // size}]" + path_in(element, offset % size)


def path_in(die: DIE, offset: int) -> str:
    """Return the members that lead to a byte of a type, and which byte of a number it is."""
    plain = _plain(die)
    if plain.tag == "DW_TAG_array_type":
        return _array(plain, offset)
    if plain.tag != "DW_TAG_structure_type":
        return f"+{offset}" if offset else ""
    for member in plain.iter_children():
        begin = _number(member, "DW_AT_data_member_location")
        kind = member.get_DIE_from_attribute("DW_AT_type")
        if begin <= offset < begin + _size(kind):
            return f".{_name(member)}" + path_in(kind, offset - begin)
    return f"+{offset}, padding"


class Layout:
    """Global variables of an image."""

    def __init__(self, image: Path, names: tuple[str, ...]) -> None:
        self._file = image.open("rb")  # types are read when they are asked for
        elf = ELFFile(self._file)
        table = elf.get_section_by_name(".symtab")
        places = {s.name: (s["st_value"], s["st_size"]) for s in table.iter_symbols()}
        self._types = {}
        for unit in elf.get_dwarf_info().iter_CUs():
            for die in unit.get_top_DIE().iter_children():
                is_one = die.tag == "DW_TAG_variable" and "DW_AT_name" in die.attributes
                if is_one and _name(die) in names and "DW_AT_type" in die.attributes:
                    kind = die.get_DIE_from_attribute("DW_AT_type")
                    if _name(die) in places:
                        self._types[_name(die)] = (*places[_name(die)], kind)

    def of_address(self, address: int) -> str | None:
        """Return the name of what lies there, None outside of these variables."""
        for name, (begin, size, kind) in self._types.items():
            if begin <= address < begin + size:
                return name + path_in(kind, address - begin)
        return None
