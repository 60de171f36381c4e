"""A person who types commands into a shell on a terminal."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import termios
import time
from pathlib import Path
from typing import Final

SPEED: Final = 200.0 / 60.0  # [characters/s], forty words a minute
_PROMPT: Final = "ready> "
_STATUS: Final = re.compile(rb"status=(\d+)\r?\n")
_COLUMNS: Final = 200
_PATIENCE: Final = 300.0  # [s] for a command on a busy machine


class Person:
    """Types into an interactive shell. Close it at the end.

    Args:
        folder: Working directory.
        programs: Folder that comes first in `PATH`.
    """

    def __init__(self, folder: Path, programs: Path) -> None:
        own, shells = pty.openpty()
        termios.tcsetwinsize(own, (40, _COLUMNS))
        identity = {f"GIT_{who}_{what}": "user" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
        environment = {
            **identity,
            "PATH": f"{programs}:{os.environ['PATH']}",
            "HOME": str(folder),
            "PS1": _PROMPT,
            "TERM": "dumb",
            "LANG": "C.UTF-8",
        }
        self._shell = subprocess.Popen(
            ["bash", "--norc", "--noprofile", "-i"],
            cwd=folder,
            env=environment,
            stdin=shells,
            stdout=shells,
            stderr=shells,
            start_new_session=True,
        )
        os.close(shells)
        self._terminal = own
        self.characters = 0
        self._until(_PROMPT.encode())

    def type(self, command: str) -> tuple[int, str]:
        """Type a command; return its exit status and what the terminal shows after it."""
        self.characters += len(command) + 1
        os.write(self._terminal, f"{command}\n".encode())
        shown = self._until(_PROMPT.encode())
        os.write(self._terminal, b"echo status=$?\n")
        found = _STATUS.search(self._until(_PROMPT.encode()))
        assert found is not None
        text = shown.decode(errors="replace").replace("\r\n", "\n").removesuffix(_PROMPT)
        return int(found[1]), text.partition("\n")[2]

    def _until(self, end: bytes) -> bytes:
        """Return what the terminal shows until it ends so."""
        shown, limit = b"", time.monotonic() + _PATIENCE
        while not shown.endswith(end):
            ready, _, _ = select.select([self._terminal], [], [], max(0.0, limit - time.monotonic()))
            assert ready, f"nothing more was shown: {shown.decode(errors='replace')}"
            shown += os.read(self._terminal, 1 << 16)
        return shown

    def close(self) -> float:
        """End the shell; return the processor time of its commands [s], 0 if it has ended."""
        if self._shell.returncode is not None:
            return 0.0
        os.write(self._terminal, b"\x03\nexit\n")
        _, _, usage = os.wait4(self._shell.pid, 0)
        self._shell.returncode = 0
        os.close(self._terminal)
        return usage.ru_utime + usage.ru_stime
