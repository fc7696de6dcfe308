"""What an interrupt may not reach: names, instructions and sources.

>>> forbidden_name("__aeabi_uldivmod"), forbidden_name("cam_tick_isr")
('64-bit or software division', None)
"""

from __future__ import annotations

import re

from checks.elf_image import ImageInstruction

_NAMES = (
    ("64-bit or software division", r"__aeabi_u?l?i?div(mod)?|__u?(div|mod|divmod)[sdt]i[34]"),
    ("soft floating point", r"__aeabi_(c?[dfh]|u?[il]2[dfh])\w*"),
    ("soft floating point", r"__\w+[sd]f([sdt][if])?[234]?"),
    ("the heap", r"_?(malloc|calloc|realloc|free|memalign|aligned_alloc|sbrk)(_r)?"),
    ("libc", r"_*(mem(cpy|move|set|cmp|chr|rchr)|str[a-z]+|a?to[ilf]\w*|abort|exit|qsort)(_r)?"),
    (
        "libc",
        r"__aeabi_mem\w+|_*[a-z]*(printf|scanf|puts|putc|putchar|write|read)(_r)?|__assert\w*",
    ),
)
_FORBIDDEN_NAMES = [(why, re.compile(names)) for why, names in _NAMES]

_INSTRUCTIONS = (
    ("division", r"[su]div"),
    ("floating-point unit", r"(v|fld|fst)[a-z0-9]+"),
    ("a lock", r"cps\w*|msr"),
    ("waiting", r"wf[ei]"),
    ("leaves to a debugger or a supervisor", r"bkpt|svc|hlt"),
)
_FORBIDDEN_INSTRUCTIONS = [(why, re.compile(names)) for why, names in _INSTRUCTIONS]


def forbidden_name(name: str) -> str | None:
    """Return why a function of this name may not be called, if so."""
    plain = re.sub(r"\.(isra|part|constprop|lto_priv)\.\d+.*$", "", name)
    return next((why for why, names in _FORBIDDEN_NAMES if names.fullmatch(plain)), None)


def forbidden_instruction(one: ImageInstruction) -> str | None:
    """Return why an instruction may not stand there, if so."""
    return next((why for why, names in _FORBIDDEN_INSTRUCTIONS if names.fullmatch(one.base)), None)
