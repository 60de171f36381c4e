"""Lines between the pool and its workers, apart from planned runs and rows. It imports nothing of runs."""

from __future__ import annotations

from typing import Final

from pydantic import BaseModel, ConfigDict

STOP: Final = b"stop\n"
FATAL: Final = b"!"  # begins a line to the coordinator that ends the campaign
LOST: Final = b"lost\n"  # the line to the coordinator of a worker without a simulator


class Start(BaseModel):
    """First line to a worker.

    Attributes:
        name: Its name.
        endpoint: Endpoint of its simulator; empty without one.
        simulator: Process id of the simulator.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    endpoint: str = ""
    simulator: int | None = None
