"""A link with faults, as a process; lines of JSON on its stdin set the faults of its traffic.

    python link.py packets NAMESPACE          between this network namespace and a new one
    python link.py connection LISTEN TARGET   between clients of a port and another port

The first carries IP packets between two TUN devices; the TCP of the kernel handles lost, late and duplicate
packets. The second needs no privileges: lost data arrives late, as with TCP.
"""

from __future__ import annotations

import asyncio
import fcntl
import heapq
import json
import os
import random
import select
import struct
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from itertools import count
from pathlib import Path

NEAR, FAR = "10.231.7.1", "10.231.7.2"
RETRANSMISSION = 0.3  # [s] until a connection delivers lost data
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 0x0001, 0x1000  # linux/if_tun.h


@dataclass
class Faults:
    """Faults of the traffic in each direction.

    Args:
        loss: Share of lost data.
        duplicate: Share of duplicate data.
        delay: Delay [s].
        cut: Whether all traffic is stopped.
    """

    loss: float = 0.0
    duplicate: float = 0.0
    delay: float = 0.0
    cut: bool = False


def packets(namespace: str) -> None:
    """Carry packets until stdin ends. Only one such link runs at a time, because its devices have names."""
    alone = Path(tempfile.gettempdir(), "seoro-link.lock").open("w")  # noqa: SIM115 - until the process ends
    fcntl.flock(alone, fcntl.LOCK_EX)
    near, far = _tun("seoro-near"), _tun("seoro-far")
    inside = ["ip", "netns", "exec", namespace]
    for command in (
        ["ip", "link", "set", "seoro-far", "netns", namespace],
        ["ip", "address", "add", f"{NEAR}/30", "dev", "seoro-near"],
        ["ip", "link", "set", "seoro-near", "up"],
        [*inside, "ip", "address", "add", f"{FAR}/30", "dev", "seoro-far"],
        [*inside, "ip", "link", "set", "seoro-far", "up"],
        [*inside, "ip", "link", "set", "lo", "up"],
    ):
        subprocess.run(command, check=True)
    chance, faults, numbers = random.Random(1), Faults(), count()
    late: list[tuple[float, int, int, bytes]] = []
    _say("ready")
    while True:
        wait = max(late[0][0] - time.monotonic(), 0.0) if late else None
        ready, _, _ = select.select([near, far, sys.stdin], [], [], wait)
        if sys.stdin in ready:
            line = sys.stdin.readline()
            if not line:
                return
            faults = Faults(**json.loads(line))
            _say("done")
        for source, to in ((near, far), (far, near)):
            if source in ready:
                packet = os.read(source, 65_536)
                if not faults.cut and chance.random() >= faults.loss:
                    for _ in range(2 if chance.random() < faults.duplicate else 1):
                        heapq.heappush(late, (time.monotonic() + faults.delay, next(numbers), to, packet))
        while late and late[0][0] <= time.monotonic():
            _, _, to, packet = heapq.heappop(late)
            os.write(to, packet)


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _tun(name: str) -> int:
    """A device whose packets are read and written here."""
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, _TUNSETIFF, struct.pack("16sH22s", name.encode(), _IFF_TUN | _IFF_NO_PI, b""))
    return device


class Proxy:
    """Carries connections.

    Args:
        target: Port to which they lead.
    """

    def __init__(self, target: int) -> None:
        self._target = target
        self._faults = Faults()
        self._chance = random.Random(1)
        self._whole = asyncio.Event()
        self._whole.set()

    def set(self, faults: Faults) -> None:
        """Change the faults of the traffic."""
        self._faults = faults
        (self._whole.clear if faults.cut else self._whole.set)()

    async def carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry a connection, to the end of one of its sides."""
        await self._whole.wait()
        try:
            other_reader, other_writer = await asyncio.open_connection("127.0.0.1", self._target)
        except ConnectionError:  # no listener: the other side is being killed or restarted
            writer.close()
            return
        ways = [self._pump(reader, other_writer), self._pump(other_reader, writer)]
        done, rest = await asyncio.wait(
            [asyncio.ensure_future(way) for way in ways], return_when=asyncio.FIRST_COMPLETED
        )
        for way in (*done, *rest):
            way.cancel()
        for each in (writer, other_writer):
            each.close()

    async def _pump(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        late: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()

        async def deliver() -> None:
            while True:
                due, data = await late.get()
                await asyncio.sleep(due - time.monotonic())
                await self._whole.wait()
                writer.write(data)

        delivering = asyncio.create_task(deliver())
        try:
            while data := await reader.read(65_536):
                lost = self._chance.random() < self._faults.loss
                due = time.monotonic() + self._faults.delay + (RETRANSMISSION if lost else 0.0)
                late.put_nowait((due, data))
        except ConnectionError:
            pass
        finally:
            delivering.cancel()


async def connection(listen: int, target: int) -> None:
    """Carry connections until stdin ends."""
    proxy, loop, commands = Proxy(target), asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(commands), sys.stdin)
    async with await asyncio.start_server(proxy.carry, "127.0.0.1", listen):
        _say("ready")
        async for line in commands:
            proxy.set(Faults(**json.loads(line)))
            _say("done")


if __name__ == "__main__":
    if sys.argv[1] == "packets":
        packets(sys.argv[2])
    else:
        asyncio.run(connection(int(sys.argv[2]), int(sys.argv[3])))
