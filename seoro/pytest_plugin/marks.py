"""Marks of pytest in the `# pytest:` comments of scenario files."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from typing import Any

import pytest

from seoro.embed.directives import MarkComment
from seoro.errors import UsageError

_EXAMPLE = "for example `slow, flaky(reruns=2)`"


def read_marks(comments: Iterable[MarkComment]) -> tuple[pytest.MarkDecorator, ...]:
    """Read the marks of a scenario.

    Raises:
        UsageError: A mark is missing, invalid or unknown; the error has its place.
    """
    return tuple(_decorator(parsed, comment) for comment in comments for parsed in _parse(comment))


def _parse(comment: MarkComment) -> list[tuple[str, list[Any], dict[str, Any]]]:
    try:
        tree = ast.parse(f"[{comment.text}]", mode="eval").body
        assert isinstance(tree, ast.List)
        parsed = [_mark(element) for element in tree.elts]
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"invalid marks: `{comment.text}`", comment.span, _EXAMPLE) from error
    if not parsed:
        raise UsageError("missing mark", comment.span, _EXAMPLE)
    return parsed


def _decorator(parsed: tuple[str, list[Any], dict[str, Any]], comment: MarkComment) -> pytest.MarkDecorator:
    name, arguments, keywords = parsed
    if name == "parametrize":
        raise UsageError(
            "unsupported mark `parametrize`", comment.span, "write `# seoro: parametrize speed=[1mps, 2mps]`"
        )
    try:
        mark: pytest.MarkDecorator = getattr(pytest.mark, name)
    except (AttributeError, pytest.fail.Exception) as error:
        raise UsageError(str(error), comment.span) from error
    # `with_args`, since a mark called with a single function would decorate it.
    return mark.with_args(*arguments, **keywords) if arguments or keywords else mark


def _mark(element: ast.expr) -> tuple[str, list[Any], dict[str, Any]]:
    """Parse name, literal arguments and keywords of a mark; raise `ValueError` for anything else."""
    match element:
        case ast.Name(id=name):
            return name, [], {}
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=keywords):
            named = {keyword.arg: ast.literal_eval(keyword.value) for keyword in keywords if keyword.arg}
            return name, [ast.literal_eval(argument) for argument in arguments], named
    raise ValueError
