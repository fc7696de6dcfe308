"""An image as the linker leaves it."""

import re
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

DSB = re.compile(rb"\xbf\xf3[\x40-\x4f]\x8f", re.DOTALL)


class Image:
    """An .elf: what is in flash, and where it lies once it runs."""

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            elf = ELFFile(file)
            loaded = [s for s in elf.iter_segments("PT_LOAD") if s["p_filesz"]]
            # address in flash and content
            self.segments = [(int(s["p_paddr"]), bytes(s.data())) for s in loaded]
            # addresses at which an instruction DSB runs
            self.barriers = [
                int(s["p_vaddr"]) + found.start()
                for s in loaded
                for found in DSB.finditer(s.data())
                if not found.start() & 1
            ]
            table = elf.get_section_by_name(".symtab")
            assert isinstance(table, SymbolTableSection), f"{path} has no symbols"
            # name -> address
            self.symbols = {s.name: int(s["st_value"]) for s in table.iter_symbols()}
            # section -> bytes
            self.sizes = {s.name: int(s["sh_size"]) for s in elf.iter_sections()}
            self.functions: dict[str, set[str]] = {}  # section -> names of the functions in it
            for symbol in table.iter_symbols():
                if symbol["st_info"]["type"] == "STT_FUNC":
                    section = elf.get_section(symbol["st_shndx"]).name
                    self.functions.setdefault(section, set()).add(symbol.name)
