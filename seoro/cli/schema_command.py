"""`seoro schema`: print JSON Schemas of YAML files, for editors."""

from __future__ import annotations

import argparse
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.errors import UsageError
from seoro.files.schemas import SCHEMAS, file_name, schema_text
from seoro.lang.diagnostics import near

EXAMPLES = """examples:
  seoro schema                                 (lists all schemas)
  seoro schema world > world.schema.json
  seoro schema --output-dir schemas/           (writes all)

Editors with the YAML language server use the schema that a file names in its first line:

  # yaml-language-server: $schema=world.schema.json"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("name", metavar="SCHEMA", nargs="?", help=f"kind of file: {', '.join(SCHEMAS)}")
    add_option(parser, "-o --output-dir DIR", "write the schema, or all schemas, to this folder", type=Path)


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    if options.name not in (None, *SCHEMAS):
        hint = near(options.name, SCHEMAS) or f"schemas: {', '.join(SCHEMAS)}"
        raise UsageError(f"unknown schema `{options.name}`", help=hint)
    if options.output_dir is not None:
        _write([options.name] if options.name else [*SCHEMAS], options.output_dir)
    elif options.name is None:
        width = max(map(len, SCHEMAS))
        print("\n".join(f"{name:{width}}  {what}" for name, what in SCHEMAS.items()))
    else:
        print(schema_text(options.name), end="")


def _write(names: list[str], folder: Path) -> None:
    """Write schemas to a folder.

    Raises:
        UsageError: The folder or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in names:
            (folder / file_name(name)).write_text(schema_text(name), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write to {folder}: {error.strerror}") from error
    for name in names:
        print(folder / file_name(name))
