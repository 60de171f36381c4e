"""`python -m sim_nodes inspect`: prints inspections of robots as text, as JSON, or as a declaration."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence

import yaml

from seoro.bridges.model_files import InvalidModel
from seoro.bridges.wire.refusal import RequestRefused
from seoro.files.yaml_lines import FileError
from sim_nodes.robots.derive.complete import MOBILE_DRIVES
from sim_nodes.robots.derive.model import ModelJoint
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.inspection import Inspection, inspect

INVALID = 2  # exit status for an unusable model
UNSUITABLE = 1  # exit status for a model without a declaration
COMMENT = "# Values from the model. To change one, uncomment its line, and the lines that it is nested in."


def main(arguments: Sequence[str]) -> int:
    """Print an inspection; returns the exit status."""
    options = _parser().parse_args(arguments)
    try:
        inspection = inspect(options.model, None if options.drive is None else DriveKind(options.drive))
    except (FileError, InvalidModel, RequestRefused) as error:
        message = error.message if isinstance(error, RequestRefused) else str(error)
        sys.stderr.write(f"error: {message}\n")
        return INVALID
    if options.json:
        text = json.dumps(inspection.as_dict(), indent=2)
    elif options.declaration:
        if not inspection.declaration:
            sys.stderr.write(f"error: {_obstacle(inspection)}\n")
            return UNSUITABLE
        text = declaration_text(inspection)
    else:
        text = "\n".join(lines(inspection))
    sys.stdout.write(text.rstrip() + "\n")
    return UNSUITABLE if inspection.problems else 0


def _obstacle(inspection: Inspection) -> str:
    if inspection.problems:
        return "; ".join(inspection.problems)
    return f"found no wheels in {inspection.path}; `--drive KIND` lists missing parts"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="sim_nodes inspect", description="Describe the model of a robot.")
    parser.add_argument("model", help="URDF, SDF or MJCF file, declaration (.yaml), or name of a robot")
    parser.add_argument("--drive", choices=MOBILE_DRIVES, help="kind of drive (default: by the wheels)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print JSON")
    form.add_argument("--declaration", action="store_true", help="print a declaration to start from")
    return parser


def declaration_text(inspection: Inspection) -> str:
    """Return a declaration of three lines, with the derived values as comments."""
    if not inspection.is_derived:
        return f"model: {inspection.name}\n" + _yaml(inspection.declaration)
    short = {"model": inspection.name, "urdf": inspection.path, "drive": inspection.drive}
    head = yaml.safe_dump(short, sort_keys=False)
    derived = "".join(f"# {line}\n" for line in _yaml(inspection.declaration).splitlines())
    return f"{head}\n{COMMENT}\n#\n{derived}"


def _yaml(content: Mapping[str, object]) -> str:
    return yaml.safe_dump(dict(content), sort_keys=False, default_flow_style=None, width=110)


# ------------------------------------------------------------ text


def lines(inspection: Inspection) -> Iterator[str]:
    """Yield the lines of an inspection."""
    moving = [joint for joint in inspection.joints if joint.is_movable]
    sizes = f"{inspection.mass:.4g} kg, {len(inspection.links)} links, {len(moving)} joints that move"
    yield f"{inspection.name}: {sizes}"
    yield from _section("links", _table(_link_rows(inspection)))
    if moving:
        yield from _section("joints that move", _table(_joint_rows(moving)))
    if inspection.declaration:
        source = "derived from the model" if inspection.is_derived else "declared"
        yield from _section(f"declaration ({source})", _declared_lines(inspection.declaration))
    elif not inspection.problems:
        yield from _section("drive", ["found no wheels: round links on the floor with continuous, level joints"])
    yield from _section("notes", inspection.notes)
    yield from _section("problems", inspection.problems)


def _section(title: str, content: Iterable[str]) -> Iterator[str]:
    indented = [f"  {line}" for line in content]
    if indented:
        yield from ("", title, *indented)


def _link_rows(inspection: Inspection) -> Iterator[tuple[str, ...]]:
    yield "LINK", "MASS [kg]", "SOLID SHAPES"
    yield from ((link.name, f"{link.mass:.4g}", str(link.solids)) for link in inspection.links)


def _joint_rows(joints: Iterable[ModelJoint]) -> Iterator[tuple[str, ...]]:
    yield "JOINT", "TYPE", "LINK", "FROM", "TO", "EFFORT", "VELOCITY"
    for joint in joints:
        limits = (joint.lower, joint.upper, joint.effort, joint.velocity)
        yield (
            joint.name,
            joint.kind,
            joint.child,
            *("-" if math.isinf(each) else f"{each:.4g}" for each in limits),
        )


def _table(rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    listed = list(rows)
    widths = [max(map(len, column)) for column in zip(*listed, strict=True)]
    for row in listed:
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()


def _declared_lines(declaration: Mapping[str, object]) -> list[str]:
    return _yaml(declaration).splitlines()
