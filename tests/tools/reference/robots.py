"""Robots by reference, from their declarations."""

from __future__ import annotations

from seoro.files.yaml_lines import read_text, read_yaml
from sim_nodes.robots.references.catalogue import available_references, find_reference
from tests.tools.reference.tables import code, table


def referenced_robots() -> str:
    """Return a table of the robots whose models are in packages."""
    rows = []
    for name in available_references():
        found = find_reference(name)
        drive = read_yaml(read_text(found.path), found.path.name)["drive"]
        rows.append(
            (code(name), code(str(drive)), f"{found.source.package} {found.source.version}", found.source.licence)
        )
    return table(("robot", "drive", "package, tried with", "licence"), rows)
