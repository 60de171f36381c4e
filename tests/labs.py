"""Labs for tests: keys that were really made, and executors that listen with them."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from seoro.security.keys.authority import Authority, init_authority
from seoro.security.keys.folder import KeyFolder
from seoro.security.keys.roles import Role

NAME = "lab-a"
HOLDERS = {
    NAME: Role.EXECUTOR,
    "vera": Role.VIEWER,
    "anna": Role.OPERATOR,
    "ada": Role.ADMIN,
    "maze": Role.NODE,
    "hub": Role.ROUTER,
}


@dataclass(frozen=True)
class KeyedLab:
    """The keys of a lab: a folder for its authority, and one for each holder."""

    path: Path
    authority: Authority

    def keys(self, name: str) -> Path:
        """Return the key folder of a holder."""
        return self.path / name

    def revoke(self, name: str, *informed: str) -> None:
        """Revoke an identity, and give some holders the new list."""
        self.authority.revoke(name)
        for each in informed:
            KeyFolder(self.keys(each)).revoked.write_bytes((self.path / "ca" / "revoked.crl").read_bytes())


def make_lab(path: Path, lab: str = "demo") -> KeyedLab:
    """Make a lab with a holder of each role."""
    authority = init_authority(path / "ca", lab)
    for name, role in HOLDERS.items():
        authority.add(name, role, path / name)
    return KeyedLab(path, authority)


def free_port() -> int:
    """Return an unused port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@dataclass(frozen=True)
class RunningCommand:
    """A running command with an endpoint."""

    endpoint: str
    process: subprocess.Popen[bytes]
    errors: Path


@contextmanager
def command(errors: Path, endpoint: str, *arguments: str) -> Iterator[RunningCommand]:
    """A command of seoro that runs until Ctrl-C, once it has printed that it is ready."""
    with (
        errors.open("wb") as log,
        subprocess.Popen(
            [sys.executable, "-m", "seoro", *arguments], stdout=subprocess.PIPE, stderr=log
        ) as process,
    ):
        try:
            assert process.stdout is not None
            assert b"Ctrl-C" in process.stdout.readline(), errors.read_text()
            yield RunningCommand(endpoint, process, errors)
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


@contextmanager
def keyed_executor(
    folder: Path, lab: KeyedLab, *options: str, connect: str | None = None
) -> Iterator[RunningCommand]:
    """An executor with keys, at a port of this machine or over a hub."""
    endpoint = connect or f"tls/127.0.0.1:{free_port()}"
    place = ["--listen" if connect is None else "--connect", endpoint]
    keys = ["--keys", str(lab.keys(NAME))]
    state = ["--folder", str(folder / "state")]
    with command(folder / "serve.log", endpoint, "serve", *place, *keys, *state, *options) as running:
        yield running
