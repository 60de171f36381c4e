"""Reading YAML into plain values; files that people write are read by `yaml_files`, which stands on this."""

from __future__ import annotations

import re
from typing import Any, Final

import yaml

MAX_DEPTH: Final = 100


class _Shallow(yaml.SafeLoader):
    """Refuses what is nested deeply while it is read: the time that reading takes grows with the square of it."""

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


class _WithoutReferences(_Shallow):
    """Refuses references, which could make a small text a huge value; `1e-05` is a number, as YAML 1.2 has it."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: It is a reference, or within too many others.
        """
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("it has references")
        return super().compose_node(parent, index)


_WithoutReferences.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


def load_yaml(text: str, *, references: bool) -> Any:
    """The value of a text, which may have references or not.

    Raises:
        yaml.YAMLError: It has none.
    """
    return yaml.load(text, _Shallow if references else _WithoutReferences)  # noqa: S506 - both are safe


def read_yaml(text: str) -> Any:
    """The value of a text without references, such as one that comes from a scenario or a command line.

    Raises:
        ValueError: It has none.
    """
    try:
        return load_yaml(text, references=False)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
