"""Diagnostics as editors show them."""

from pathlib import Path

from lsprotocol.types import DiagnosticSeverity
from pygls.workspace import PositionCodec

from seoro.lsp.analysis import analyse
from seoro.lsp.documents import Documents
from seoro.lsp.positions import Positions
from seoro.lsp.reports import reports


def lines_and_messages(documents: Documents, path: Path, *others: Path) -> list[tuple[int, str]]:
    """Return lines and messages of the diagnostics of a document."""
    found = [analyse(each, documents.texts) for each in (path, *others)]
    shown = reports(found[0], found[1:], documents, Positions(PositionCodec()))
    return [(one.range.start.line, one.message) for one in shown]


def opened(documents: Documents, path: Path, text: str) -> Path:
    document = documents.put(path.as_uri(), 1, text)
    assert document is not None
    return document.path


def test_diagnostics_have_help_code_and_related_places(tmp_path: Path) -> None:
    documents = Documents()
    path = opened(documents, tmp_path / "a.osc", "struct a\nstruct a\nstruct b:\n    c: aa\n")
    found = analyse(path, documents.texts)
    first, second = reports(found, [], documents, Positions(PositionCodec()))
    assert first.severity == DiagnosticSeverity.Error
    assert first.source == "seoro"
    assert first.related_information is not None
    assert first.related_information[0].location.range.start.line == 0
    assert "help: did you mean `a`" in second.message


def test_errors_of_closed_files_are_shown_at_the_import(tmp_path: Path) -> None:
    (tmp_path / "b.osc").write_text('import "c.osc"\n')
    (tmp_path / "c.osc").write_text("struct c:\n    x: nothing\n    y: nowhere\n")
    documents = Documents()
    path = opened(documents, tmp_path / "a.osc", 'struct a\nimport "b.osc"\n'.replace("struct a\n", ""))
    [(line, message)] = lines_and_messages(documents, path)
    assert line == 0
    assert message.startswith("in `c.osc`: unknown type `nothing`, and 1 more")
    opened(documents, tmp_path / "c.osc", (tmp_path / "c.osc").read_text())
    assert lines_and_messages(documents, path) == []


def test_errors_caused_by_an_importing_file_are_shown_in_the_imported_file(tmp_path: Path) -> None:
    documents = Documents()
    imported = opened(documents, tmp_path / "b.osc", "struct b\n")
    importer = opened(documents, tmp_path / "a.osc", 'import "b.osc"\nstruct b\n')
    assert lines_and_messages(documents, imported) == []
    assert len(lines_and_messages(documents, importer, imported)) == 1
    assert lines_and_messages(documents, imported, importer) == []


def test_unsaved_texts_precede_those_on_disk(tmp_path: Path) -> None:
    (tmp_path / "b.osc").write_text("struct old\n")
    documents = Documents()
    path = opened(documents, tmp_path / "a.osc", 'import "b.osc"\nstruct a:\n    x: new\n')
    assert len(lines_and_messages(documents, path)) == 1
    opened(documents, tmp_path / "b.osc", "struct new\n")
    assert lines_and_messages(documents, path) == []


def test_only_files_and_new_texts_are_documents(tmp_path: Path) -> None:
    documents = Documents()
    for uri in ("http://x/a.osc", "git:/a.osc", "file://host/a.osc", "file:", "", "file:///a%00.osc", "http://[x"):
        assert documents.put(uri, 1, "") is None
    assert documents.put("untitled:Untitled-1", 1, "struct a\n") is not None
    assert documents.find("untitled:Untitled-1") is not None
