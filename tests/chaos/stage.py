"""The lab of the chaos test: a router, a simulator and two executors, as processes behind links with faults."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from tests.chaos.plan import EXECUTORS, LINKS
from tests.faults import link
from tests.routers import free_endpoint

TAG: Final = "SEORO_CHAOS"  # of the environment: marks the processes of a stage
START: Final = 60.0  # [s] that a part may take to be ready
END: Final = 20.0  # [s] that a part may take to end


@dataclass
class Part:
    """A process of the lab.

    Args:
        name: Its name.
        command: Its command line.
        environment: Its environment.
        log: File for its stderr.
        process: The process; None while it is down.
        is_ready: Whether it has printed that it is ready.
    """

    name: str
    command: list[str]
    environment: dict[str, str]
    log: Path
    process: subprocess.Popen[str] | None = None
    is_ready: bool = False

    def start(self) -> None:
        """Start the process; it is not ready yet."""
        self.is_ready = False
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                self.command, stdout=subprocess.PIPE, stderr=log, env=self.environment, text=True
            )

    def wait_until_ready(self) -> None:
        """Wait for the line that marks it as ready.

        Raises:
            AssertionError: It has ended instead.
        """
        assert self.process is not None
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, f"{self.name} has ended: {self.log.read_text()[-2000:]}"
        self.is_ready = True

    def signal(self, number: int) -> None:
        """Send a signal, if the process is there."""
        if self.process is not None and self.process.poll() is None:
            self.process.send_signal(number)

    def kill(self) -> None:
        """Kill it as `kill -9` does."""
        self.signal(signal.SIGKILL)
        if self.process is not None:
            self.process.wait(END)
            assert self.process.stdout is not None
            self.process.stdout.close()
            self.process = None

    def stop(self) -> int | None:
        """Stop it as Ctrl-C does; returns its exit status, None if it had to be killed."""
        if self.process is None:
            return 0
        self.signal(signal.SIGCONT)
        self.signal(signal.SIGINT)
        try:
            return self.process.wait(END)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.kill()


@dataclass
class Link:
    """A link between a part and the router, whose faults are set by lines of JSON.

    Args:
        endpoint: Endpoint that the part connects to.
        process: The process that carries the connections.
    """

    endpoint: str
    process: subprocess.Popen[str]

    def set(self, **faults: float | bool) -> None:
        """Set the faults of the link; none without arguments."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(faults) + "\n")
        self.process.stdin.flush()
        self.process.stdout.readline()


@dataclass
class Stage:
    """The lab.

    Args:
        folder: Folder for all of its files.
        parts: Its processes, by name.
        links: Its links, by the name of the part; those of clients are `clients`.
    """

    folder: Path
    parts: dict[str, Part] = field(default_factory=dict)
    links: dict[str, Link] = field(default_factory=dict)

    def heal(self) -> None:
        """Undo all faults: links carry, frozen parts go on, dead ones are started."""
        for each in self.links.values():
            each.set()
        for part in self.parts.values():
            part.signal(signal.SIGCONT)
            if part.process is None or part.process.poll() is not None:
                part.kill()
                part.start()
            if not part.is_ready:
                self._await(part)

    @staticmethod
    def _await(part: Part) -> None:
        """Wait until a part is ready; one that found no router when it started has ended, and is started again."""
        try:
            part.wait_until_ready()
        except AssertionError:
            part.kill()
            part.start()
            part.wait_until_ready()

    def strangers(self) -> list[str]:
        """Processes of the stage that belong to no part, with their command lines."""
        own = {part.process.pid for part in self.parts.values() if part.process is not None}
        own |= {each.process.pid for each in self.links.values()}
        found = {pid: parent for pid, parent in _tagged(str(self.folder)).items() if pid not in own}
        # The processes that fork runs are children of executors.
        return [_command_line(pid) for pid, parent in found.items() if parent not in own]

    def runs_of(self, executor: str) -> list[int]:
        """Processes of runs of an executor, behind the one that forks them, which comes first."""
        process = self.parts[executor].process
        if process is None:
            return []
        fork_servers = _children(process.pid)
        return [*fork_servers, *(run for server in fork_servers for run in _children(server))]


@contextmanager
def staged(folder: Path) -> Iterator[Stage]:
    """Set a lab up, and stop it after the block."""
    environment = {
        **os.environ,
        TAG: str(folder),
        "TMPDIR": str(folder / "tmp"),
        "XDG_STATE_HOME": str(folder / "state"),
        "PYTHONUNBUFFERED": "1",
    }
    (folder / "tmp").mkdir(parents=True, exist_ok=True)
    stage = Stage(folder)
    router = free_endpoint()
    try:
        for name in LINKS:
            stage.links[name] = _link(router, environment)
        commands = {
            "router": ["router", "--listen", router],
            "simulator": ["sim", "mujoco", "--world", "hall", "--rate", "1", "--node", "hall"],
            **{
                name: ["serve", "--jobs", "3", "--folder", str(folder / name), "--name", name]
                for name in EXECUTORS
            },
        }
        for name, arguments in commands.items():
            command = [sys.executable, "-m", "seoro", *arguments]
            command += ["--connect", stage.links[name].endpoint] if name in stage.links else []
            stage.parts[name] = Part(name, command, environment, folder / f"{name}.log")
            stage.parts[name].start()
            stage.parts[name].wait_until_ready()
        yield stage
    finally:
        for part in reversed(stage.parts.values()):
            part.stop()
        for each in stage.links.values():
            with suppress(OSError):
                each.process.kill()
                each.process.communicate(timeout=END)


def _link(router: str, environment: dict[str, str]) -> Link:
    endpoint = free_endpoint()
    ports = [each.rpartition(":")[2] for each in (endpoint, router)]
    command = [sys.executable, str(Path(link.__file__)), "connection", *ports]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    return Link(endpoint, process)


def _tagged(tag: str) -> dict[int, int]:
    """Processes with the tag in their environment, and their parents."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            with suppress(OSError):
                if f"{TAG}={tag}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                    stat = (entry / "stat").read_text().rpartition(")")[2].split()
                    if stat[0] != "Z":
                        found[int(entry.name)] = int(stat[1])
    return found


def _children(pid: int) -> list[int]:
    with suppress(OSError):
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return []


def _command_line(pid: int) -> str:
    with suppress(OSError):
        return f"{pid}: " + Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return f"{pid}: ended"


def until(condition: object, limit: float) -> bool:
    """Poll a condition; return False if it does not hold in time [s]."""
    end = time.monotonic() + limit
    while not condition():  # type: ignore[operator]
        if time.monotonic() > end:
            return False
        time.sleep(0.1)
    return True
