"""Cost of keys: `python benchmarks/keys.py`.

Measures the processor time of loading keys, and of a signed request to an executor over TLS beside one without
keys over TCP. Also measures the gap for the watcher of a run when another identity is revoked. Last, it measures
the extra time of authentication codes of a request to a simulator over TLS.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import anyio

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.requests import ask
from seoro.bridges.wire import GET_SIMULATION_STATE, Empty
from seoro.security.keys import VARIABLE
from seoro.security.keys.roles import Role
from tests.executors import LONG
from tests.labs import NAME, KeyedLab, command, free_port, keyed_executor, make_lab

QUESTIONS = 300
STARTS = 7
REVOCATIONS = 3
ASKED = 4000  # times, of a simulator
IN_TURN = 100  # requests of one kind, then as many of the next
TICKING = LONG.replace("    do serial:", "    event tick\n    on every(10ms):\n        emit tick\n    do serial:")


def main() -> None:
    """Measure, and print."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        lab = make_lab(place / "lab")
        reading = f"\nfrom seoro.security.keys.folder import read_keys\nread_keys({lab.keys('anna')!r})"
        reading = (
            f"from pathlib import Path, PosixPath\nimport seoro.client, seoro.security.signing.commands{reading}"
        )
        more = _processor_time(reading) - _processor_time("import seoro.client")
        print(f"loading keys: {more:.3f} s of processor time")
        with keyed_executor(place, lab) as there:
            print(f"a sealed question over TLS: {anyio.run(_ask, there.endpoint, lab.keys('anna')):.2f} ms")
            for _ in range(REVOCATIONS):
                print(
                    f"without records when an identity is revoked: {anyio.run(_watch, there.endpoint, lab):.2f} s"
                )
        print(f"a question to a simulator: {_codes(place, lab)}")
        plain = f"tcp/127.0.0.1:{free_port()}"
        state = ("--folder", str(place / "plain"))
        with command(place / "log", plain, "serve", "--name", NAME, "--listen", plain, *state):
            print(f"a question over TCP: {anyio.run(_ask, plain, None):.2f} ms")


def _processor_time(script: str) -> float:
    """Return the median time of a Python process [s]."""
    took = []
    for _ in range(STARTS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", script], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        took.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(took)


async def _ask(endpoint: str, keys: Path | None) -> float:
    """Return the median time of a request [ms]."""
    took = []
    async with seoro.Client(endpoint, keys) as client:
        await client.runs()
        for _ in range(QUESTIONS):
            began = time.perf_counter()
            await client.describe(NAME)
            took.append((time.perf_counter() - began) / 4.0)  # it sends four requests
    return 1e3 * statistics.median(took)


async def _watch(endpoint: str, lab: KeyedLab) -> float:
    """Return the longest time without records around a revocation [s]."""
    name = f"guest-{time.time_ns() % 10**9}"
    lab.authority.add(name, Role.VIEWER, lab.keys(name))
    file = lab.path / "ticking.osc"
    file.write_text(TICKING)
    longest = 0.0
    async with seoro.Client(endpoint, lab.keys("anna")) as client:
        run = await client.submit(NAME, file)
        began = last = time.monotonic()
        is_revoked = False
        async for _ in run.parts():
            now = time.monotonic()
            longest, last = max(longest, now - last if is_revoked else 0.0), now
            if now - began > 2.0 and not is_revoked:
                is_revoked = True
                lab.revoke(name, NAME)
            if now - began > 5.0:
                break
        await run.executor.ask(wire.STOP_RUN, wire.StopRun(run=run.id))
        await run.result()
    return longest


def _codes(place: Path, lab: KeyedLab) -> str:
    """Return quantiles of a request to a simulator: without codes, with one in the answer, with one in both."""
    lab.authority.add("sim", Role.NODE, lab.keys("sim"))
    os.environ[VARIABLE] = str(lab.keys("anna"))
    endpoint = f"tls/127.0.0.1:{free_port()}"
    sim = ("sim", "mujoco", "--world", "empty", "--listen", endpoint, "--keys", str(lab.keys("sim")))
    with command(place / "sim.log", endpoint, *sim):
        took = anyio.run(_questions, endpoint)
    del os.environ[VARIABLE]
    shown = []
    for share in (0.1, 0.5):
        plain, answer, both = (1e3 * times[int(share * ASKED)] for times in took)
        shown.append(
            f"p{100 * share:.0f} {plain:.3f} ms, code in the answer {answer:.3f} ms, in both {both:.3f} ms"
        )
    return "; ".join(shown)


async def _questions(endpoint: str) -> tuple[list[float], ...]:
    """Return sorted durations of requests [s]: of a client without leases, without and with keys, and of a run."""
    took: tuple[list[float], ...] = ([], [], [])
    async with connect_simulator(endpoint, SimulatorOptions("empty", 3, ModelPath())) as node:
        run = node._address
        ways = tuple(zip((replace(run, signer=None, sender=""), replace(run, sender=""), run), took, strict=True))
        for turn in range(ASKED // IN_TURN):
            for address, times in ways if turn % 2 else reversed(ways):
                for _ in range(IN_TURN):
                    began = time.perf_counter()
                    await ask(address, GET_SIMULATION_STATE, Empty())
                    times.append(time.perf_counter() - began)
    return tuple(sorted(times) for times in took)


if __name__ == "__main__":
    main()
