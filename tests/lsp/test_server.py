"""The server process, as editors use it over stdin and stdout."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from tests.language_servers import PATIENCE, Editor, Refused
from tests.lsp.helpers import SCENARIO

pytestmark = pytest.mark.asyncio(loop_scope="module")

ERROR = 1
START = {"line": 0, "character": 0}


async def test_diagnostics_follow_the_text(editor: Editor) -> None:
    assert await editor.shown("a.osc", "struct a\n") == []
    version = editor.change("a.osc", "struct a:\n    x: nothing\n")
    [found] = await editor.diagnostics("a.osc", version)
    assert (found["severity"], found["range"]["start"]) == (ERROR, {"line": 1, "character": 7})
    assert found["code"].startswith("E02")
    version = editor.change("a.osc", "struct a:\n    x: int = 1\n")
    assert await editor.diagnostics("a.osc", version) == []
    editor.close("a.osc")
    assert await editor.diagnostics("a.osc") == []


async def test_only_the_last_of_quick_changes_is_checked(editor: Editor) -> None:
    await editor.shown("quick.osc", "struct a\n")
    for number in range(20):
        editor.change("quick.osc", f"struct a:\n    x{number}: nothing\n")
    version = editor.change("quick.osc", "struct b\n")
    async with asyncio.timeout(PATIENCE):
        found = await editor.published.get()
    assert (found["version"], found["diagnostics"]) == (version, [])
    editor.close("quick.osc")


async def test_changes_of_an_imported_text_update_importing_files(editor: Editor) -> None:
    await editor.shown("imported.osc", "struct box\n")
    assert await editor.shown("importer.osc", 'import "imported.osc"\nstruct s:\n    x: box\n') == []
    editor.change("imported.osc", "struct other\n")
    assert len(await editor.diagnostics("importer.osc")) == 1
    editor.close("imported.osc")
    [found] = await editor.diagnostics("importer.osc")
    assert "imported.osc" in found["message"]
    editor.close("importer.osc")


async def test_all_requests_have_answers(editor: Editor) -> None:
    text, document = SCENARIO, {"textDocument": {"uri": editor.uri("all.osc")}}
    await editor.shown("all.osc", text)
    found = await editor.ask_at("textDocument/hover", "all.osc", text, "60|kph")
    assert "16.67 m/s" in found["contents"]["value"]
    found = await editor.ask_at("textDocument/definition", "all.osc", text, "limit: sp|eed")
    assert found["uri"].endswith("types.osc")
    found = await editor.ask_at("textDocument/completion", "all.osc", text, "            crane.|lift")
    assert [item["label"] for item in found] == ["lift"]
    found = await editor.ask_at("textDocument/signatureHelp", "all.osc", text, "crane.lift(|what")
    assert found["signatures"][0]["label"].startswith("crane.lift(")
    found = await editor.ask_at("textDocument/documentHighlight", "all.osc", text, "event g|o")
    assert len(found) == 3
    context = {"includeDeclaration": False}
    found = await editor.ask_at("textDocument/references", "all.osc", text, "struct b|ox", context=context)
    assert [text.split("\n")[place["range"]["start"]["line"]].strip() for place in found] == [
        "what: box",
        "crate: box",
    ]
    found = await editor.ask("textDocument/documentSymbol", document)
    names = {symbol["name"]: [inner["name"] for inner in symbol["children"]] for symbol in found}
    assert names["main"] == ["robot", "crane", "limit", "crate", "go", "do"]
    found = await editor.ask("textDocument/foldingRange", document)
    assert any(fold.get("kind") == "comment" for fold in found)
    found = await editor.ask("workspace/symbol", {"query": "cran"})
    assert {symbol["name"] for symbol in found} == {"crane"}
    editor.close("all.osc")


FAMILY = """struct base:
    def gain() -> int is expression 1
struct derived inherits base:
    def gain() -> int is only expression 2
struct unrelated:
    def gain() -> int is expression 3
scenario main:
    a: base
    b: derived
    n: int = a.gain() + b.gain()
"""


async def test_references_include_all_overriding_members(editor: Editor) -> None:
    await editor.shown("family.osc", FAMILY)

    async def lines(request: str, place: str, **rest: object) -> list[int]:
        found = await editor.ask_at(f"textDocument/{request}", "family.osc", FAMILY, place, **rest)
        return [each["range"]["start"]["line"] for each in found]

    for place in ("def ga|in() -> int is expression 1", "def ga|in() -> int is only", "a.ga|in()", "b.ga|in()"):
        assert await lines("documentHighlight", place) == [1, 3, 9, 9]
        assert await lines("references", place, context={"includeDeclaration": True}) == [1, 3, 9, 9]
        assert await lines("references", place, context={"includeDeclaration": False}) == [9, 9]
    assert await lines("documentHighlight", "def ga|in() -> int is expression 3") == [5]
    editor.close("family.osc")


async def test_a_rename_changes_all_files_of_the_workspace(editor: Editor) -> None:
    (editor.folder / "uses.osc").write_text('import "declares.osc"\nstruct s:\n    x: box\n', encoding="utf-8")
    (editor.folder / "declares.osc").write_text("struct box\n", encoding="utf-8")
    text = "# Not saved yet.\nstruct box\n"
    await editor.shown("declares.osc", text)
    found = await editor.ask_at("textDocument/prepareRename", "declares.osc", text, "bo|x")
    assert found["start"] == {"line": 1, "character": 7}
    found = await editor.ask_at("textDocument/rename", "declares.osc", text, "bo|x", newName="case")
    assert {uri: [edit["range"]["start"] for edit in edits] for uri, edits in found["changes"].items()} == {
        editor.uri("declares.osc"): [{"line": 1, "character": 7}],
        editor.uri("uses.osc"): [{"line": 2, "character": 7}],
    }
    with pytest.raises(Refused, match="invalid identifier"):
        await editor.ask_at("textDocument/rename", "declares.osc", text, "bo|x", newName="3")
    editor.close("declares.osc")


async def test_formatting_changes_the_layout_only(editor: Editor) -> None:
    options = {"tabSize": 4, "insertSpaces": True}
    request = {"textDocument": {"uri": editor.uri("format.osc")}, "options": options}
    await editor.shown("format.osc", "struct  a :\n   x:int=1\n")
    [edit] = await editor.ask("textDocument/formatting", request)
    assert edit["newText"] == "struct a:\n    x: int = 1\n"
    editor.change("format.osc", edit["newText"])
    assert await editor.ask("textDocument/formatting", request) == []
    editor.change("format.osc", "struct (\n")
    with pytest.raises(Refused, match="errors"):
        await editor.ask("textDocument/formatting", request)
    editor.close("format.osc")


async def test_suspicious_code_is_marked_and_fixed(editor: Editor) -> None:
    text = "import osc.types\nimport osc.helpers\n\nscenario main:\n    do wait elapsed(1s)\n"
    [found] = await editor.shown("suspicious.osc", text)
    assert (found["code"], found["severity"], found["tags"]) == ("E0704", 2, [1])
    where = {"textDocument": {"uri": editor.uri("suspicious.osc")}, "context": {"diagnostics": [found]}}
    [action] = await editor.ask("textDocument/codeAction", {**where, "range": found["range"]})
    [edit] = action["edit"]["changes"][editor.uri("suspicious.osc")]
    assert edit["newText"] == ""
    assert edit["range"] == {"start": {"line": 1, "character": 0}, "end": {"line": 2, "character": 0}}
    elsewhere = {"start": {"line": 3, "character": 0}, "end": {"line": 3, "character": 0}}
    assert await editor.ask("textDocument/codeAction", {**where, "range": elsewhere}) == []
    editor.close("suspicious.osc")


async def test_a_new_document_needs_no_file(editor: Editor) -> None:
    document = {"uri": "untitled:Untitled-1", "languageId": "osc", "version": 1, "text": "struct a:\n    x: no\n"}
    editor.notify("textDocument/didOpen", {"textDocument": document})
    async with asyncio.timeout(PATIENCE):
        while (found := await editor.published.get())["uri"] != document["uri"]:
            pass
    assert len(found["diagnostics"]) == 1
    editor.notify("textDocument/didClose", {"textDocument": {"uri": document["uri"]}})


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        (
            "textDocument/hover",
            {"textDocument": {"uri": "file:///a.osc"}, "position": {"line": 0, "character": 0}},
        ),
        ("textDocument/hover", {"textDocument": {"uri": "git:/a.osc"}, "position": START}),
        ("textDocument/hover", {"textDocument": {"uri": "http://[x"}, "position": START}),
        ("textDocument/hover", {"position": 3}),
        ("textDocument/completion", [1, 2]),
        ("textDocument/documentSymbol", {"textDocument": {"uri": 3}}),
        ("seoro/unknown", {}),
    ],
)
async def test_invalid_requests_are_refused(editor: Editor, method: str, parameters: Any) -> None:
    with pytest.raises(Refused):
        await editor.ask(method, parameters)
    await lives(editor)


async def test_invalid_notifications_are_ignored(editor: Editor) -> None:
    editor._versions["never-opened.osc"] = 1
    editor.change("never-opened.osc", "")
    editor.close("never-opened.osc")
    editor.notify("textDocument/didOpen", {"wrong": True})
    editor.notify("seoro/unknown", {})
    editor.send({"neither": "fish nor fowl"})
    editor.send("a text")
    editor.send({"jsonrpc": "2.0", "id": [], "method": 3})
    assert editor.process.stdin is not None
    editor.process.stdin.write(b"Content-Length: 9\r\n\r\nnot json!")
    await lives(editor)


async def lives(editor: Editor) -> None:
    """Assert that the server still answers."""
    await editor.shown("lives.osc", "struct a\n")
    far = {"textDocument": {"uri": editor.uri("lives.osc")}, "position": {"line": 999, "character": 999}}
    assert await editor.ask("textDocument/hover", far) is None
    editor.close("lives.osc")


async def test_deleted_files_are_reported(editor: Editor) -> None:
    path = editor.folder / "vanishing.osc"
    path.write_text("struct a\n", encoding="utf-8")
    assert await editor.shown("stays.osc", 'import "vanishing.osc"\n') == []
    path.unlink()
    editor.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": path.as_uri(), "type": 3}]})
    assert len(await editor.diagnostics("stays.osc")) == 1
    editor.close("stays.osc")


async def test_the_server_ends_on_request(tmp_path: Path) -> None:
    editor = Editor(tmp_path)
    await editor.start()
    editor.open("a.osc", SCENARIO)
    assert await editor.stop() == 0


async def test_the_server_ends_with_the_editor(tmp_path: Path) -> None:
    editor = Editor(tmp_path)
    await editor.start()
    editor.open("a.osc", SCENARIO)
    assert editor.process.stdin is not None
    editor.process.stdin.close()
    assert await editor.wait() == 0


async def test_invalid_messages_are_answered_and_skipped(editor: Editor) -> None:
    for header in (b"Content-Length: 99999999999999", b"Content-Length: many", b"Content-Type: text"):
        editor.send_bytes(header + b"\r\n\r\n{}")
        assert (await editor.ask("workspace/symbol", {"query": "nothing"})) in ([], None)
        async with asyncio.timeout(PATIENCE):
            assert (await editor.refusals.get())["message"].startswith("skipped a message")


@pytest.mark.more
async def test_a_new_name_that_is_in_use_is_refused(editor: Editor) -> None:
    text = "actor bot\naction bot.trip\naction bot.go\n"
    await editor.shown("rename.osc", text)
    with pytest.raises(Refused, match=r"`go` is in use: duplicate action `bot.go`"):
        await editor.ask_at("textDocument/rename", "rename.osc", text, "tr|ip", newName="go")
    found = await editor.ask_at("textDocument/rename", "rename.osc", text, "tr|ip", newName="ride")
    assert [edit["newText"] for edit in found["changes"][editor.uri("rename.osc")]] == ["ride"]
    editor.close("rename.osc")
