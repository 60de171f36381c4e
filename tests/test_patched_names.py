"""Names that tests replace exist, also those of tests that are rarely run."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from pkgutil import resolve_name

FOLDER = Path(__file__).parent


def replaced(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines and full names of the calls of `monkeypatch.setattr` in a test file."""
    tree = ast.parse(file.read_text())
    imported = dict(imports(tree))
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Attribute(attr="setattr"), keywords=[]):
                name = replaced_by(node, imported)
                if name is not None:
                    yield node.lineno, name


def imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the imported names of a module, and their full names."""
    for node in tree.body:
        match node:
            case ast.Import():
                yield from ((each.asname or each.name, each.name) for each in node.names)
            case ast.ImportFrom(module=str(module), level=0):
                yield from ((each.asname or each.name, f"{module}.{each.name}") for each in node.names)


def replaced_by(call: ast.Call, imported: Mapping[str, str]) -> str | None:
    """Return the full name that a call replaces; None if it is not an imported one."""
    match call.args:
        case [ast.Constant(value=str(name)), _]:
            return name
        case [ast.Name() | ast.Attribute() as owner, ast.Constant(value=str(name)), _]:
            root, dot, rest = ast.unparse(owner).partition(".")
            return f"{imported[root]}{dot}{rest}.{name}" if root in imported else None
    return None


def test_replaced_names_exist() -> None:
    missing = []
    for file in sorted(FOLDER.rglob("*.py")):
        for line, name in replaced(file):
            try:
                resolve_name(name)
            except (AttributeError, ImportError) as error:
                missing.append(f"{file.relative_to(FOLDER)}:{line}: {error}")
    assert not missing
