"""Safe YAML reader for plain values; `yaml_lines` adds errors with line numbers."""

from __future__ import annotations

import re
from typing import Any, Final

import yaml

MAX_DEPTH: Final = 100
MAX_DIGITS: Final = 200  # of an integer
_MERGE: Final = "tag:yaml.org,2002:merge"  # `<<`, which may occur repeatedly in a mapping


class _Plain(yaml.composer.Composer, yaml.constructor.SafeConstructor, yaml.resolver.Resolver):
    """Base of YAML loaders that refuse deep nesting and duplicate keys.

    Reading time grows with the square of the depth, and YAML readers silently use the last of duplicate keys.
    Without `references` they also refuse aliases, which could expand a small text to a huge value.
    `1e-05` is a number, as in YAML 1.2.
    """

    _depth = 0
    _references: bool

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: The node is nested too deeply, or an unsupported alias.
        """
        if not self._references and self.check_event(yaml.AliasEvent):  # type: ignore[attr-defined] # of the parser
            raise yaml.YAMLError("unsupported alias")
        if self._depth >= MAX_DEPTH:
            raise yaml.YAMLError("nested too deeply")
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Compose a mapping.

        Raises:
            yaml.MarkedYAMLError: The mapping has duplicate keys.
        """
        node = super().compose_mapping_node(anchor)
        marks: dict[tuple[str, str], yaml.Mark] = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.tag == _MERGE:
                continue
            if first := marks.get((key.tag, key.value)):
                problem = f"duplicate key '{key.value}', first in line {first.line + 1}"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            marks[key.tag, key.value] = key.start_mark
        return node

    def construct_scalar_number(self, node: yaml.ScalarNode) -> Any:
        """Construct an integer.

        Raises:
            yaml.MarkedYAMLError: The integer has too many digits.
        """
        if len(node.value) > MAX_DIGITS:
            problem = f"integer with {len(node.value)} characters, limit {MAX_DIGITS}"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        return super().construct_yaml_int(node)


_Plain.add_constructor("tag:yaml.org,2002:int", _Plain.construct_scalar_number)  # type: ignore[type-var]
_Plain.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


class _PythonLoader(_Plain, yaml.SafeLoader):
    """Loader with the parser in Python, whose errors explain more."""

    def __init__(self, text: str, *, references: bool) -> None:
        yaml.SafeLoader.__init__(self, text)
        self._references = references


class _Loader(_Plain, yaml.CSafeLoader):
    """Loader with the parser in C, which takes a fifth of the time."""

    def __init__(self, text: str, *, references: bool) -> None:
        yaml.CSafeLoader.__init__(self, text)
        yaml.composer.Composer.__init__(self)
        self._references = references


def load_yaml(text: str, *, references: bool) -> Any:
    """Parse a text, with or without support for aliases.

    Raises:
        yaml.YAMLError: The text is invalid.
    """
    try:
        return _load(_Loader(text, references=references))
    except (yaml.YAMLError, UnicodeEncodeError):
        return _load(_PythonLoader(text, references=references))


def _load(loader: _Loader | _PythonLoader) -> Any:
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()


def read_yaml(text: str) -> Any:
    """Parse a text without aliases, for example from a scenario or a command line.

    Raises:
        ValueError: The text is invalid.
    """
    try:
        return load_yaml(text, references=False)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
