"""Dry runs on an executor: whether a scenario could be run there, with which values, and what would be sent."""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bundle.packing import Bundle
from seoro.client.abilities import check_ability
from seoro.client.uploading import with_files
from seoro.embed.ends import InvalidEnd, NotRun, unpack_end
from seoro.errors import BackendError
from seoro.people import whoami


@dataclass(frozen=True)
class DryRun:
    """A run that could be, on an executor.

    Args:
        seed: What it would draw from.
        parameters: The chosen value of every parameter.
        texts: The same as the language writes them.
        files: How many files it consists of.
        size: Of all of them [bytes].
        known: How many of them the executor had before.
    """

    seed: int
    parameters: Mapping[str, object]
    texts: Mapping[str, str]
    files: int
    size: int
    known: int


async def try_bundle(executor: Executor, bundle: Bundle) -> DryRun:
    """Try a bundle on an executor.

    Raises:
        InvalidScenario, InvalidUse, BackendError: It cannot be run there.
    """
    await check_ability(executor, bundle, is_dry=True)
    missing: frozenset[str] = frozenset()

    async def ask(sent: tuple[str, ...]) -> wire.Tried:
        nonlocal missing
        missing = missing or frozenset(sent)
        request = wire.DryRun(run=secrets.token_hex(16), manifest=bundle.manifest, by=whoami(), sent=sent)
        return await executor.ask(wire.DRY_RUN, request, wire.LONGEST_DRY_RUN)

    tried = await with_files(executor, bundle, ask)
    if tried.end:
        _refuse(tried.end)
    if tried.seed is None:
        raise BackendError("the executor does not say how the dry run went")
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
    if isinstance(end, NotRun):
        raise end.error
