"""An editor with a real language server: it sends plain JSON over its stdin and stdout."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any

PATIENCE = 20.0  # [s] to wait for an answer on a busy machine
SEORO = (sys.executable, "-m", "seoro", "lsp")


class Refused(Exception):
    """An error answer to a request."""


class Editor:
    """An editor with its own server.

    Args:
        folder: Opened folder.
        server: Command of the server.
        language: Name of the language of its documents.
    """

    def __init__(self, folder: Path, server: Sequence[str] = SEORO, language: str = "osc") -> None:
        self.folder = folder
        self._server, self._language = server, language
        self.published: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.refusals: asyncio.Queue[dict[str, Any]] = asyncio.Queue()  # of messages without a known id
        self._answers: dict[int, asyncio.Future[Any]] = {}
        self._numbers = count(1)
        self._versions: dict[str, int] = {}

    async def start(self) -> dict[str, Any]:
        """Start and initialize the server; return its capabilities."""
        self.process = await asyncio.create_subprocess_exec(
            *self._server,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
        )
        self._reading = asyncio.create_task(self._read())
        folders = [{"uri": self.folder.as_uri(), "name": "test"}]
        parameters: dict[str, Any] = {
            "processId": None,
            "rootUri": None,
            "capabilities": {},
            "workspaceFolders": folders,
        }
        found = await self.ask("initialize", parameters)
        self.notify("initialized", {})
        capabilities: dict[str, Any] = found["capabilities"]
        return capabilities

    async def _read(self) -> None:
        assert self.process.stdout is not None
        while header := await self.process.stdout.readline():
            if header.startswith(b"Content-Length:"):
                length = int(header.split(b":")[1])
            if header.strip():
                continue
            message = json.loads(await self.process.stdout.readexactly(length))
            if "id" in message and message["id"] is None:
                self.refusals.put_nowait(message["error"])
            elif "id" in message and "method" in message:  # a request of the server
                self.send({"jsonrpc": "2.0", "id": message["id"], "result": None})
            elif "id" in message:
                answer = self._answers.pop(message["id"])
                if "error" in message:
                    answer.set_exception(Refused(message["error"]["message"]))
                else:
                    answer.set_result(message.get("result"))
            elif message["method"] == "textDocument/publishDiagnostics":
                self.published.put_nowait(message["params"])

    def send(self, message: Any) -> None:
        """Send any message, also invalid ones."""
        assert self.process.stdin is not None
        body = json.dumps(message).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))

    def send_bytes(self, data: bytes) -> None:
        """Send any bytes, also invalid messages."""
        assert self.process.stdin is not None
        self.process.stdin.write(data)

    def notify(self, method: str, parameters: Any) -> None:
        """Send a notification."""
        self.send({"jsonrpc": "2.0", "method": method, "params": parameters})

    async def ask(self, method: str, parameters: Any) -> Any:
        """Send a request; return the answer."""
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        self.send({"jsonrpc": "2.0", "id": number, "method": method, "params": parameters})
        async with asyncio.timeout(PATIENCE):
            return await self._answers[number]

    async def ask_at(self, method: str, name: str, text: str, place: str, **more: Any) -> Any:
        """Send a request about the mark `|` of `place`, which is part of the text; return the answer."""
        offset = text.index(place.replace("|", "")) + place.index("|")
        before = text[:offset].split("\n")
        position = {"line": len(before) - 1, "character": len(before[-1])}
        document = {"uri": self.uri(name)}
        return await self.ask(method, {"textDocument": document, "position": position, **more})

    # ------------------------------------------------------------ documents

    def uri(self, name: str) -> str:
        return (self.folder / name).as_uri()

    def open(self, name: str, text: str) -> None:
        self._versions[name] = 1
        item = {"uri": self.uri(name), "languageId": self._language, "version": 1, "text": text}
        self.notify("textDocument/didOpen", {"textDocument": item})

    def change(self, name: str, text: str) -> int:
        """Change a text; return the number of its version."""
        self._versions[name] += 1
        version = self._versions[name]
        document = {"uri": self.uri(name), "version": version}
        self.notify("textDocument/didChange", {"textDocument": document, "contentChanges": [{"text": text}]})
        return version

    def close(self, name: str) -> None:
        self.notify("textDocument/didClose", {"textDocument": {"uri": self.uri(name)}})

    async def diagnostics(self, name: str, version: int | None = None) -> list[dict[str, Any]]:
        """Return the next diagnostics of a document, by default of any version."""
        async with asyncio.timeout(PATIENCE):
            while True:
                found = await self.published.get()
                if found["uri"] == self.uri(name) and version in {None, found.get("version")}:
                    shown: list[dict[str, Any]] = found["diagnostics"]
                    return shown

    async def shown(self, name: str, text: str) -> list[dict[str, Any]]:
        """Open a document; return its diagnostics."""
        self.open(name, text)
        return await self.diagnostics(name, 1)

    # ------------------------------------------------------------ the end

    async def stop(self) -> int:
        """Stop the server as an editor does; return its exit status."""
        await self.ask("shutdown", None)
        self.notify("exit", None)
        return await self.wait()

    async def wait(self) -> int:
        """Wait for the end of the server; return its exit status."""
        async with asyncio.timeout(PATIENCE):
            await self._reading
            return await self.process.wait()
