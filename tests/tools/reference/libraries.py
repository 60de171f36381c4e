"""Actions and modifiers of the libraries, from their declarations and the docstrings of their implementations."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from tests.tools.reference.tables import code, table

ROOT: Final = Path(__file__).parents[3] / "seoro"
DECLARATION: Final = re.compile(
    r"(?P<comment>(?:^#[^\n]*\n)*)^(?P<kind>action|modifier) (?P<name>[\w.]+)(?P<of> of [\w.]+)?:?\n"
    r"(?P<body>(?:(?: {4}[^\n]*)?\n)*)",
    re.MULTILINE,
)


class Implementation(NamedTuple):
    """A Python function that implements an action or a modifier.

    Args:
        summary: First sentence of its docstring.
    """

    summary: str


def libraries() -> str:
    """Return a section for each library that has actions or modifiers."""
    known = dict(_implementations())
    parts = []
    for file in sorted((ROOT / "lang" / "library").glob("*.osc")):
        text = file.read_text(encoding="utf-8") + "\n"
        rows = [_row(found, known) for found in DECLARATION.finditer(text)]
        if not rows:
            continue
        comment = re.match(r"(?:#[^\n]*\n)+", text)
        about = " ".join(line.lstrip("# ") for line in comment[0].splitlines()) if comment else ""
        parts.append(f"## osc.{file.stem}\n\n{about}\n\n{table(('declaration', 'effect'), rows)}")
    return "\n".join(parts)


def _row(found: re.Match[str], known: dict[str, Implementation]) -> tuple[str, str]:
    lines = [line.strip() for line in found["body"].splitlines()]
    parameters = [
        line for line in lines if re.match(r"\w[\w, ]*: ", line) and not line.startswith(("do ", "keep"))
    ]
    comment = " ".join(line.lstrip("# ") for line in found["comment"].splitlines())
    implementation = known.get(found["name"])
    is_composed = any(line.startswith("do") for line in lines)
    effect = comment or (implementation.summary if implementation else "")
    if implementation is None and not is_composed:
        effect = f"{effect} *Declared only: invoking it is an error before the run.*".strip()
    shown = f"{found['kind']} {found['name']}({', '.join(parameters)})"
    return code(shown), effect


def _implementations() -> Iterator[tuple[str, Implementation]]:
    for file in sorted((ROOT / "actions").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                for decorator in node.decorator_list:
                    yield from _named(node, decorator)


def _named(
    node: ast.FunctionDef | ast.AsyncFunctionDef, decorator: ast.expr
) -> Iterator[tuple[str, Implementation]]:
    if not (isinstance(decorator, ast.Call) and decorator.args and isinstance(decorator.func, ast.Name)):
        return
    name = decorator.args[0]
    if isinstance(name, ast.Constant) and isinstance(name.value, str):
        summary = (ast.get_docstring(node) or "").partition("\n\n")[0]
        yield name.value, Implementation(summary)
