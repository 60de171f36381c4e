"""Reading YAML into plain values; files that people write are read by `yaml_files`, which stands on this."""

from __future__ import annotations

import re
from typing import Any

import yaml


class _WithoutReferences(yaml.SafeLoader):
    """Refuses references, which could make a small text a huge value; `1e-05` is a number, as YAML 1.2 has it."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node.

        Raises:
            yaml.YAMLError: It is a reference.
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
    try:
        return yaml.load(text, yaml.SafeLoader if references else _WithoutReferences)  # noqa: S506 - both are safe
    except RecursionError:
        raise yaml.YAMLError("it is nested too deeply") from None


def read_yaml(text: str) -> Any:
    """The value of a text without references, such as one that comes from a scenario or a command line.

    Raises:
        ValueError: It has none.
    """
    try:
        return load_yaml(text, references=False)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
