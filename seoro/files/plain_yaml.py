"""Safe YAML reader for plain values; `yaml_lines` adds errors with line numbers."""

from __future__ import annotations

import re
from typing import Any, Final

import yaml

MAX_DEPTH: Final = 100
MAX_DIGITS: Final = 200  # of an integer
_MERGE: Final = "tag:yaml.org,2002:merge"  # `<<`, which may occur repeatedly in a mapping


class _Plain(yaml.SafeLoader):
    """YAML loader that refuses deep nesting and duplicate keys.

    Reading time grows with the square of the depth, and YAML readers silently use the last of duplicate keys.
    `1e-05` is a number, as in YAML 1.2.
    """

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: The node is nested too deeply.
        """
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


_Plain.add_constructor("tag:yaml.org,2002:int", _Plain.construct_scalar_number)
_Plain.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


class _WithoutReferences(_Plain):
    """YAML loader that also refuses aliases, which could expand a small text to a huge value."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: The node is an alias, or nested too deeply.
        """
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("unsupported alias")
        return super().compose_node(parent, index)


def load_yaml(text: str, *, references: bool) -> Any:
    """Parse a text, with or without support for aliases.

    Raises:
        yaml.YAMLError: The text is invalid.
    """
    return yaml.load(text, _Plain if references else _WithoutReferences)  # noqa: S506 - both are safe


def read_yaml(text: str) -> Any:
    """Parse a text without aliases, for example from a scenario or a command line.

    Raises:
        ValueError: The text is invalid.
    """
    try:
        return load_yaml(text, references=False)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
