"""The page /design of the panel: a part file as text and as a form, its preview, and its cut."""

import asyncio
import time
from functools import partial
from typing import Any

from nicegui import background_tasks, events, ui

from camtools.base.errors import CamtoolsError
from camtools.base.files import utf8_text
from camtools.panel.context import AppContext
from camtools.panel.design.part_library import EXAMPLE, FILE_ENDS, OWN, Draft
from camtools.panel.design_service import DesignService, design_service_of
from camtools.panel.orders.commander import Visitor
from camtools.panel.page_frame import framed
from camtools.panel.pages.design_cut import CutView
from camtools.panel.pages.design_form import FormView
from camtools.panel.pages.design_preview import PreviewView
from camtools.panel.pieces import Showing, confirmed, file_button, refusals_shown
from camtools.panel.runs.store import RunOptions
from camtools.part.schema import Key

STYLE = '<link rel="stylesheet" href="panel/design.css">'
_FIRST = "perkins240"
# CodeMirror's own elements have no name, and its frame scrolls but takes no focus.
_NAME_EDITOR = """(async () => {
    const frame = getElement(%d);
    await frame.editorPromise;
    frame.editor.contentDOM.setAttribute("aria-label", "text of the part file");
    frame.editor.scrollDOM.tabIndex = 0;
})()"""
_MAX_UPLOAD_BYTES = 20_000_000
_MOST_PROBLEMS = 20
_BAD_LINE = "is-bad-line"
_REPLACED = "This overwrites the present content."


class DesignPage:
    """What one visitor works on."""

    def __init__(self, designs: DesignService, visitor: Visitor) -> None:
        self._designs, self._visitor = designs, visitor
        self._source = EXAMPLE
        self._draft = Draft("")
        self._height_mm: float | None = None
        self._changes = asyncio.Lock()
        self._showing = Showing()
        self._seat = designs.engine.seat(self._take)
        self.close = self._seat.close
        with ui.column().classes("full-width") as self._body:
            self._bar()
            with ui.element("div").classes("design-columns"):
                with ui.column().classes("design-left"):
                    self._editors()
                with ui.column().classes("design-right"):
                    self._preview = PreviewView(self._height_chosen)
            with ui.card().classes("full-width"):
                self._cut = CutView(designs, visitor, self._cut_this)
        self._open(EXAMPLE, _FIRST)

    def _bar(self) -> None:
        with ui.row().classes("items-center q-gutter-sm full-width"):
            sources, listed = {EXAMPLE: "examples", OWN: "my parts"}, self._list_parts
            self._sources = ui.select(sources, value=EXAMPLE, label="from", on_change=listed)
            self._parts = ui.select([], label="part", on_change=self._part_chosen)
            self._name = ui.input("save as")
            fields = {"source": self._sources, "part": self._parts, "save-name": self._name}
            for name, field in fields.items():
                field.props(f"dense outlined options-dense data-testid={name}").classes("bar-field")
            ui.button("Save", icon="save", on_click=self._save).props("data-testid=save")
            for name in ("undo", "redo"):
                step = ui.button(icon=name, on_click=partial(self._step, name))
                step.props(f'aria-label="{name}" data-testid={name}')
            download = ui.button("Download", icon="download", on_click=self._download)
            download.props("flat data-testid=download")
            with ui.row():
                take = self._upload_later
                file_button("Upload", ".toml,.csv,.dxf", _MAX_UPLOAD_BYTES, "part-upload", take)
        self._list_parts()

    def _editors(self) -> None:
        with ui.tabs().props("dense align=left") as tabs:
            text = ui.tab("text").props("data-testid=tab-text")
            form = ui.tab("form").props("data-testid=tab-form")
        with ui.tab_panels(tabs, value=text, animated=False, keep_alive=True).classes("full-width"):
            with ui.tab_panel(text).classes("q-pa-none"):
                self._editor = ui.codemirror(
                    language="TOML", theme="vscodeLight", on_change=self._typed
                )
                self._editor.props('aria-label="text of the part file" data-testid=editor')
                self._editor.classes("part-editor")
                name = _NAME_EDITOR % self._editor.id
                ui.context.client.on_connect(lambda client: client.run_javascript(name))
            with ui.tab_panel(form).classes("q-pa-sm form-panel"):
                self._form = FormView(self._form_changed)
        self._problems = ui.column().classes("full-width q-gutter-none")
        self._problems.props("role=status data-testid=problems")

    def _list_parts(self) -> None:
        library, source = self._designs.library, str(self._sources.value)
        names = library.examples() if source == EXAMPLE else library.own()
        keeps = self._parts.value if self._parts.value in names else None
        with self._showing:
            self._parts.set_options(names, value=keeps)

    def _part_chosen(self) -> None:
        if not self._showing.is_on and self._parts.value:
            self._open(str(self._sources.value), str(self._parts.value))

    def _open(self, source: str, name: str) -> None:
        with refusals_shown():
            text = self._designs.library.read(source, name)
            self._source, self._height_mm = source, None
            with self._showing:
                self._parts.value = self._name.value = name
            if self._draft.text:
                self._draft.change(text, time.monotonic(), is_step=True)
            else:
                self._draft = Draft(text)
            self._show_text()

    def _show_text(self) -> None:
        """Show the draft's text in the editor, and ask for its preview."""
        with self._showing:
            self._editor.value = self._draft.text
        self._ask()

    def _ask(self) -> None:
        folder = str(self._designs.library.folder(self._source))
        self._seat.preview(self._draft.text, folder, self._height_mm)

    def _typed(self, event: events.ValueChangeEventArguments[str]) -> None:
        if self._showing.is_on:
            return
        self._draft.change(event.value or "", time.monotonic())
        self._ask()

    async def _form_changed_now(self, key: Key, value: Any) -> None:  # noqa: ANN401
        async with self._changes:  # each change begins with the text of the one before
            before = self._draft.text
            try:
                text = await self._seat.edit(before, list(key.path), value)
            except CamtoolsError as error:
                self._show_problems([{"field": "", "line": None, "text": t} for t in error.lines])
                return
            if self._draft.text == before:
                self._draft.change(text, time.monotonic())
                self._show_text()

    def _form_changed(self, key: Key, value: Any) -> None:  # noqa: ANN401 (of TOML)
        background_tasks.create(self._form_changed_now(key, value))

    def _step(self, name: str) -> None:
        getattr(self._draft, name)()
        self._show_text()

    def _height_chosen(self, height_mm: float) -> None:
        self._height_mm = height_mm
        self._ask()

    def _take(self, answer: dict[str, Any]) -> None:
        stage = answer["stage"]
        if stage == "form":
            self._form.show(answer["kind"], answer["tree"])
        if stage in ("problems", "table", "lost"):
            self._show_problems(answer.get("problems", []))
        self._preview.take(answer)

    def _show_problems(self, problems: list[dict[str, Any]]) -> None:
        """Show what is wrong below the text, in its lines, and beside the fields."""
        self._problems.clear()
        lines: set[int] = set()
        with self._problems:
            for problem in problems[:_MOST_PROBLEMS]:
                where = f"line {problem['line']}: " if problem["line"] else ""
                ui.label(where + problem["text"]).classes("problem")
                if problem["line"]:
                    lines.add(int(problem["line"]))
        n_lines = self._draft.text.count("\n") + 1
        there = [line for line in sorted(lines) if line <= n_lines]
        marked = [{"kind": "line", "line": line, "class": _BAD_LINE} for line in there]
        # As a call: an update of the element would bring the server's text along, which is older
        # than what is being typed.
        self._editor.run_method("setDecorations", marked)
        self._form.problems(problems)

    async def _save(self) -> None:
        """Save the text under a name; a part that is there is replaced when that is confirmed."""
        library, name = self._designs.library, str(self._name.value or "").strip()
        with refusals_shown():
            replaces = library.has(name)
            if replaces and not await _may_replace(f"part {name}"):
                return
            if self._source == EXAMPLE:  # the copy is to find the files that the example names
                self._designs.bring_files(self._draft.text)
            library.save(name, self._draft.text, replaces=replaces)
            self._show_saved(name)

    def _show_saved(self, name: str) -> None:
        self._designs.note(self._visitor, "save", {"name": name}, "saved")
        self._source = OWN
        with self._showing:
            self._sources.value = OWN
            self._list_parts()
        with self._showing:
            self._parts.value = name
        ui.notify(f"{name} is saved among my parts", type="positive")
        self._ask()

    def _download(self) -> None:
        name = str(self._name.value or "part")
        ui.download.content(self._draft.text.encode("utf-8"), f"{name}.toml")

    def _upload_later(self, data: bytes, file: str) -> None:
        background_tasks.create(self._uploaded(data, file))

    async def _uploaded(self, data: bytes, file: str) -> None:
        """Keep a file that somebody brings, and open it when it is a part."""
        with self._body, refusals_shown():
            if await self._keep(data, file):
                self._designs.note(self._visitor, "upload", {"file": file}, "kept")
                self._show_kept(file)

    async def _keep(self, data: bytes, file: str) -> bool:
        library, name = self._designs.library, file.removesuffix(".toml")
        is_named = file.endswith(FILE_ENDS)  # by a part
        is_there = (library.folder(OWN) / file).exists() if is_named else library.has(name)
        if is_there and not await _may_replace(f"file {file[:60]}" if is_named else f"part {name}"):
            return False
        if is_named:
            library.save_file(file, data, replaces=is_there)
        else:
            library.save(name, utf8_text(data, file), replaces=is_there)
        return True

    def _show_kept(self, file: str) -> None:
        if not file.endswith(FILE_ENDS):
            self._sources.value = OWN
            self._list_parts()
            self._open(OWN, file.removesuffix(".toml"))
        else:
            use = f"{file[-3:]} = {file!r}"
            ui.notify(f"{file} is saved; use it in a part with {use}", type="positive")
            self._ask()

    async def _cut_this(self, options: RunOptions) -> str:
        return await self._designs.cut(self._draft.text, self._source, options)


async def _may_replace(what: str) -> bool:
    return await confirmed(f"Replace the {what}?", _REPLACED, "Replace")


def add(context: AppContext) -> None:
    """Register the page."""
    designs = design_service_of(context)

    @ui.page("/design", title="camturn: design")
    def design() -> None:
        with framed(context, "/design") as visitor:
            ui.add_head_html(STYLE)
            page = DesignPage(designs, visitor)
        ui.context.client.on_delete(page.close)
