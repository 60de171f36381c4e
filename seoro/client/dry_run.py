"""Dry runs on an executor: check a scenario there, with its parameter values and files."""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bundle.pack import Bundle
from seoro.client.abilities import check_ability
from seoro.client.uploading import with_files
from seoro.embed.run_end import InvalidEnd, NotStarted, unpack_end
from seoro.embed.whoami import whoami
from seoro.errors import BackendError


@dataclass(frozen=True)
class DryRun:
    """Result of a dry run on an executor.

    Args:
        seed: Seed of the run.
        parameters: Value of every parameter.
        texts: The same values as text of the language.
        files: Number of files of the scenario.
        size: Size of all files [bytes].
        known: Number of files that the executor had before.
    """

    seed: int
    parameters: Mapping[str, object]
    texts: Mapping[str, str]
    files: int
    size: int
    known: int


async def dry_run_bundle(executor: Executor, bundle: Bundle) -> DryRun:
    """Try a bundle on an executor.

    Raises:
        InvalidScenario, UsageError, BackendError: It cannot be run there.
    """
    await check_ability(executor, bundle, is_dry=True)
    missing: frozenset[str] = frozenset()

    async def ask(sent: tuple[str, ...]) -> wire.DryRunResult:
        nonlocal missing
        missing = missing or frozenset(sent)
        request = wire.DryRun(run=secrets.token_hex(16), manifest=bundle.manifest, by=whoami(), sent=sent)
        return await executor.ask(wire.DRY_RUN, request, wire.LONGEST_DRY_RUN)

    tried = await with_files(executor, bundle, ask)
    if tried.end:
        _refuse(tried.end)
    if tried.seed is None:
        raise BackendError("invalid reply of the executor: the result of the dry run is missing")
    files = bundle.manifest.files
    return DryRun(
        tried.seed,
        json.loads(tried.parameters),
        json.loads(tried.texts),
        len(files),
        sum(file.size for file in files),
        sum(file.hash not in missing for file in files),
    )


def _refuse(data: bytes) -> None:
    try:
        end = unpack_end(data)
    except InvalidEnd as error:
        raise BackendError(str(error)) from error
    if isinstance(end, NotStarted):
        raise end.error
