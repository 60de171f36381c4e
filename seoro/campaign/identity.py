"""Identities of runs: hashes of everything that determines them.

Equal ids promise equal runs. So runs that were made twice are harmless.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from seoro.bridges.executor.messages import Manifest
from seoro.campaign.runs import Planned, Row

DIGITS = 16  # hexadecimal


def digest_of(manifest: Manifest, simulator: str, version: str) -> str:
    """Hash what all runs of a campaign share: the files, the options, and the versions.

    Args:
        manifest: Bundle of the scenario.
        simulator: Name and version of the simulator; empty without one.
        version: Version of seoro.
    """
    options = manifest.options.model_dump(mode="json", exclude={"seed", "film"})
    shared = {
        "files": {file.path: file.hash for file in manifest.files},
        "entry": manifest.entry,
        "options": options,
        "simulator": simulator,
        "version": version,
    }
    return _hash(shared)


def run_id(digest: str, values: Mapping[str, str], seed: int) -> str:
    """Return the identity of a run.

    Args:
        digest: Of the campaign.
        values: Values of its parameters, by path.
        seed: Its seed.
    """
    return _hash([digest, dict(values), seed])[:DIGITS]


def row_of(planned: Planned, digest: str, version: str, **fields: Any) -> Row:
    """Return the row of a planned run.

    Args:
        planned: The run.
        digest: Of the campaign.
        version: Version of seoro.
        fields: The other fields of the row.
    """
    return Row(
        run=planned.number,
        id=run_id(digest, planned.values, planned.seed),
        variant=planned.variant,
        repeat=planned.repeat,
        seed=planned.seed,
        strategy=planned.strategy,
        parent=planned.parent,
        attempt=planned.attempt,
        version=version,
        **fields,
    )


def _hash(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
