"""`robodyn lsp`: findings while one types, fixes and computed numbers, for editors by the Language Server Protocol."""

from __future__ import annotations

import asyncio
import re
from bisect import bisect_right
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import click

from robodyn.checks.check import check_tasks, found_in, tasks_for
from robodyn.checks.context import Context
from robodyn.checks.fixes import Made, healing, unproven
from robodyn.checks.groups import places
from robodyn.checks.rule import Finding, Severity
from robodyn.errors import InputError, RobodynError
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.edits import edited
from robodyn.robot.urdf.sources import is_xacro
from robodyn.support.extras import need
from robodyn.support.input_file import read_input
from robodyn.support.wording import figure

if TYPE_CHECKING:
    from lsprotocol import types as lsp
    from pygls.lsp.server import LanguageServer

_PAUSE = 0.03
"""Seconds without a further change after which a text is checked."""
_LEVELS = {Severity.ERROR: 1, Severity.WARNING: 2, Severity.NOTE: 3}
_DECLARED = re.compile(r"""<\?xml[^>]*encoding\s*=\s*["'](iso-8859-1|us-ascii|windows-1252)["']""", re.IGNORECASE)


@dataclass
class Text:
    """A text as it is in the editor, and in the bytes of its encoding, of which findings tell; what was found in it, by
    place."""

    path: str
    source: str
    found: tuple[Finding, ...] = ()

    @cached_property
    def codec(self) -> str:
        declared = _DECLARED.match(self.source)
        return "utf-8" if declared is None else declared[1].lower()

    @cached_property
    def data(self) -> bytes:
        return self.source.encode(self.codec, "replace")

    @cached_property
    def lines(self) -> list[str]:
        return [f"{line}\n" for line in self.source.split("\n")]

    def place(self, offset: int) -> tuple[int, int]:
        """Return line and character, from 0, of a byte."""
        before = self.data[:offset].decode(self.codec, "replace")
        return before.count("\n"), len(before) - before.rfind("\n") - 1

    def offset(self, line: int, character: int) -> int:
        """Return the byte at a line and character, from 0."""
        before = "".join([*self.lines[:line], *(each[:character] for each in self.lines[line : line + 1])])
        return len(before.encode(self.codec, "replace"))

    def check(self, data: bytes) -> tuple[Finding, ...]:
        """Return every place of what is found in bytes that stand in this one's place."""
        (task,) = tasks_for([self.path])
        return places(found_in(data, task.options, self.path).shown)


def check_text(text: Text) -> dict[str, list[Finding] | InputError]:
    """Return by file what a check finds: of a URDF in the text as it is typed, of a xacro file in what is saved."""
    try:
        if is_xacro(text.path):
            checked = check_tasks(tasks_for([text.path]))
            for unread in checked.unread:
                raise unread.error
            every = places(checked.findings)
        else:
            every = text.check(text.data)
    except InputError as error:
        return {text.path: error}
    text.found = tuple(one for one in every if one.file == text.path)
    others = dict.fromkeys(one.file for one in every if one.file != text.path)
    return {text.path: list(text.found), **{file: [one for one in every if one.file == file] for file in others}}


def hover_text(text: Text, offset: int) -> str | None:
    """Return in Markdown what is computed of the link or joint at a byte of a URDF; None without one."""
    context = Context(read(text.data, text.path))
    parts = [] if context.reading.robot is None else context.reading.root.children
    k = bisect_right(parts, offset, key=lambda part: part.start) - 1
    if k < 0 or parts[k].tag not in ("link", "joint") or is_xacro(text.path):
        return None
    name = parts[k].get("name") or ""
    try:
        return _of_link(context, name) if parts[k].tag == "link" else _of_joint(context, name)
    except RobodynError as error:
        return f"**{parts[k].tag} {name}**: {error}"


def _of_link(context: Context, name: str) -> str | None:
    from robodyn.robot.masses.declared import link_inertia
    from robodyn.robot.masses.shapes import link_from_shapes

    description = context.description_or_none
    if description is None:
        return None
    lines = [f"**link {name}**"]
    with suppress(InputError):  # without <inertial>
        given = link_inertia(description, name)
        lines += [f"declared: {_body(given.body)}", *(f"but {fault}" for fault in given.faults)]
    for kind in ("visual", "collision"):
        with suppress(RobodynError):  # without such shapes, or their files
            shapes = link_from_shapes(description, name, kind)
            lines.append(f"of its {kind} shapes, {shapes.weight}: {_body(shapes.body)}")
    return "\n\n".join(lines)


def _body(body: Any) -> str:
    centre = ", ".join(figure(float(x), 4) for x in body.com)
    moments = ", ".join(figure(float(x), 4) for x in body.principal.moments)
    return f"{figure(float(body.mass), 4)} kg at ({centre}) m, principal moments {moments} kg m²"


def _of_joint(context: Context, name: str) -> str | None:
    import numpy as np

    from robodyn.equations.free_body.bodies import free_bodies

    model = context.model_or_none
    if model is None:
        return None
    cut = next((row for row in free_bodies(model, 0.0).joints if row.name == name), None)
    if cut is None:
        return f"**joint {name}** joins links to one body"
    lines = [f"**joint {name}**, at rest with all joints at zero"]
    if cut.drive is not None:
        effort = next(body.joint.effort for body in model.bodies if body.joint.name == name)
        share = f", {figure(100 * abs(cut.drive) / effort)} % of its effort" if effort else ""
        lines.append(f"the drive holds {figure(cut.drive)} {'N' if cut.kind == 'prismatic' else 'N m'}{share}")
    force, moment = (figure(float(np.linalg.norm(one))) for one in (cut.force, cut.moment))
    return "\n\n".join([*lines, f"the bearings carry {force} N and {moment} N m"])


class Session:
    """What the editor has open, and what was said about it."""

    def __init__(self, server: LanguageServer) -> None:
        self.server = server
        self.texts: dict[str, Text] = {}
        self.told: dict[str, set[str]] = {}
        self.turn = asyncio.Lock()

    def text(self, uri: str) -> Text:
        document = self.server.workspace.get_text_document(uri)
        self.texts[uri] = Text(document.path, document.source)
        return self.texts[uri]

    async def check(self, uri: str) -> None:
        """Check a text once nothing has changed for a moment, and tell the editor."""
        text = self.text(uri)
        await asyncio.sleep(_PAUSE)
        async with self.turn:
            if self.texts.get(uri) is not text:
                return
            files = await asyncio.to_thread(check_text, text)
        if self.texts.get(uri) is text:
            self.tell(uri, text, files)

    def tell(self, uri: str, text: Text, files: dict[str, list[Finding] | InputError]) -> None:
        from lsprotocol import types as lsp
        from pygls.uris import from_fs_path

        uris = {uri if file == text.path else from_fs_path(file) or file: file for file in files}
        for gone in self.told.get(uri, set()) - set(uris):
            self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(gone, []))
        self.told[uri] = set(uris)
        for place, file in uris.items():
            found, of = files[file], text
            if isinstance(found, InputError):
                line = max((found.line or 1) - 1, 0)
                at = lsp.Range(lsp.Position(line, 0), lsp.Position(line + 1, 0))
                diagnostics = [lsp.Diagnostic(at, found.sentence, lsp.DiagnosticSeverity.Error, source="robodyn")]
            else:
                if file != text.path:
                    of = Text(file, read_input(file).decode("utf-8", "replace"))
                diagnostics = [self.diagnostic(of, one) for one in found]
            self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(place, diagnostics))

    def diagnostic(self, text: Text, finding: Finding) -> lsp.Diagnostic:
        from lsprotocol import types as lsp

        message = "\n".join(filter(None, (finding.message, finding.cause, finding.remedy)))
        return lsp.Diagnostic(
            self.range(text, finding.start, finding.end),
            message,
            lsp.DiagnosticSeverity(_LEVELS[finding.severity]),
            code=finding.code,
            source="robodyn",
        )

    def range(self, text: Text, start: int, end: int) -> lsp.Range:
        """Return bytes [start, end) in the units of the editor."""
        from lsprotocol import types as lsp

        points = lsp.Range(*(lsp.Position(*text.place(offset)) for offset in (start, end)))
        return self.server.workspace.position_codec.range_to_client_units(text.lines, points)

    def offset(self, text: Text, at: lsp.Position) -> int:
        """Return the byte at a position in the units of the editor."""
        point = self.server.workspace.position_codec.position_from_client_units(text.lines, at)
        return text.offset(point.line, point.character)

    def fixes(self, uri: str, at: lsp.Range) -> list[lsp.CodeAction]:
        """Return the fixes that `robodyn check --fix --unsafe-fixes` makes of the findings in a range."""
        from lsprotocol import types as lsp

        text, actions = self.texts[uri], []
        start, end = self.offset(text, at.start), self.offset(text, at.end)
        for finding in text.found:
            fix = finding.fix
            if fix is None or finding.end < start or finding.start > end:
                continue
            made = [Made(finding, fix)]
            if not fix.safe:
                made, _ = healing(text.data, (finding,), text.check, text.codec)
            elif unproven(text.data, edited(text.data, fix.edits, text.codec)) is not None:
                continue
            if not made:
                continue
            edits = [lsp.TextEdit(self.range(text, one.start, one.end), one.text) for one in fix.edits]
            actions.append(
                lsp.CodeAction(
                    f"{fix.what} ({made[0].effect})",
                    kind=lsp.CodeActionKind.QuickFix,
                    diagnostics=[self.diagnostic(text, finding)],
                    is_preferred=fix.safe,
                    edit=lsp.WorkspaceEdit(changes={uri: edits}),
                )
            )
        return actions


def served() -> LanguageServer:
    """Return the server with what it answers to."""
    from importlib.metadata import version

    from lsprotocol import types as lsp
    from pygls.lsp.server import LanguageServer

    server = LanguageServer("robodyn", version("robodyn"))
    session = Session(server)

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    async def opened(given: lsp.DidOpenTextDocumentParams) -> None:
        await session.check(given.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(given: lsp.DidChangeTextDocumentParams) -> None:
        await session.check(given.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    async def saved(given: lsp.DidSaveTextDocumentParams) -> None:
        await session.check(given.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(given: lsp.DidCloseTextDocumentParams) -> None:
        session.texts.pop(given.text_document.uri, None)
        for told in session.told.pop(given.text_document.uri, set()):
            server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(told, []))

    @server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]))
    async def fixes(given: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        return await asyncio.to_thread(session.fixes, given.text_document.uri, given.range)

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    async def hover(given: lsp.HoverParams) -> lsp.Hover | None:
        text = session.texts[given.text_document.uri]
        said = await asyncio.to_thread(hover_text, text, session.offset(text, given.position))
        return None if said is None else lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, said))

    return server


@click.command("lsp", short_help="Serve editors: findings while one types, fixes, computed numbers.")
def command() -> None:
    """Serve an editor on standard input and output by the Language Server Protocol: what `robodyn check` finds while a
    URDF is typed, or when a xacro file is saved; its fixes; and, where the pointer rests, the inertia of a link,
    declared and of its shapes, and what a joint carries at rest.

    \b
    Example:
      robodyn lsp
    """
    need("language servers", "pygls")
    served().start_io()
