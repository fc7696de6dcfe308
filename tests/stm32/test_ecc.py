"""Error-correcting memory: start-up, corrected errors in the status, halt on the others."""

import struct
from collections import Counter, defaultdict

import pytest
from unicorn import UC_HOOK_MEM_READ, UC_HOOK_MEM_WRITE, UC_MEM_WRITE, Uc
from unicorn import arm_const as arm

from camtools.link.controller import Status
from camtools.link.status_text import report
from tests.stm32.board import TABLE
from tests.stm32.emulator import FLASH, RAMS, Chip
from tests.stm32.models.core import is_double_store
from tests.stm32.models.flash_pwr import SNECCERR
from tests.stm32.models.ramecc import MONITORS
from tests.stm32.remote import DATABASE, DETAIL, START
from tests.stm32.session import Session

KEEP = range(0x2001FF00, 0x20020000)
BOOT = range(FLASH, FLASH + 0x400)
DATA = (0x20004000, 0x2001FEFF)  # of the DTCM, above the stack
IN_ITCM, IN_AXI = "stm_tick_isr", "cam_report_send"  # functions that run all the time
ALL_CODE_S = 12e-3  # in which all of them run
LDR_LITERAL = 9  # first five bits of the instruction
SAFE = (0, 0, 0, 0)
ANYTHING = UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE


class StartUp:
    """Accesses to RAM until the monitors are enabled."""

    def __init__(self, chip: Chip) -> None:
        self.chip = chip
        self.doubles: set[int] = set()  # words that a 64-bit store has written
        self.early: list[int] = []  # words that were read, or written otherwise, before that
        self.of_boot: set[int] = set()  # words that the code in flash has written

    def watch(self) -> None:
        """Run the start-up."""
        uc = self.chip.uc
        hooks = [uc.hook_add(ANYTHING, self._note, None, at, at + n - 1) for at, n in RAMS]
        is_on = self.chip.run_until(lambda: self.chip.ramecc.v["cr4"] != 0, 10_000_000)
        for hook in hooks:
            uc.hook_del(hook)
        assert is_on, (
            f"no monitor is enabled, the image is in {self.chip.function_at(self.chip.pc)}"
        )

    def _note(self, uc: Uc, access: int, address: int, size: int, value: int, user: object) -> None:
        pc = uc.reg_read(arm.UC_ARM_REG_PC)
        words = range(address & ~3, address + size, 4)
        is_store = access == UC_MEM_WRITE
        if is_store and pc in BOOT:
            self.of_boot.update(words)
        if is_store and is_double_store(bytes(self.chip.uc.mem_read(pc, 2))):
            self.doubles.update(words)
        else:
            self.early += [word for word in words if word not in self.doubles]


def words_of(memories: tuple[tuple[int, int], ...]) -> set[int]:
    """Return the addresses of all words of memories."""
    return {word for at, n in memories for word in range(at, at + n, 4)}


def test_power_on_writes_all_ram_with_64_bit_stores_first() -> None:
    """Both TCMs and the AXI SRAM, the place of the halt text included."""
    session = Session()
    session.board.power_on()
    start = StartUp(session.chip)
    start.watch()
    assert start.early == []
    assert start.doubles >= words_of(RAMS)


@pytest.mark.long
def test_software_reset_spares_the_text_of_a_halt(started: Session) -> None:
    """All RAM but the place of the text, which is whole from before."""
    started.chip.reset("software")
    start = StartUp(started.chip)
    start.watch()
    assert set(start.early) <= set(KEEP)
    assert start.doubles >= words_of(RAMS) - set(KEEP)
    assert not start.of_boot & set(KEEP)


def loaded(session: Session, areas: list[tuple[int, int]], duration_s: float) -> list[int]:
    """Return the words of areas that are loaded but never written, the most used first."""
    loads: Counter[int] = Counter()
    stores: set[int] = set()

    def note(uc: Uc, access: int, address: int, size: int, value: int, user: object) -> None:
        if access == UC_MEM_WRITE:
            stores.add(address & ~3)
        else:
            loads[address & ~3] += 1

    chip = session.chip
    hooks = [chip.uc.hook_add(ANYTHING, note, None, first, last) for first, last in areas]
    chip.run(chip.seconds(duration_s))
    for hook in hooks:
        chip.uc.hook_del(hook)
    return [word for word, _ in loads.most_common() if word not in stores]


def data_words(session: Session) -> list[int]:
    """Return words of the DTCM that every tick loads."""
    return loaded(session, [DATA], 2e-3)


def literal(session: Session, function: str) -> int:
    """Return the address of a constant that a function loads from its code."""
    start = session.chip.image.symbols[function] & ~1
    halves = struct.unpack("<256H", session.chip.read_memory(start, 512))
    likely = {
        (start + 2 * i + 4 & ~3) + 4 * (half & 0xFF)
        for i, half in enumerate(halves)
        if half >> 11 == LDR_LITERAL
    }
    return loaded(session, [(word, word + 3) for word in likely], ALL_CODE_S)[0]


def memory_lines_of(signals: dict[str, float]) -> list[str]:
    """Return what `camctl status` shows of the memory."""
    status = Status(defaultdict(float, signals))
    return [line for line in report(status) if line.startswith("memory")]


def memory_lines(session: Session) -> list[str]:
    """Return the same for the next page of the memory, once all code has run."""
    frames, chip = session.remote.frames(DETAIL), session.chip
    chip.run(chip.seconds(ALL_CODE_S))
    frames.clear()
    assert chip.run_until(lambda: bool(frames) and frames[-1].data[0] == 4, chip.seconds(0.3))
    page = DATABASE.get_message_by_name("Detail").decode_simple(frames[-1].data)
    return memory_lines_of({name: float(str(value)) for name, value in page.items()})


@pytest.mark.long
def test_corrected_errors_are_counted_and_shown(started: Session) -> None:
    """One in each memory; a cell that stays flipped counts once, another one counts again."""
    chip = started.chip
    enabled = [chip.ramecc.v[f"cr{i}"] for i in MONITORS]
    assert enabled == [0x38] * 4, "all RAM but the trace's"
    assert memory_lines_of({}) == []
    first, second = data_words(started)[:2]
    for word in (first, literal(started, IN_ITCM), literal(started, IN_AXI)):
        chip.ramecc.flip(word, 1)
    for address in (TABLE + 64, FLASH + 0x40000):
        chip.flash.note_ecc(address, SNECCERR)
    chip.run(chip.seconds(ALL_CODE_S))
    chip.ramecc.repair(first)
    chip.ramecc.flip(second, 1)
    assert memory_lines(started) == ["memory            6 errors corrected"]
    assert chip.resets == ["power_on"]


def expect_halt(session: Session, at: int, address: int) -> None:
    """Expect safe outputs, a reset, and the address in the line of text after it."""
    chip, board = session.chip, session.board
    assert chip.run_until(lambda: chip.resets[-1] == "software", chip.seconds(0.2))
    since = [event.what for event in board.events if event.at > at]
    until = since[: since.index("reset software")]
    assert "enable 0" in until and "fault 1" in until
    assert session.remote.started().reset == "halt"
    line = f"start: halt: memory: uncorrectable error at 0x{address:08X}"
    assert line in session.remote.lines()
    assert board.ticks[-1].words == SAFE
    assert "enable 1" not in [event.what for event in board.events if event.at > at]


@pytest.mark.long
@pytest.mark.parametrize("is_fault", [False, True])
def test_double_error_in_the_cut_halts_with_its_address(ready: Session, is_fault: bool) -> None:
    """Whether the load raises a bus fault too, or the monitor's interrupt alone."""
    chip = ready.chip
    ready.remote.do(START)
    ready.remote.wait_for("engaging", 1.0)
    word = data_words(ready)[0]
    chip.is_fault_of_flips = is_fault
    at = chip.clock.now
    chip.ramecc.flip(word, 2)
    expect_halt(ready, at, word)
    assert chip.ramecc.flipped == {}  # start-up has written it


@pytest.mark.parametrize("function", [IN_ITCM, IN_AXI, None])
def test_double_error_halts_with_its_address(ready: Session, function: str | None) -> None:
    """ITCM and AXI SRAM are corrected in double words, whose address is reported.

    In a table that is read: a bus fault; the start then refuses the table and stays.
    """
    word = TABLE + 96 if function is None else literal(ready, function)
    at = ready.chip.clock.now
    if function is None:
        ready.chip.flash.tear({word})
    else:
        ready.chip.ramecc.flip(word, 2)
    expect_halt(ready, at, word & ~7)
    if function is None:
        assert ready.chip.resets[-1] == "software"
        assert ready.remote.status().table < 0
