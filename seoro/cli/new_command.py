"""`seoro new`: make a project with a scenario, a world, an own action and tests."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path, PurePosixPath
from string import Template
from typing import Final

from seoro.cli.arguments import add_option
from seoro.cli.files import write_errors
from seoro.errors import UsageError

EXAMPLES = """examples:
  seoro new warehouse
  seoro new warehouse --ci gitlab

The folder NAME gets `seoro.toml`, a scenario that passes in MuJoCo, its world, an action in Python, tests, and
files for CI and VS Code. A folder that is not empty is refused."""

SUFFIX: Final = ".template"
DOT: Final = "dot-"  # instead of a leading dot: packages leave hidden files out
CI: Final = {"github": ".github/workflows/scenarios.yml", "gitlab": ".gitlab-ci.yml"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folder", metavar="NAME", type=Path, help="folder of the project")
    add_option(
        parser, "--ci", "service that runs the tests (default: github)", choices=(*CI, "none"), default="github"
    )


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    folder: Path = options.folder
    with write_errors(folder):
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise UsageError(f"{folder} exists, and is not an empty folder", help="choose another name")
        others = {place for service, place in CI.items() if service != options.ci}
        for place, text in _files():
            if place in others:
                continue
            path = folder / place
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(Template(text).substitute(name=folder.resolve().name), encoding="utf-8")
    print(f"created {folder}")
    print(f"  cd {folder}")
    print("  seoro exec scenarios/deliver.osc")
    print("  seoro test")


def _files() -> Iterator[tuple[str, str]]:
    """Yield the files of a new project: their places, and their texts with `$name`."""

    def walk(folder: Traversable, place: PurePosixPath) -> Iterator[tuple[str, str]]:
        for entry in folder.iterdir():
            name = entry.name.removesuffix(SUFFIX)
            name = f".{name.removeprefix(DOT)}" if name.startswith(DOT) else name
            if entry.is_dir() and entry.name != "__pycache__":
                yield from walk(entry, place / name)
            elif entry.name.endswith(SUFFIX):
                yield str(place / name), entry.read_text(encoding="utf-8")

    yield from walk(files("seoro.cli") / "new_project", PurePosixPath())
