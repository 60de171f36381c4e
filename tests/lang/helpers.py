"""Helpers to check and lower a text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from seoro.lang import ast, frontend
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_expression, parse_file
from seoro.lang.plan import Plan
from seoro.lang.source import SourceFile


def parse(text: str) -> tuple[ast.OscFile, list[str]]:
    """Return the tree of a text and the codes of its messages."""
    bag = Bag()
    tree = parse_file(SourceFile("test.osc", text), bag)
    return tree, [found.code for found in bag.diagnostics]


def expression(text: str) -> ast.Expression:
    """Return the tree of an expression."""
    tree = parse_expression(SourceFile("test", text), Bag())
    assert tree is not None, text
    return tree


def check(folder: Path, text: str, strict: bool = False) -> frontend.Checked:
    """Return the diagnostics of a text."""
    path = folder / "test.osc"
    path.write_bytes(text.encode())
    return frontend.check(frontend.load(path, "test.osc"), strict=strict)


def messages(folder: Path, text: str, strict: bool = False) -> list[tuple[int, str]]:
    """Return lines and codes of the diagnostics of a text."""
    return [(found.primary.span.line, found.code) for found in check(folder, text, strict).diagnostics]


def lower(
    folder: Path,
    text: str,
    overrides: Mapping[str, str] | None = None,
    scenario: str | None = None,
    constraints: Sequence[str] = (),
) -> Plan:
    """Return the plan of a text."""
    return frontend.lower(check(folder, text), scenario, overrides or {}, constraints)
