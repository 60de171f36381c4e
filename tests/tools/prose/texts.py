"""Prose of files: docstrings, comments and strings of Python, comments of scenarios, pages of Markdown."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from enum import Enum
from itertools import groupby
from pathlib import Path
from typing import NamedTuple


class Kind(Enum):
    """Places of texts."""

    DOCSTRING = "docstring"
    PREDICATE = "docstring of a boolean"
    ENTRY = "entry of a docstring"
    COMMENT = "comment"
    STRING = "string"
    PAGE = "page"


class Text(NamedTuple):
    """A paragraph.

    Args:
        file: The file.
        line: The line on which it begins.
        kind: Its place.
        text: Its words, on one line.
    """

    file: Path
    line: int
    kind: Kind
    text: str


SECTIONS = ("Args:", "Returns:", "Raises:", "Yields:", "Attributes:", "Examples:", "Example:", "Note:")
WORDS = 3  # a string of fewer is a name
_ENTRY = re.compile(r"\s*([*\w., ]+?)( \([^)]*\))?: (.*)")
_DIRECTIVES = ("noqa", "type:", "pragma", "mypy:", "!", "-- ", "---", "fmt:", "SPDX", "seoro:", "pytest:")


def texts_in(file: Path) -> Iterator[Text]:
    """Yield the paragraphs of a file, in order for each kind."""
    source = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        tree = ast.parse(source)
        yield from _docstrings(file, tree)
        yield from _strings(file, tree)
        yield from _python_comments(file, source)
    elif file.suffix == ".md":
        yield from _pages(file, source)
    else:
        yield from _line_comments(file, source)


def _joined(lines: list[str]) -> str:
    return " ".join(" ".join(lines).split())


def _docstrings(file: Path, tree: ast.Module) -> Iterator[Text]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            for statement in _documentation(node):
                yield from _docstring(file, statement, _is_predicate(node))


def _documentation(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[ast.Expr]:
    """Yield the docstring of a node, and the strings that stand below variables."""
    holds_variables = not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    for position, statement in enumerate(node.body):
        if (
            isinstance(statement, ast.Expr)
            and isinstance(statement.value, ast.Constant)
            and isinstance(statement.value.value, str)
            and (position == 0 or holds_variables)
        ):
            yield statement


def _is_predicate(node: ast.AST) -> bool:
    if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) or node.returns is None:
        return False
    return "bool" in ast.unparse(node.returns)


def _docstring(file: Path, statement: ast.Expr, is_predicate: bool) -> Iterator[Text]:
    assert isinstance(statement.value, ast.Constant)
    source = statement.value.value
    assert isinstance(source, str)
    kind = Kind.PREDICATE if is_predicate else Kind.DOCSTRING
    section = ""
    paragraph: list[str] = []
    began = statement.lineno
    for number, line in enumerate(source.split("\n"), statement.lineno):
        text = line.strip()
        if text in SECTIONS:
            section = text
            text = ""
        entry = _ENTRY.fullmatch(line) if section in ("Args:", "Attributes:", "Raises:") else None
        bullet = text.startswith(("- ", "* "))
        if not text or entry or bullet or text.startswith((">>>", "|", "```")):
            if paragraph:
                yield Text(file, began, kind, _joined(paragraph))
            paragraph = []
            if entry or bullet or (text == "" and kind is not Kind.ENTRY):
                kind = Kind.ENTRY if section or bullet else kind
            text = entry.group(3) if entry else text.lstrip("-* ") if bullet else text
            if text.startswith((">>>", "|", "```")):
                text = ""
        if text and not paragraph:
            began = number
        if text:
            paragraph.append(text)
    if paragraph:
        yield Text(file, began, kind, _joined(paragraph))


def _strings(file: Path, tree: ast.Module) -> Iterator[Text]:
    """Yield the strings that people may read: those of a few words, apart from docstrings."""
    inner = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for value in node.values
        for part in ast.walk(value)
    }
    bare = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if id(node) in inner or id(node) in bare:
            continue
        text = _text_of(node)
        if len(text.split()) >= WORDS and not _is_code(text):
            yield Text(file, getattr(node, "lineno", 1), Kind.STRING, _joined([text]))


def _text_of(node: ast.AST) -> str:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(
            value.value if isinstance(value, ast.Constant) and isinstance(value.value, str) else "`x`"
            for value in node.values
        )
    return ""


def _is_code(text: str) -> bool:
    """Whether a string is a program, XML, a pattern or data: indented lines, backslashes, or hardly any words."""
    if "\\" in text or text.startswith("<") or re.search(r"\n\s+\S", text) or text.count("\n") > 1:
        return True
    return sum(map(str.isalpha, text)) < len(text) / 2


def _python_comments(file: Path, source: str) -> Iterator[Text]:
    found = [
        (token.start[0], not token.line[: token.start[1]].strip(), token.string.lstrip("# "))
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    ]
    yield from _comments(file, found)


def _line_comments(file: Path, source: str) -> Iterator[Text]:
    found = [
        (number, line.lstrip().startswith("#"), line[line.index("#") :].lstrip("# "))
        for number, line in enumerate(source.split("\n"), 1)
        if line.lstrip().startswith("#") or " # " in line
    ]
    yield from _comments(file, found)


def _comments(file: Path, found: list[tuple[int, bool, str]]) -> Iterator[Text]:
    """Join comments on consecutive lines; a comment behind code stands alone."""
    kept = [(number, alone, text) for number, alone, text in found if text and not text.startswith(_DIRECTIVES)]
    for _, group in groupby(enumerate(kept), lambda each: (each[1][0] - each[0], each[1][1] or each[1][0])):
        lines = [line for _, line in group]
        text = _joined([text for _, _, text in lines])
        if len(text.split()) >= WORDS:
            yield Text(file, lines[0][0], Kind.COMMENT, text)


def _pages(file: Path, source: str) -> Iterator[Text]:
    fenced = False
    paragraph: list[str] = []
    began = 1
    for number, line in enumerate([*source.split("\n"), ""], 1):
        text = line.strip()
        if text.startswith(("```", "~~~", ":::")):
            fenced = not fenced if not text.startswith(":::") else fenced
            text = ""
        parts = [part.strip() for part in text.strip("|").split(" | ")] if text.startswith("|") else [text]
        is_item = re.match(r"([-*+]|\d+\.|#+|>) ", text) is not None
        if fenced or not text or is_item or text.startswith(("|", "<", "[")):
            if paragraph:
                yield Text(file, began, Kind.PAGE, _joined(paragraph))
            paragraph = []
        if fenced or not text or text.startswith(("<", "|-", "|:")):
            continue
        if text.startswith("|"):
            yield from (Text(file, number, Kind.PAGE, part) for part in parts if len(part.split()) >= WORDS)
            continue
        if not paragraph:
            began = number
        paragraph.append(re.sub(r"^([-*+]|\d+\.|#+|>) ", "", text))
