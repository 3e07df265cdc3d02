# SPDX-License-Identifier: GPL-3.0-or-later
"""The language server of inputs, by pygls, on standard input and output."""

from ..base.core import version
from ..base.errors import library_required
from .language import hover, offers, problems

with library_required("the language server needs pygls: pip install 'sitedda[editor]'"):
    from lsprotocol import types
    from pygls.lsp.server import LanguageServer
    from pygls.uris import to_fs_path

_KINDS = {
    "group": types.CompletionItemKind.Module,
    "variable": types.CompletionItemKind.Property,
    "value": types.CompletionItemKind.Value,
}


def language_server() -> LanguageServer:
    """Return a language server; its method `start_io` serves an editor until the editor ends."""
    server = LanguageServer("sitedda", version())

    def publish(uri: str) -> None:
        text = server.workspace.get_text_document(uri).source
        server.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(uri, [_make_diagnostic(problem) for problem in
                                                 problems(text, to_fs_path(uri) or "input.nml")])
        )  # fmt: skip

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def changed(params) -> None:
        publish(params.text_document.uri)

    @server.feature(
        types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=["&", "'", "="])
    )
    def complete(params: types.CompletionParams) -> list[types.CompletionItem]:
        text = server.workspace.get_text_document(params.text_document.uri).source
        results = offers(text, params.position.line, params.position.character)
        return [types.CompletionItem(offer.word, kind=_KINDS[offer.kind], detail=offer.meaning)
                for offer in results]  # fmt: skip

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    def describe(params: types.HoverParams) -> types.Hover | None:
        text = server.workspace.get_text_document(params.text_document.uri).source
        markdown = hover(text, params.position.line, params.position.character)
        content = types.MarkupContent(types.MarkupKind.Markdown, markdown)
        return types.Hover(content) if markdown else None

    return server


def _make_diagnostic(problem) -> types.Diagnostic:
    """Convert a `Problem` to a diagnostic of the language server protocol."""
    start = types.Position(problem.line, problem.start)
    end = types.Position(problem.line, problem.end)
    return types.Diagnostic(types.Range(start, end), problem.message,
                            severity=types.DiagnosticSeverity.Error, source="sitedda")  # fmt: skip
