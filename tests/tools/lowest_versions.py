"""Prints the lowest allowed versions of all packages that users install, as constraints for pip."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

PROJECT: Final = Path(__file__).parents[2] / "pyproject.toml"
_TOOLS: Final = ("dev", "docs")  # extras that users do not install
_BOUND: Final = re.compile(r"(?P<name>[\w.-]+)>=(?P<version>[\w.]+)")


def lowest_versions(project: dict[str, Any]) -> Iterator[str]:
    """Yield `NAME==VERSION` for each dependency with a lowest version, the highest of its bounds."""
    extras = project["optional-dependencies"]
    used = [*project["dependencies"], *(each for name in extras if name not in _TOOLS for each in extras[name])]
    bounds: dict[str, str] = {}
    for requirement in used:
        if found := _BOUND.match(requirement):
            bounds[found["name"]] = max(bounds.get(found["name"], ""), found["version"], key=_parts)
    yield from (f"{name}=={version}" for name, version in sorted(bounds.items()))


def _parts(version: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", version)))


if __name__ == "__main__":
    print("\n".join(lowest_versions(tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"])))
