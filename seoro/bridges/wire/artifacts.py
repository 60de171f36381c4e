"""What is left at the end of a run."""

from __future__ import annotations

from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Verb


class Artifact(Message):
    """A file for the output folder of a run."""

    name: str
    media_type: str
    description: str
    data: bytes


class Artifacts(Message):
    """What a node has to show of the run so far."""

    artifacts: tuple[Artifact, ...]


GET_ARTIFACTS = Verb("get_artifacts", Empty, Artifacts, answers=BYTES)
