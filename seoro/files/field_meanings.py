"""Meanings of the fields of models, as their sources give them."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap

from pydantic import BaseModel

from seoro.files.commented_yaml import described_arguments


def field_meanings(model: type[BaseModel]) -> dict[str, str]:
    """Return the meanings of fields: entries of the docstring, else the comments behind them."""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel) and base is not BaseModel:
            source = textwrap.dedent(inspect.getsource(base))
            lines = source.splitlines()
            for statement in ast.walk(ast.parse(source)):
                if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                    comment = re.search(r"  # (.*)$", lines[(statement.end_lineno or 1) - 1])
                    if comment:
                        found[statement.target.id] = comment[1]
            found |= described_arguments(base.__doc__ or "")
    return found
