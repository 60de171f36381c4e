"""Reading YAML into plain values; files that people write are read by `yaml_files`, which stands on this."""

from __future__ import annotations

import re
from typing import Any, Final

import yaml

MAX_DEPTH: Final = 100
MAX_DIGITS: Final = 200  # of an integer
_MERGE: Final = "tag:yaml.org,2002:merge"  # `<<`, which may stand in a mapping more than once


class _Plain(yaml.SafeLoader):
    """Refuses what is nested deeply while it is read: the time that reading takes grows with the square of it.

    Keys that a mapping has twice are refused, too; YAML readers take the last one without a word. `1e-05` is a
    number, as YAML 1.2 has it.
    """

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: It is within too many others.
        """
        if self._depth >= MAX_DEPTH:
            raise yaml.YAMLError("it is nested too deeply")
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Compose a mapping.

        Raises:
            yaml.MarkedYAMLError: It has a key twice.
        """
        node = super().compose_mapping_node(anchor)
        marks: dict[tuple[str, str], yaml.Mark] = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.tag == _MERGE:
                continue
            if first := marks.get((key.tag, key.value)):
                problem = f"the key '{key.value}' is given twice, for the first time in line {first.line + 1}"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            marks[key.tag, key.value] = key.start_mark
        return node

    def construct_scalar_number(self, node: yaml.ScalarNode) -> Any:
        """Construct an integer.

        Raises:
            yaml.MarkedYAMLError: It has more digits than any number that is used.
        """
        if len(node.value) > MAX_DIGITS:
            problem = f"an integer of {len(node.value)} characters, more than the limit of {MAX_DIGITS}"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        return super().construct_yaml_int(node)


_Plain.add_constructor("tag:yaml.org,2002:int", _Plain.construct_scalar_number)
_Plain.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


class _WithoutReferences(_Plain):
    """Refuses references, too, which could make a small text a huge value."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: It is a reference, or within too many others.
        """
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("it has references")
        return super().compose_node(parent, index)


def load_yaml(text: str, *, references: bool) -> Any:
    """The value of a text, which may have references or not.

    Raises:
        yaml.YAMLError: It has none.
    """
    return yaml.load(text, _Plain if references else _WithoutReferences)  # noqa: S506 - both are safe


def read_yaml(text: str) -> Any:
    """The value of a text without references, such as one that comes from a scenario or a command line.

    Raises:
        ValueError: It has none.
    """
    try:
        return load_yaml(text, references=False)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
