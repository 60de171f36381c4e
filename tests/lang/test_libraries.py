"""The libraries declare exactly what `tests/data/libraries.txt` lists, and are free of errors."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from seoro.lang import ast, frontend
from seoro.lang.symbols import UnitSymbol
from tests.lang.helpers import check

TABLE = Path(__file__).parents[1] / "data" / "libraries.txt"
LIBRARIES = sorted(
    path.stem for path in (Path(frontend.__file__).parent / "library").glob("*.osc") if path.stem != "standard"
)
_KINDS = {
    ast.StructDeclaration: "struct",
    ast.ActorDeclaration: "actor",
    ast.ActionDeclaration: "action",
    ast.ModifierDeclaration: "modifier",
}


def described(statement: ast.Statement) -> tuple[str, tuple[str, ...]] | None:
    """Return a declaration in the form of the table."""
    if isinstance(statement, ast.EnumDeclaration):
        return re.sub(r"\n\s*", " ", statement.span.text).replace("[ ", "["), ()
    kind = _KINDS.get(type(statement))
    if kind is None:
        return None
    assert isinstance(
        statement, ast.StructDeclaration | ast.ActorDeclaration | ast.ActionDeclaration | ast.ModifierDeclaration
    )
    head = statement.span.text.splitlines()[0].removesuffix(":")
    members = []
    for member in statement.members:
        text = re.sub(r"\s*\\?\n\s*", " ", member.span.text)
        members.append(text.partition(" is ")[0] if isinstance(member, ast.MethodDeclaration) else text)
    return head, tuple(members)


def wanted(library: str) -> set[tuple[str, tuple[str, ...]]]:
    rows = [line.split("|") for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {
        (head.strip(), tuple(part.strip() for part in members.split(";") if part.strip()))
        for name, head, members in rows
        if name.strip() == library
    }


@pytest.mark.parametrize("name", LIBRARIES)
def test_a_library_declares_its_listed_names(name: str, tmp_path: Path) -> None:
    checked = check(tmp_path, f"import osc.{name}\n")
    assert checked.diagnostics == ()
    module = next(module for module in checked.sources.modules if module.library == f"osc.{name}")
    found = {declared for statement in module.tree.statements if (declared := described(statement)) is not None}
    assert found == wanted(f"osc.{name}")


def test_all_libraries_can_be_imported_together(tmp_path: Path) -> None:
    imports = "".join(f"import osc.{name}\n" for name in LIBRARIES)
    assert check(tmp_path, imports).diagnostics == ()


@pytest.mark.parametrize(
    ("unit", "factor", "offset"),
    [
        ("km", 1000.0, 0.0),
        ("kph", 0.277777778, 0.0),
        ("deg", 0.01745329252, 0.0),
        ("celsius", 1.0, 273.15),
        ("lb", 0.45359237, 0.0),
    ],
)
def test_units_have_the_factors_of_the_standard(unit: str, factor: float, offset: float, tmp_path: Path) -> None:
    found = check(tmp_path, "import osc.types\n").program.units[unit]
    assert isinstance(found, UnitSymbol)
    assert (found.factor, found.offset) == (factor, offset)


@pytest.mark.parametrize(
    ("module", "prefix"),
    [
        ("osc.types", ""),
        ("osc.standard", ""),
        ("osc.standard.all", "stdtypes::"),
        ("osc.standard.types", "stdtypes::"),
    ],
)
def test_modules_of_the_standard_use_its_namespace_as_specified(module: str, prefix: str, tmp_path: Path) -> None:
    text = f"import {module}\n\nstruct a:\n    x: {prefix}length = 3m\n    p: {prefix}pose_3d\n"
    assert check(tmp_path, text).diagnostics == ()
    if prefix:
        assert check(tmp_path, text.replace(prefix, "")).errors
