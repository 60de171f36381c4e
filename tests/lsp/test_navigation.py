"""Definitions, references and new names."""

from pathlib import Path

import pytest

from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lsp import navigation
from seoro.lsp.analysis import Analysis, analyse, analyse_users
from seoro.lsp.outline import declared
from tests.lsp.helpers import SCENARIO, analysis, split


def declared_at(folder: Path, marked: str) -> tuple[str, int, str]:
    """Return file name, line and text of the declaration of the name at the mark."""
    text, offset = split(marked)
    found = navigation.declared_at(analysis(folder, text), offset)
    assert found is not None
    path, span = found
    return path.name, span.line, span.text


@pytest.mark.parametrize(
    ("place", "line", "name"),
    [
        ("emit g|o", "event go", "go"),
        ("wait @fir|st", "first: serial", "first"),
        ("crane.li|ft(", "action crane.lift", "lift"),
        ("cra|ne.lift(", "    crane: crane", "crane"),
        ("crane.lift(wh|at", "    what: box", "what"),
        ("what: cra|te", "    crate: box", "crate"),
        ("color = r|ed", "enum color", "red"),
        ("crate: b|ox", "struct box", "box"),
        ("action cra|ne", "actor crane", "crane"),
        ("if occ|urred", "wait @go as", "occurred"),
        ("occurred.cou|nt", "event go", "count"),
        ("expression cou|nt", "def times", "count"),
    ],
)
def test_names_lead_to_their_declarations(tmp_path: Path, place: str, line: str, name: str) -> None:
    number = next(index for index, text in enumerate(SCENARIO.splitlines(), 1) if line in text)
    marked = SCENARIO.replace(place.replace("|", ""), place, 1)
    assert declared_at(tmp_path, marked) == ("test.osc", number, name)


@pytest.mark.parametrize(
    ("place", "name"), [("60k|ph", "kph"), ("limit: sp|eed", "speed"), ("weight: ma|ss", "mass")]
)
def test_names_lead_into_libraries(tmp_path: Path, place: str, name: str) -> None:
    file, _, text = declared_at(tmp_path, SCENARIO.replace(place.replace("|", ""), place, 1))
    assert (file, text) == ("types.osc", name)


def test_imports_lead_to_files(tmp_path: Path) -> None:
    assert declared_at(tmp_path, "import osc.r|os\n")[0] == "ros.osc"
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a.osc").write_text("struct a\n")
    assert declared_at(tmp_path, 'import "parts/|a.osc"\n') == ("a.osc", 1, "")


def test_members_of_qualified_names_lead_to_the_member(tmp_path: Path) -> None:
    text = "enum e: [one, two]\nstruct s:\n    a: e = e!t|wo\n"
    assert declared_at(tmp_path, text) == ("test.osc", 1, "two")


def two_files(folder: Path) -> tuple[Analysis, Path]:
    (folder / "a.osc").write_text("struct box:\n    size: int = 1\n")
    (folder / "b.osc").write_text('import "a.osc"\nscenario b:\n    x: box = box(size: 2)\n')
    return analyse((folder / "a.osc").resolve(), {}), folder.resolve()


def test_references_are_found_in_files_of_the_workspace(tmp_path: Path) -> None:
    first, folder = two_files(tmp_path)
    found = navigation.target_at(first, first.file.text.index("box"))
    assert found is not None
    uses = navigation.uses([found[1]], analyse_users(["box"], [folder], {}, [first]))
    assert {path.name: [span.text for span in spans] for path, spans in uses.items()} == {
        "a.osc": ["box"],
        "b.osc": ["box", "box"],
    }


def test_new_names_replace_identifiers_only(tmp_path: Path) -> None:
    text = "namespace n\nenum e: [one, two]\nstruct s:\n    a: n::e = e!two\n    b: e = two\n"
    found = analysis(tmp_path, text)
    target = navigation.target_at(found, text.index("two"))
    assert target is not None
    [spans] = navigation.edits(target[1], "two", "three", [found]).values()
    assert [(span.line, span.text) for span in spans] == [(2, "two"), (4, "two"), (5, "two")]
    target = navigation.target_at(found, text.index("e: ["))
    assert target is not None
    [spans] = navigation.edits(target[1], "e", "f", [found]).values()
    assert [(span.line, span.text) for span in spans] == [(2, "e"), (4, "e"), (4, "e"), (5, "e")]


@pytest.mark.parametrize("place", ["limit: sp|eed", "|import osc.ros", "6|0kph"])
def test_names_of_libraries_cannot_be_renamed(tmp_path: Path, place: str) -> None:
    text, offset = split(SCENARIO.replace(place.replace("|", ""), place, 1))
    with pytest.raises(navigation.CannotRename):
        navigation.check_rename(analysis(tmp_path, text), offset)


@pytest.mark.parametrize("name", ["", "3d", "a b", "a.b", "a::b", "a#"])
def test_invalid_identifiers_are_refused_as_new_names(tmp_path: Path, name: str) -> None:
    found = analysis(tmp_path, "struct a\n")
    target = navigation.target_at(found, 7)
    assert target is not None
    with pytest.raises(navigation.CannotRename, match="invalid identifier"):
        navigation.edits(target[1], "a", name, [found])


def test_an_open_library_file_is_checked_as_a_library() -> None:
    path = builtin_libraries()["osc.nav2"].resolve()
    found = analyse(path, {path: path.read_text(encoding="utf-8") + "\naction osc_actor.more\n"})
    assert found.path == path
    assert found.checked.errors == ()
    assert "more" in found.tree.statements[-1].span.text


def test_declarations_are_found_by_parts_of_their_names(tmp_path: Path) -> None:
    found = [span.text for _, _, span in declared("CR", [analysis(tmp_path, SCENARIO)])]
    assert found == ["crane", "crane", "crate"]


def test_a_name_before_a_dot_leads_to_the_label(tmp_path: Path) -> None:
    text = "scenario a:\n    n: int = 1\nscenario b:\n    {field}do serial:\n        x: a()\n        a(x|.n)\n"
    assert declared_at(tmp_path, text.format(field="")) == ("test.osc", 5, "x")
    field = "x: a2\n    "
    assert declared_at(tmp_path, f"struct a2:\n    n: int = 3\n{text.format(field=field)}") == ("test.osc", 6, "x")
