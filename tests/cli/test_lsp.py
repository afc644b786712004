"""`robodyn lsp` answers a client over standard streams: findings of what is typed, their fixes, and hovers."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import pytest

pytest.importorskip("pygls")

from helpers.clean_arm import arm
from helpers.command_line import command
from helpers.example_robots import path_of
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient
from pygls.uris import from_fs_path

ROBOTS = Path(__file__).parents[2] / "robots"


class Editor:
    """A client that edits one file after another."""

    def __init__(self, client: LanguageClient) -> None:
        self.client, self.uri, self.number = client, "", 0
        self.told: asyncio.Queue[lsp.PublishDiagnosticsParams] = asyncio.Queue()

        @client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def told(given: lsp.PublishDiagnosticsParams) -> None:
            self.told.put_nowait(given)

    async def open(self, path: Path, text: str) -> list[lsp.Diagnostic]:
        self.uri = from_fs_path(str(path)) or ""
        item = lsp.TextDocumentItem(self.uri, "xml", self.number, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return await self.diagnostics()

    async def change(self, text: str) -> list[lsp.Diagnostic]:
        self.number += 1
        whole = lsp.TextDocumentContentChangeWholeDocument(text)
        version = lsp.VersionedTextDocumentIdentifier(self.number, self.uri)
        self.client.text_document_did_change(lsp.DidChangeTextDocumentParams(version, [whole]))
        return await self.diagnostics()

    async def diagnostics(self) -> list[lsp.Diagnostic]:
        told = await asyncio.wait_for(self.told.get(), 60)
        return list(told.diagnostics) if told.uri == self.uri else await self.diagnostics()

    async def hover(self, text: str, words: str) -> str:
        line = next(k for k, each in enumerate(text.split("\n")) if words in each)
        at = lsp.Position(line, text.split("\n")[line].index(words))
        params = lsp.HoverParams(lsp.TextDocumentIdentifier(self.uri), at)
        found: Any = await self.client.text_document_hover_async(params)
        return "" if found is None else found.contents.value

    async def fixes(self, at: lsp.Range) -> list[lsp.CodeAction]:
        document, context = lsp.TextDocumentIdentifier(self.uri), lsp.CodeActionContext([])
        return await self.client.text_document_code_action_async(lsp.CodeActionParams(document, at, context)) or []


def edit(session: Callable[[Editor], Awaitable[None]]) -> None:
    """Run what an editor does with a server of its own."""

    async def served() -> None:
        client = LanguageClient("editor", "1")
        await client.start_io(*command("lsp"))
        try:
            await client.initialize_async(lsp.InitializeParams(lsp.ClientCapabilities()))
            client.initialized(lsp.InitializedParams())
            await session(Editor(client))
            await client.shutdown_async(None)
        finally:
            client.exit(None)
            await client.stop()

    asyncio.run(served())


def test_files_are_edited_one_after_another(tmp_path: Path) -> None:
    async def session(editor: Editor) -> None:
        await findings_follow_the_text(editor, tmp_path / "arm.urdf")
        await a_fix_is_offered_and_right(editor, tmp_path / "fixed.urdf")
        await hovers_compute(editor, ROBOTS / "scara.urdf")
        await xacro_is_checked_as_it_is_saved(editor, tmp_path / "arm.urdf.xacro")

    edit(session)


async def findings_follow_the_text(editor: Editor, path: Path) -> None:
    """Which need not be saved; at the attribute, in the units of the editor; XML that is cut off is one error."""
    sound = arm()
    wrong = sound.replace("<limit", "<!-- ä 😀 \u2028 --><limit", 1).replace('lower="-2"', 'lower="3"', 1)
    assert await editor.open(path, sound) == []
    (one,) = await editor.change(wrong)
    assert (one.code, one.severity, one.source) == ("RD503", lsp.DiagnosticSeverity.Error, "robodyn")
    units = wrong.split("\n")[one.range.start.line].encode("utf-16-le")
    assert units[2 * one.range.start.character : 2 * one.range.end.character].decode("utf-16-le") == "3"
    (broken,) = await editor.change(wrong[:200])
    assert broken.code == "RD001"
    assert await editor.change(sound) == []


async def a_fix_is_offered_and_right(editor: Editor, path: Path) -> None:
    wrong = arm().replace('axis xyz="0 1 0"', 'axis xyz="0 2 0"', 1)
    (one,) = await editor.open(path, wrong)
    (fix,) = await editor.fixes(one.range)
    assert fix.is_preferred
    assert fix.edit is not None
    ((uri, (change,)),) = (fix.edit.changes or {}).items()
    lines = wrong.split("\n")
    at, line = change.range, lines[change.range.start.line]
    lines[at.start.line] = line[: at.start.character] + change.new_text + line[at.end.character :]
    assert uri == editor.uri
    assert await editor.change("\n".join(lines)) == []


async def hovers_compute(editor: Editor, path: Path) -> None:
    """Scara: what hangs on the elbow, and what holds its slide up."""
    text = path.read_text()
    await editor.open(path, text)
    said = await editor.hover(text, '<joint name="elbow"')
    assert said.startswith("**joint elbow**, at rest with all joints at zero\n\nthe drive holds 0 N m")
    assert "the bearings carry " in said
    assert (await editor.hover(text, '<link name="')).startswith("**link ")


async def xacro_is_checked_as_it_is_saved(editor: Editor, path: Path) -> None:
    text = arm().replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"', 1)
    text = text.replace('lower="-2"', 'lower="${1 + 2}"', 1)
    path.write_text(text)
    (one,) = await editor.open(path, text)
    assert one.code == "RD503"
    assert text.split("\n")[one.range.start.line][one.range.start.character :].startswith("${1 + 2}")
    path.write_text(text + "<")
    (one,) = await editor.change(text + "<")
    assert "xacro cannot expand it" in one.message


@pytest.mark.slow
def test_a_change_in_a_robot_with_meshes_is_answered_while_one_types() -> None:
    """Of twenty changes of masses the median takes less than 300 ms, a third of it on an idle machine."""
    path, waits = path_of("ur5_robot"), list[float]()
    text = path.read_text()

    async def session(editor: Editor) -> None:
        assert await editor.open(path, text)
        for k in range(20):
            start = perf_counter()
            assert await editor.change(
                re.sub(r'<mass value="[^"]*"', f'<mass value="{1 + k / 7}"', text, count=1 + k % 5)
            )
            waits.append(perf_counter() - start)

    edit(session)
    assert median(waits) < 0.3
