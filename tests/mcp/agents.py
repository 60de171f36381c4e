"""An agent: a client of the SDK with a real server as its child process."""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from mcp import StdioServerParameters
from mcp.client.client import Client

PATIENCE = 120.0  # [s] to wait for an answer on a busy machine


class Agent:
    """A connected client."""

    def __init__(self, client: Client) -> None:
        self.client = client

    async def call(self, tool: str, **arguments: Any) -> dict[str, Any]:
        """Call a tool; its answer has the structure that it declares, which the client checks."""
        found = await self.client.call_tool(tool, arguments)
        assert not found.is_error, found.content
        answer: dict[str, Any] = found.structured_content
        return answer

    async def error(self, tool: str, **arguments: Any) -> str:
        """Return the error of a call."""
        found = await self.client.call_tool(tool, arguments)
        assert found.is_error, found.structured_content
        [content] = found.content
        assert content.type == "text"
        return content.text


@asynccontextmanager
async def connected(folder: Path, *options: str) -> AsyncIterator[Agent]:
    """Provide an agent while the block lasts."""
    server = StdioServerParameters(
        command=sys.executable,
        args=["-m", "seoro", "mcp", *options, str(folder)],
        env={"PYTHONWARNINGS": "default"},
    )
    async with Client(server, read_timeout_seconds=PATIENCE) as client:
        yield Agent(client)
