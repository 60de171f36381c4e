"""Broker of a sandboxed run: a process outside the sandbox, with the keys and the connections.

The run requests endpoints. For each endpoint that the policy allows, the broker connects, and forwards bytes to
and from a socket file in the sandbox. It signs commands to nodes only.
"""

from __future__ import annotations

import asyncio
import os
import re
import socket
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgpack

from seoro.bridges.session import Session, SessionError
from seoro.bridges.session.brokered import CREDENTIALS, LENGTH, REACH, SIGN
from seoro.bridges.wire.keys import NAMESPACE, node_command
from seoro.errors import UsageError
from seoro.executor.job import Job
from seoro.executor.permissions import vet_endpoint
from seoro.executor.sandbox.command import TEMPORARY
from seoro.security.keys.roles import MOVING
from seoro.security.network.endpoint_keys import check_reached, node_keys, security_of

if TYPE_CHECKING:
    import ssl

    from seoro.security.keys.folder import Keys

LARGEST: Final = 1 << 16  # [bytes] of a request
CHUNK: Final = 1 << 18  # [bytes] passed on at a time
CONNECT_TIMEOUT: Final = 10.0  # [s]
_NODES: Final = node_command(NAMESPACE, "any", "*").rpartition("any")[0]
_NETWORK: Final = re.compile(r"(?P<kind>tcp|tls)/(?P<host>\[[^\]]+\]|[^\[\]:/?#]+):(?P<port>\d{1,5})([?#].*)?")
_SOCKET: Final = "unixsock-stream/"

_Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]


class Refused(Exception):
    """A request of the run was rejected."""


def work(connection: socket.socket, job: Job, process: int) -> int:
    """Serve a run until a process ends; returns the exit status of that process.

    Args:
        connection: Connection to the sandbox.
        job: The run.
        process: Process that has joined the sandbox.
    """
    return asyncio.run(Broker(job).serve(connection, process))


class Broker:
    """Serves one run.

    Args:
        job: The run.
    """

    def __init__(self, job: Job) -> None:
        self._job = job
        self._folder = os.open(Path(job.home) / TEMPORARY, os.O_PATH | os.O_DIRECTORY)
        self._reached: dict[str, str] = {}
        self._keys: Keys | None = None
        self._servers: list[asyncio.Server] = []
        self._relays: set[asyncio.Task[None]] = set()

    async def serve(self, connection: socket.socket, process: int) -> int:
        """Answer requests until a process ends; returns its exit status."""
        ended = asyncio.Event()
        watched = os.pidfd_open(process)
        asyncio.get_running_loop().add_reader(watched, ended.set)
        serving = asyncio.create_task(self.answer(connection))
        await ended.wait()
        serving.cancel()
        _, status = os.waitpid(process, 0)  # noqa: ASYNC222 - it has ended
        return os.waitstatus_to_exitcode(status)

    async def answer(self, connection: socket.socket) -> None:
        """Answer the requests of the run, to the end of its connection."""
        reader, writer = await asyncio.open_connection(sock=connection)
        with suppress(asyncio.IncompleteReadError, ConnectionError), closing(writer):
            while True:
                [length] = LENGTH.unpack(await reader.readexactly(LENGTH.size))
                if length > LARGEST:
                    return
                answer = msgpack.packb(await self._handle(await reader.readexactly(length)))
                writer.write(LENGTH.pack(len(answer)) + answer)
                await writer.drain()

    async def _handle(self, request: bytes) -> list[Any]:
        try:
            verb, argument = msgpack.unpackb(request)
            match verb:
                case "reach" if isinstance(argument, str):
                    return [True, await self._reach(argument), ""]
                case "sign" if isinstance(argument, bytes):
                    return [True, self._sign(argument), ""]
                case "credentials" if isinstance(argument, str):
                    return [True, self._credentials(argument), ""]
            return [False, f"unknown request of a sandbox; known: {REACH}, {SIGN}, {CREDENTIALS}", ""]
        except UsageError as error:
            return [False, str(error), error.help or ""]
        except Refused as error:
            return [False, str(error), ""]
        except (ValueError, msgpack.UnpackException):
            return [False, "unreadable request of a sandbox", ""]
        except OSError as error:
            return [False, f"cannot read the keys of the executor: {error}", ""]

    # -------------------------------------------------------- keys

    def _credentials(self, endpoint: str) -> list[bytes] | None:
        """Return the certificates for an endpoint and the list of revoked ones; None without keys."""
        vet_endpoint(endpoint, self._job.allowed, self._job.reach)
        keys = node_keys(endpoint, MOVING)
        if keys is None:
            return None
        self._keys = keys
        folder = keys.folder
        return [file.read_bytes() for file in (folder.authority, folder.certificate, folder.revoked)]

    def _sign(self, data: bytes) -> bytes:
        from seoro.security.signing.commands import is_command, sign_bytes  # noqa: PLC0415 - only where there are keys

        if self._keys is None:
            raise Refused("missing keys to sign with")
        if not is_command(data, _NODES):
            raise Refused("invalid data to sign: a sandboxed run signs commands to nodes only")
        return sign_bytes(self._keys, data)

    # -------------------------------------------------------- connections

    async def _reach(self, endpoint: str) -> str:
        if endpoint not in self._reached:
            vet_endpoint(endpoint, self._job.allowed, self._job.reach)
            self._check_place(endpoint)
            await asyncio.to_thread(_check, endpoint)
            self._reached[endpoint] = await self._listen(endpoint)
        return self._reached[endpoint]

    def _check_place(self, endpoint: str) -> None:
        """Check that an endpoint is supported, and that the run cannot replace it."""
        if endpoint.startswith(_SOCKET):
            path = Path(endpoint.removeprefix(_SOCKET))
            own = [Path(folder) for folder in (self._job.home, self._job.output)]
            is_own = any(each.is_relative_to(folder) for each in (path, path.resolve()) for folder in own)
            if is_own or ".." in path.parts or not path.is_absolute():
                raise Refused(f"cannot connect to {endpoint} from a sandbox: expected an absolute path outside")
        elif not _NETWORK.fullmatch(endpoint):
            known = "tcp, tls, unixsock-stream"
            raise Refused(f"cannot connect to {endpoint} from a sandbox: expected one of {known}")

    async def _listen(self, endpoint: str) -> str:
        """Forward connections to a new socket file; returns its path in the sandbox."""

        async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            try:
                there = await self._connect(endpoint)
            except Refused:
                writer.close()
                return
            for source, target in ((reader, there[1]), (there[0], writer)):
                task = asyncio.create_task(_pass_on(source, target))
                self._relays.add(task)
                task.add_done_callback(self._relays.discard)

        name = f"seoro-reach-{len(self._reached)}.sock"
        # A short path: those of sockets are limited to a hundred characters.
        self._servers.append(
            await asyncio.start_unix_server(accept, f"/proc/self/fd/{self._folder}/{name}", limit=CHUNK)
        )
        return f"/tmp/{name}"  # noqa: S108 - in the sandbox

    async def _connect(self, endpoint: str) -> _Connection:
        try:
            async with asyncio.timeout(CONNECT_TIMEOUT):
                if endpoint.startswith(_SOCKET):
                    return await asyncio.open_unix_connection(endpoint.removeprefix(_SOCKET), limit=CHUNK)
                match = _NETWORK.fullmatch(endpoint)
                assert match is not None, "checked before"
                context = self._context(endpoint) if match["kind"] == "tls" else None
                host = match["host"].strip("[]")
                return await asyncio.open_connection(host, int(match["port"]), ssl=context, limit=CHUNK)
        except (OSError, TimeoutError) as error:
            reason = getattr(error, "reason", None) or "nothing answers there"  # OpenSSL has a reason
            raise Refused(f"cannot connect to {endpoint}: {reason}") from error

    def _context(self, endpoint: str) -> ssl.SSLContext:
        import ssl  # noqa: PLC0415 - only where there are keys

        keys = node_keys(endpoint, MOVING)
        assert keys is not None, "endpoints of TLS need them"
        context = ssl.create_default_context(cafile=str(keys.folder.authority))
        context.minimum_version = ssl.TLSVersion.TLSv1_3
        context.load_cert_chain(keys.folder.certificate, keys.folder.key)
        return context


def _check(endpoint: str) -> None:
    """Check that Zenoh answers at an endpoint: the run could send any bytes to another service.

    Raises:
        UsageError, Refused: The connection failed.
    """
    keys = node_keys(endpoint, MOVING)
    security = security_of(endpoint, keys)
    try:
        Session(connect=endpoint, security=security).close()
    except SessionError as error:
        check_reached(endpoint, security)
        raise Refused(str(error)) from error


async def _pass_on(source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await source.read(CHUNK):
            target.write(data)
            await target.drain()
    with suppress(OSError):
        target.close()
