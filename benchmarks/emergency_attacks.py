"""Emergency stops during attacks: `PYTHONPATH=. python benchmarks/emergency_attacks.py`.

A process attacks an executor, a simulator or a bridge over the loopback, with the keys of a viewer for targets
with keys. It sends messages of 15 MB to 64 MiB that would become gigabytes of objects, or 20,000 requests that
wait. Meanwhile an operator stops everything, again and again. A try passes if the stop took effect within 0.5 s
and was acknowledged. A target passes if all its tries do, its memory has grown by at most 100 MB, and its log
(with keys) names the operator. The exit status is 1 if a target fails.

    --tries N         of each attack at each target (default 100)
    --targets A,B     executor, keyed-executor, keyed-simulator, bridge (default all)
    --attacks A,B     refused, bomb, largest, waiting (default all)
    --cells A:B,...   attacks at targets, such as bridge:waiting; instead of --targets and --attacks
    --results FILE    a line of JSON for each try; tries that are there already are not made again, so that an
                      interrupted measurement goes on where it was
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import anyio
import processes
from zenoh.handlers import Callback

import seoro
from seoro.bridges import wire
from seoro.bridges.executor.messages import AskRecords, State
from seoro.bridges.session import Session
from seoro.lab.commands import LabCommands
from seoro.lab.outcomes import Outcome
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.endpoint_keys import security_of
from seoro.security.signing.commands import NONCE, CommandSigner
from tests.executors import LONG
from tests.labs import NAME, KeyedLab, command, free_port, keyed_executor, make_lab

WITHIN = 0.5  # [s]
GROWTH = 100.0  # [MB]
SECONDS = 1.0  # of an attack by large messages, in which one comes after another
REQUESTS = 20_000  # waiting requests of one wave
SIZES = {"refused": 15_000_000, "bomb": 20_000_000, "largest": (64 << 20) - 4096}  # [bytes]
ATTACKS = (*SIZES, "waiting")
OPERATOR, VIEWER = "anna", "vera"
Seal = Callable[[str, bytes], bytes]
SHOWN = 300  # [characters] of an error


@dataclass(frozen=True)
class Target:
    """The target of the attacks.

    Attributes:
        endpoint: Zenoh endpoint.
        name: Its name.
        verb: Request that a viewer may send.
        process: Its process, whose children count, too.
        state: File in which it keeps an emergency stop.
        lab: The keys, if there are any.
        audit: Its log, if there is one.
    """

    endpoint: str
    name: str
    verb: str
    process: int
    state: Path
    lab: KeyedLab | None = None
    audit: Path | None = None

    @property
    def is_executor(self) -> bool:
        """Whether it runs scenarios."""
        return self.name == NAME

    def keys(self, who: str) -> Path | None:
        """Return the folder with the keys of an identity."""
        return None if self.lab is None else self.lab.keys(who)


# ---------------------------------------------------------------- the attacker, a process of its own


def attack(kind: str, endpoint: str, name: str, verb: str, folder: str) -> None:
    """Attack once for each line on stdin, the run that requests wait for; print when that begins and ends."""
    keys = read_keys(Path(folder)) if folder else None
    security = security_of(endpoint, keys) if keys is not None else None
    session = Session(connect=endpoint, security=security)
    make_key = wire.executor_command if name == NAME else wire.node_command
    patience = 20.0 if kind == "waiting" else 1.0  # [s]; large messages are dropped unanswered
    waiting_verb = "records" if name == NAME else verb

    def ask(
        verb: str, payload: bytes, seal: Callable[[str, bytes], bytes] | None, over: Callable[[], Any]
    ) -> None:
        key = make_key(wire.NAMESPACE, name, verb)
        beside = None if seal is None else seal(key, payload)
        session.get(key, payload, patience, Callback(lambda reply: None, drop=over, indirect=False), beside)

    def send_largest() -> None:
        size = SIZES[kind]
        payload = b"\xdd" + struct.pack(">I", size - 5) + b"\x80" * (size - 5)
        done = threading.Event()
        ask(verb, payload, None, done.set)
        done.wait(30.0)

    def send_many(run: str) -> None:
        payload = wire.encode(wire.Empty())
        if name == NAME:
            payload = wire.encode(
                AskRecords(run=run, state=State.RUNNING, is_announced=True, at=1 << 40, wait=10.0)
            )
        seal = _signer(session, name, keys) if keys is not None and name == NAME else None
        left = threading.Semaphore(0)
        for _ in range(REQUESTS):
            ask(waiting_verb, payload, seal, left.release)
        for _ in range(REQUESTS):
            left.acquire(timeout=25.0)

    for line in sys.stdin:
        print("begins", flush=True)
        if kind == "waiting":
            send_many(line.strip())
        else:
            until = time.monotonic() + SECONDS
            while time.monotonic() < until:
                send_largest()
        print("over", flush=True)
    session.close()


def _signer(session: Session, name: str, keys: Keys) -> Seal:
    """Make the function that signs requests of an identity to an executor."""
    signer, nonce, done = CommandSigner(keys, name), os.urandom(NONCE), threading.Event()
    replies: list[Any] = []
    asked = time.time_ns()
    key = wire.executor_command(wire.NAMESPACE, name, "challenge")
    payload = wire.encode(wire.Challenge(nonce=nonce))
    session.get(key, payload, 10.0, Callback(replies.append, drop=done.set, indirect=False))
    done.wait(10.0)
    proof = wire.CHALLENGE.read_reply(replies[0].ok.payload.to_bytes())
    said = (proof.certificate, proof.signature, nonce, proof.boot, proof.now)
    signer.accept(*said, (asked, time.time_ns()), proof.exchange)
    return signer.sign


class Attacker:
    """The attacking process."""

    def __init__(self, kind: str, target: Target) -> None:
        folder = "" if target.lab is None else str(target.keys(VIEWER))
        line = [sys.executable, __file__, "--attack", kind, target.endpoint, target.name, target.verb, folder]
        self._process = subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def begin(self, run: str) -> None:
        """Attack once, and return when it has begun."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{run}\n")
        self._process.stdin.flush()
        self._read("begins")

    def wait(self) -> None:
        """Wait until the attack is over."""
        self._read("over")

    def _read(self, expected: str) -> None:
        assert self._process.stdout is not None
        line = self._process.stdout.readline().strip()
        if line != expected:
            raise SystemExit(f"the attacker has ended: {line!r}")

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


# ---------------------------------------------------------------- the operator


@dataclass(frozen=True)
class Try:
    """A stop during an attack.

    Attributes:
        effect: After what time it took effect [s].
        answer: After what time it was acknowledged [s].
        error: Reason of a failure; empty without one.
        grown: Memory that the target has had more than before the first try [MB].
        is_named: Whether the log names the operator, where there is a log.
    """

    effect: float
    answer: float
    error: str
    grown: float = 0.0
    is_named: bool = True

    @property
    def holds(self) -> bool:
        """Whether it is in time."""
        return self.effect <= WITHIN and not self.error


async def stop_during(target: Target, attacker: Attacker, random_: random.Random) -> Try:
    """Stop everything during an attack."""
    run = await _running(target) if target.is_executor else ""
    attacker.begin(run)
    await anyio.sleep(random_.uniform(0.1, SECONDS))
    began = time.time()
    (outcome,) = await LabCommands([target.endpoint], target.keys(OPERATOR)).emergency_stop_all(
        "a benchmark", "to measure it"
    )
    effect = _since(target.state) - began
    attacker.wait()
    await _release(target)
    return Try(effect, outcome.elapsed, outcome.error)


def _since(state: Path) -> float:
    """Time at which the stop that holds took effect [s since 1970], as the node recorded it."""
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        try:
            return float(json.loads(state.read_text())["since"])
        except (OSError, ValueError):
            time.sleep(0.01)
    return float("inf")


async def _release(target: Target) -> None:
    outcomes: list[Outcome] = []
    for _ in range(10):
        outcomes = await LabCommands([target.endpoint], target.keys(OPERATOR)).release_all(
            "a benchmark", "it is measured"
        )
        if not target.state.exists():
            return
    raise SystemExit(f"the stop was not released: {outcomes}")


async def _running(target: Target) -> str:
    """Start an endless run."""
    scenario = target.state.parent / "long.osc"
    scenario.write_text(LONG)
    async with seoro.Client(target.endpoint, target.keys(OPERATOR)) as client:
        run = await client.submit(NAME, scenario)
        async for info, _ in run.parts():
            if info.announcement:
                return run.id
    raise SystemExit("the run does not begin")


# ---------------------------------------------------------------- memory


def processes_of(process: int) -> list[int]:
    """Return a process and its descendants."""
    found = [process]
    for each in found:
        try:
            children = Path(f"/proc/{each}/task/{each}/children").read_text().split()
        except OSError:
            continue
        found += map(int, children)
    return found


def peak(process: int) -> float:
    """Return the peak memory of a process since `forget_peak` [MB]; zero after its end."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0.0
    lines = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
    return int(lines.get("VmHWM", "0 kB").split()[0]) * 1024 / 1e6


def forget_peak(process: int) -> None:
    """Reset the peak memory."""
    Path(f"/proc/{process}/clear_refs").write_text("5")


# ---------------------------------------------------------------- targets


@contextmanager
def target_of(name: str, folder: Path) -> Iterator[Target]:
    """Start a target."""
    os.environ["XDG_STATE_HOME"] = str(folder / "states")
    made = {
        "executor": _executor,
        "keyed-executor": _keyed_executor,
        "keyed-simulator": _keyed_simulator,
        "bridge": _bridge,
    }
    with ExitStack() as stack:
        yield made[name](folder, stack)


def _executor(folder: Path, stack: ExitStack) -> Target:
    endpoint, state = f"tcp/127.0.0.1:{free_port()}", folder / "state"
    line = ("serve", "--name", NAME, "--listen", endpoint, "--folder", str(state))
    running = stack.enter_context(command(folder / "log", endpoint, *line))
    return Target(endpoint, NAME, "describe", running.process.pid, state / "emergency_stop.json")


def _keyed_executor(folder: Path, stack: ExitStack) -> Target:
    lab, state = make_lab(folder / "lab"), folder / "state"
    running = stack.enter_context(keyed_executor(folder, lab))
    stop, audit = state / "emergency_stop.json", state / "audit.jsonl"
    return Target(running.endpoint, NAME, "challenge", running.process.pid, stop, lab, audit)


def _keyed_simulator(folder: Path, stack: ExitStack) -> Target:
    lab = make_lab(folder / "lab")
    lab.authority.add("hall", Role.NODE, lab.keys("hall"))
    endpoint = f"tls/127.0.0.1:{free_port()}"
    line = ("sim", "mujoco", "--world", "hall", "--rate", "1", "--node", "hall", "--listen", endpoint)
    os.environ["SEORO_KEYS"] = str(lab.keys("hall"))
    running = stack.enter_context(command(folder / "log", endpoint, *line))
    del os.environ["SEORO_KEYS"]
    audit = next((folder / "states").glob("seoro/simulators/hall@*.audit.jsonl"))
    stop = next(audit.parent.glob("*.reserve")).with_suffix(".json")
    return Target(endpoint, "hall", "get_lab_state", running.process.pid, stop, lab, audit)


def _bridge(folder: Path, stack: ExitStack) -> Target:
    simulator, ros = (f"unixsock-stream/{folder}/{each}" for each in ("simulator", "ros"))
    endpoint, robot = f"tcp/127.0.0.1:{free_port()}", "turtlebot4:turtlebot4@/turtlebot4"
    stack.enter_context(
        processes.command("sim", "mujoco", "--world", "hall", "--rate", "1", "--listen", simulator)
    )
    exposed = ("--expose", "--simulator", simulator, "--ros-listen", ros)
    stack.enter_context(processes.command("bridge", "ros2", *exposed))
    line = ("bridge", "ros2", "--robot", robot, "--ros", ros, "--listen", endpoint)
    process = stack.enter_context(processes.command(*line))
    states = folder / "states" / "seoro" / "bridges"
    reserve = next(states.glob("*.reserve"))
    return Target(endpoint, "ros2", "get_lab_state", process, reserve.with_suffix(".json"))


# ---------------------------------------------------------------- the whole


class Results:
    """The tries that were made, by target and attack, and their file.

    Args:
        file: File for the results; None to keep none.
    """

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self.tries: dict[tuple[str, str], list[Try]] = {}
        for line in file.read_text().splitlines() if file is not None and file.exists() else ():
            entry = json.loads(line)
            cell = (entry.pop("target"), entry.pop("attack"))
            self.tries.setdefault(cell, []).append(Try(**entry))

    def add(self, cell: tuple[str, str], made: Try) -> None:
        """Record a try."""
        self.tries.setdefault(cell, []).append(made)
        if self._file is not None:
            with self._file.open("a") as file:
                file.write(json.dumps({"target": cell[0], "attack": cell[1], **asdict(made)}) + "\n")


def measure(target: Target, cell: tuple[str, str], tries: int, random_: random.Random, results: Results) -> None:
    """Repeat one attack at a target until the number of tries is reached."""
    attacker = Attacker(cell[1], target)
    before = {}
    for process in processes_of(target.process):
        forget_peak(process)
        before[process] = peak(process)
    try:
        while len(results.tries.get(cell, ())) < tries:
            named = 0 if target.audit is None else named_in(target.audit)
            made = anyio.run(stop_during, target, attacker, random_)
            grown = max(peak(process) - most for process, most in before.items())
            is_named = target.audit is None or named_in(target.audit) > named
            results.add(cell, replace(made, grown=grown, is_named=is_named))
    finally:
        attacker.close()


def judge(cell: tuple[str, str], found: Sequence[Try]) -> list[str]:
    """Print the measurements; returns the targets that failed."""
    name, grown = ":".join(cell), max(each.grown for each in found)
    late = [each for each in found if not each.holds]
    effects = [each.effect * 1e3 for each in found]
    answers = [each.answer * 1e3 for each in found]
    print(
        f"{name}: {len(found) - len(late)} of {len(found)} held; "
        f"effect {statistics.median(effects):.0f} ms, at most "
        f"{max(effects):.0f} ms; answer {statistics.median(answers):.0f} ms, at most {max(answers):.0f} ms; "
        f"memory +{grown:.0f} MB",
        flush=True,
    )
    wrong = [f"{name}: effect after {each.effect:.2f} s; {each.error[:SHOWN]}" for each in late]
    if grown > GROWTH:
        wrong.append(f"{name}: memory has grown by {grown:.0f} MB")
    if unnamed := sum(not each.is_named for each in found):
        wrong.append(f"{name}: the log does not name the operator of {unnamed} stops")
    return wrong


def named_in(audit: Path) -> int:
    """Return the number of stops by the operator in an audit log."""
    entries = [json.loads(line) for line in audit.read_text().splitlines()]
    said = [(each["what"], each["by"], each.get("outcome")) for each in entries]
    return said.count(("emergency_stop", OPERATOR, "done"))


def main() -> int:
    """Attack all targets; returns the exit status."""
    if sys.argv[1:2] == ["--attack"]:
        attack(*sys.argv[2:])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--targets", default="executor,keyed-executor,keyed-simulator,bridge")
    parser.add_argument("--attacks", default=",".join(ATTACKS))
    parser.add_argument("--cells", default="")
    parser.add_argument("--results", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # `timeout` leaves nothing behind
    cells = [(name, kind) for name in options.targets.split(",") for kind in options.attacks.split(",")]
    if options.cells:
        cells = [(name, kind) for name, kind in (each.split(":") for each in options.cells.split(","))]
    results, random_ = Results(options.results), random.Random(options.seed)
    wrong: list[str] = []
    for name in dict.fromkeys(name for name, _ in cells):
        kinds = [kind for target, kind in cells if target == name]
        missing = [kind for kind in kinds if len(results.tries.get((name, kind), ())) < options.tries]
        if missing:
            measure_all(name, missing, options.tries, random_, results)
        for kind in kinds:
            wrong += judge((name, kind), results.tries[name, kind])
    print("\n".join(wrong) or "all hold")
    return 1 if wrong else 0


def measure_all(name: str, kinds: Sequence[str], tries: int, random_: random.Random, results: Results) -> None:
    """Start a target, and measure its attacks."""
    with tempfile.TemporaryDirectory() as folder, target_of(name, Path(folder)) as target:
        anyio.run(
            LabCommands([target.endpoint], target.keys(OPERATOR)).emergency_stop_all,
            "a benchmark",
            "to load what that takes",
        )
        anyio.run(_release, target)
        for kind in kinds:
            measure(target, (name, kind), tries, random_, results)


if __name__ == "__main__":
    sys.exit(main())
