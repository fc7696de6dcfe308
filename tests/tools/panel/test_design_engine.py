"""The processes of the previews: the newest change wins, and whatever dies is replaced."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from camtools.base.errors import CamtoolsError
from camtools.panel.design.preview_engine import Engine, PreviewLimits, Seat
from checks.patience import limit_s
from tests.tools.cases.preview_cases import PARTS, text_of

Answer = dict[str, Any]


class Page:
    """A page that waits for answers."""

    def __init__(self, engine: Engine) -> None:
        self.heard: list[Answer] = []
        self._is_new = asyncio.Event()
        self.seat: Seat = engine.seat(self._take)

    def _take(self, answer: Answer) -> None:
        self.heard.append(answer)
        self._is_new.set()

    def ask(self, text: str, height_mm: float | None = None) -> None:
        """Ask for a preview."""
        self.seat.preview(text, str(PARTS), height_mm)

    async def until(self, is_there: Callable[[Answer], bool]) -> Answer:
        """Return the first answer of a kind, and forget all up to it."""
        async with asyncio.timeout(limit_s()):
            while True:
                for i, answer in enumerate(self.heard):
                    if is_there(answer):
                        del self.heard[: i + 1]
                        return answer
                self._is_new.clear()
                await self._is_new.wait()

    async def done(self) -> Answer:
        """Return the last answer of a request."""
        return await self.until(lambda one: one["stage"] in ("done", "lost"))


def acted(limits: PreviewLimits, *acts: Callable[[Engine], Awaitable[None]]) -> None:
    """Act with an engine that is closed afterwards."""

    async def whole() -> None:
        engine = Engine(limits)
        try:
            for act in acts:
                await act(engine)
        finally:
            await engine.close()
        assert not engine._tasks

    asyncio.run(whole())


async def idle(engine: Engine) -> asyncio.subprocess.Process:
    """Return the process of an engine that has one, when it waits."""
    async with asyncio.timeout(limit_s()):
        while not engine._idle:
            await asyncio.sleep(0.01)
    return engine._idle[0].process


async def newest_change_wins(engine: Engine) -> None:
    """Of changes that follow each other quickly the last one alone has a table."""
    page = Page(engine)
    page.ask(text_of("16v240zj"))
    await page.until(lambda one: one["stage"] == "curves")
    for rpm in (601, 602, 603):
        page.ask(text_of("perkins240").replace("rpm = 2500", f"rpm = {rpm}"))
    told = await page.until(lambda one: one["stage"] == "table")
    assert told["asked_rpm"] == 603
    last = await page.until(lambda one: one["stage"] == "done")
    assert not last["is_dropped"]
    assert page.heard == []  # what was overtaken said nothing more


async def waiting_page_is_served_between(engine: Engine) -> None:
    """One page that asks without end does not keep the process for itself."""
    greedy, other = Page(engine), Page(engine)
    greedy.ask(text_of("perkins240"))
    other.ask(text_of("p3g-25"))
    greedy.ask(text_of("perkins240"), 5.0)
    assert (await other.until(lambda one: one["stage"] == "curves"))["kind"] == "polygon"
    await greedy.until(lambda one: one["stage"] == "table")


async def edits_are_done_one_after_the_other(engine: Engine) -> None:
    """None is dropped for a newer one, and one that cannot be done says why."""
    page = Page(engine)
    text = "[process]\nfeed_mm = 0.1 # per turn\n"
    many = [page.seat.edit(text, ["process", "feed_mm"], n) for n in range(5)]
    found = await asyncio.gather(*many)
    assert found == [text.replace("0.1", str(n)) for n in range(5)]
    with pytest.raises(CamtoolsError, match="change it in the text"):
        await page.seat.edit("a = 1\n", ["a", "b"], 1)


async def memory_is_limited_and_nothing_is_written(engine: Engine) -> None:
    """Send hostile parts: each ends as a problem of its own, whatever it asks for."""
    nested = "a = " + "[" * 100_000
    many = text_of("camshaft").replace("z_mm = [0, 3]", "z_mm = [" + "0," * 200_000 + "3]")
    long_name = "[part]\nname = " + '"' + "x" * 900_000 + '"\n'
    page = Page(engine)
    for text in (nested, many, long_name, "\x00", "\ud800", "[part]\nkind = 1\n", "x" * 2**21):
        page.ask(text)
        await page.until(lambda one: one["stage"] in ("problems", "lost"))
        await asyncio.sleep(0)
    page.ask(text_of("perkins240"))
    await page.done()
    limits = Path(f"/proc/{(await idle(engine)).pid}/limits").read_text()
    [line] = [one for one in limits.splitlines() if one.startswith("Max file size")]
    assert line.split()[3:5] == ["0", "0"]


async def process_that_dies_is_replaced(engine: Engine) -> None:
    """Killed while it waits or while it computes: the page is served again."""
    page = Page(engine)
    page.ask(text_of("perkins240"))
    assert (await page.done())["stage"] == "done"
    process = await idle(engine)
    process.kill()
    await process.wait()
    page.ask(text_of("perkins240"), 3.0)
    assert (await page.done())["stage"] == "done"
    page.ask(text_of("16v240zj"))
    await page.until(lambda one: one["stage"] == "curves")
    engine._busy[0].process.kill()
    lost = await page.done()
    assert lost["stage"] == "lost"
    assert "started anew" in lost["problems"][0]["text"]
    page.ask(text_of("perkins240"), 4.0)
    assert (await page.done())["stage"] == "done"


@pytest.mark.long
def test_one_process_serves_every_page() -> None:
    """The newest change wins, pages take turns, no edit is dropped, and what dies is replaced."""
    acts = (newest_change_wins, waiting_page_is_served_between, edits_are_done_one_after_the_other)
    last = (memory_is_limited_and_nothing_is_written, process_that_dies_is_replaced)
    acted(PreviewLimits(workers=1, memory_mb=1024), *acts, *last)


def test_what_takes_too_long_is_given_up() -> None:
    """The page is told, and the next preview comes from another process."""

    async def act(engine: Engine) -> None:
        page = Page(engine)
        page.ask(text_of("16v240zj"))
        lost = await page.done()
        assert lost["stage"] == "lost"
        assert "takes more than 0.4 s" in lost["problems"][0]["text"]

    acted(PreviewLimits(workers=1, time_s=0.4), act)
