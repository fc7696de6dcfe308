"""What the header of a shared library declares, as ctypes names it."""

import re
from pathlib import Path

from camtools.base.project import Prototypes

_WORDS = {
    "void": "None",
    "const void *": "c_char_p",  # bytes
    "const char *": "c_char_p",
    "const char *const *": "LP_c_char_p",
    "double *": "LP_c_double",
    "const int64_t *": "LP_c_long",
    "size_t *": "LP_c_ulong",
    "bool": "c_bool",
    "int": "c_int",
    "double": "c_double",
    "size_t": "c_ulong",
    "uint64_t": "c_ulong",
    "uint32_t": "c_uint",
}

Named = dict[str, tuple[str, list[str]]]


def declared_in(header: Path, words: dict[str, str]) -> Named:
    """Return result and arguments of the functions of a header; `words` name its own types."""
    text = header.read_text()
    text = text[text.index("// [declarations]") : text.index("// [end of declarations]")]
    code = re.sub(r"//.*", "", text)
    handle = f"{header.stem}_t"
    known = _WORDS | {f"{handle} *": "c_void_p"} | words
    found = {}
    pattern = rf"^([\w ]+?[ *]+)({header.stem}_\w+)\(([^)]*)\);"
    for result, name, arguments in re.findall(pattern, code, re.MULTILINE):
        kinds = [re.sub(r"\w+$", "", one.strip()).strip() for one in arguments.split(",")]
        kinds = [kind.replace(f"const {handle}", handle) for kind in kinds if kind]
        found[name] = (known[result.strip()], [known[kind] for kind in kinds])
    return found


def named(prototypes: Prototypes) -> Named:
    """Return prototypes of a binding by the names of their types."""
    return {
        name: (getattr(result, "__name__", "None"), [one.__name__ for one in arguments])
        for name, (result, arguments) in prototypes.items()
    }
