"""`seoro campaign import`: campaign files from RoboVAST files."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import yaml

from seoro.campaign.vast.schema import VastFile
from seoro.campaign.vast.translation import Study, Target, Translation, translate
from seoro.cli.arguments import Commands, add_command, add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.embed import load
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input
from seoro.files.yaml_lines import Lines, read_settings
from seoro.lang.check.plan_types import type_name
from seoro.lang.lower.lower import find_entry
from seoro.lang.program import Program
from seoro.lang.symbols import Primitive, Type

MARK = "# Written by `seoro campaign import"


def add_import(commands: Commands) -> None:
    """Declare the subcommand."""
    parser = add_command(commands, "import", "write campaign files from a RoboVAST file (.vast), beside it")
    parser.add_argument("file", metavar="FILE", type=Path, help="RoboVAST file, beside its scenario")
    add_option(parser, "--overwrite", "replace files that differ from what would be written")


def import_vast(options: argparse.Namespace) -> Exit:
    """Run the command."""
    path: Path = options.file
    file, lines = read_settings(path, VastFile)
    scenario = path.parent / file.execution.scenario_file
    if not scenario.is_file():
        place = lines.at(("execution", "scenario_file"))
        raise UsageError(f"{place}: execution.scenario_file: file not found: {scenario}")
    found = translate(file, _target(scenario, file.execution.scenario_file), path.stem)
    if not found.studies:
        raise UsageError(f"{path}: expected `configuration` or `search`")
    texts = {
        path.parent / name: text for study in found.studies for name, text in _texts(study, path.name).items()
    }
    _check_free(texts, overwrite=options.overwrite)
    with write_errors(path.parent):
        for target, text in texts.items():
            target.write_text(text, encoding="utf-8")
            print(f"  {target}")
    _print_notes(found, lines)
    return Exit.PASSED


def _target(path: Path, file: str) -> Target:
    checked = load(path).checked
    entry = find_entry(checked, None)
    fields = entry.inventory.fields
    types = {name: _type_name(symbol.type, checked.program) for name, symbol in fields.items()}
    required = frozenset(name for name, symbol in fields.items() if symbol.default is None)
    return Target(file, entry.qualified_name, types, required)


def _type_name(type_: Type, program: Program) -> str:
    return type_.name if isinstance(type_, Primitive) else type_name(type_, program)


def _texts(study: Study, source: str) -> Mapping[str, str]:
    comment = f"{MARK} {source}`."
    body = yaml.safe_dump(dict(study.keys), sort_keys=False, allow_unicode=True, width=110)
    texts = {f"{study.name}.yaml": f"{comment}\n{body}"}
    if study.wrapper is not None:
        texts[f"{study.name}.osc"] = study.wrapper.source([comment.removeprefix("# ")])
    return texts


def _check_free(texts: Mapping[Path, str], *, overwrite: bool) -> None:
    for path, text in texts.items():
        if path.exists() and not overwrite and read_input(path, Kind.OUTPUT) != text.encode():
            raise UsageError(f"{path} exists", help="replace it with `--overwrite`, or rename it")


def _print_notes(found: Translation, lines: Lines) -> None:
    if found.notes:
        print(f"\n{count(len(found.notes), 'part')} not carried over:")
    for note in sorted(found.notes, key=lambda note: lines.line(note.place)):
        print(f"  {note.text(lines)}")
    for study in found.studies:
        missing = () if study.wrapper is None else tuple(study.wrapper.missing)
        if missing:
            print(
                f"\nwrite the value of {' and '.join(f'`{name}`' for name in missing)} in {study.name}.osc first"
            )
