"""Codes of diagnostics, from their explanations."""

from __future__ import annotations

from seoro.lang.explain import PHASES, explanations
from tests.tools.reference.tables import table


def codes() -> str:
    """Return a table of codes for each phase."""
    parts = []
    for prefix, phase in PHASES.items():
        rows = [(item.code, item.title) for item in explanations() if item.code.startswith(prefix)]
        parts.append(f"## {phase}\n\n{table(('code', 'meaning'), rows)}")
    return "\n".join(parts)
