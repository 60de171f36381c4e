"""Attributes of modules that load their names on first use, which the type checker cannot see."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LAZY = ("seoro.bridges.wire", "seoro.lang.diagnostics")  # modules with a `__getattr__`


def aliases_of(tree: ast.AST, module: str) -> Iterator[str]:
    """Yield the names under which a file imports a module."""
    package, _, last = module.rpartition(".")
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == package:
            yield from (each.asname or each.name for each in node.names if each.name == last)


def used_attributes(tree: ast.AST, module: str) -> set[str]:
    """Return the attributes of a module that a file uses or imports by name."""
    aliases = set(aliases_of(tree, module))
    nodes = list(ast.walk(tree))
    used = {
        node.attr
        for node in nodes
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in aliases
    }
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module == module]
    return used | {each.name for node in imports for each in node.names if each.name != "*"}


def exists(module: str, name: str) -> bool:
    """Whether a module has an attribute, or a submodule of that name."""
    if hasattr(import_module(module), name):
        return True
    try:
        import_module(f"{module}.{name}")
    except ModuleNotFoundError:
        return False
    return True


@pytest.mark.parametrize("module", LAZY)
def test_every_used_attribute_of_a_lazy_module_exists(module: str) -> None:
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.py"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    if listed.returncode:
        pytest.skip("not a git work tree")
    files = [ROOT / name for name in listed.stdout.decode().split("\0") if name]
    uses = [
        (file.relative_to(ROOT), name)
        for file in files
        if file.is_file() and module.rpartition(".")[2] in (text := file.read_text(encoding="utf-8"))
        for name in used_attributes(ast.parse(text), module)
    ]
    assert len(uses) > 50
    assert [f"{file}: {module}.{name}" for file, name in uses if not exists(module, name)] == []


def test_a_missing_attribute_is_found() -> None:
    tree = ast.parse("from seoro.bridges import wire as w\nw.MISSING\nfrom seoro.bridges.wire import Holder, Lost")
    assert used_attributes(tree, "seoro.bridges.wire") == {"MISSING", "Holder", "Lost"}
    assert [exists("seoro.bridges.wire", name) for name in ("Holder", "refusal", "MISSING")] == [True, True, False]
