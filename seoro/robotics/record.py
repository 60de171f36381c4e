"""Base of dataclasses that are also fields of messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Record:
    """A frozen dataclass; messages check its fields and convert integers to floats."""

    __pydantic_config__: ClassVar = {"revalidate_instances": "always"}
