"""Runs in sandboxes: visible files, reachable endpoints, and their end."""

import asyncio
import os
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import anyio
import msgpack
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.bridges.session import SessionError
from seoro.bridges.session.brokered import Broker
from seoro.bridges.wire.keys import NAMESPACE, executor_command, node_command
from seoro.errors import UsageError
from seoro.executor.limits import Limits, Policy
from seoro.executor.runs.usage import cut
from seoro.executor.sandbox import broker, bubblewrap
from seoro.executor.sandbox import command as sandbox
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage.run_folder import open_left
from seoro.security.keys import VARIABLE
from seoro.security.network.brokered_keys import brokered_keys
from tests.executor.process.test_pool import job
from tests.executors import HELLO
from tests.labs import KeyedLab, command, free_port, keyed_executor, make_lab

DEADLINE = 60.0  # [s]
TROUBLE = bubblewrap.trouble()
sandboxed = pytest.mark.skipif(bool(TROUBLE), reason=TROUBLE)
LOOKING = """import os
import socket
import threading
import subprocess
from pathlib import Path

from seoro import ActionContext, action

@action("look")
async def look(ctx: ActionContext, places: str, mark: str) -> None:
    for place in places.split(":"):
        try:
            path = Path(place)
            ctx.log(f"{place}: {sorted(os.listdir(path)) if path.is_dir() else path.read_text()}")
        except OSError as error:
            ctx.log(f"{place}: {error.strerror}")
    kernel = ("/proc/sys/kernel/core_pattern", "/proc/sys/kernel/hostname", "/proc/sysrq-trigger")
    for place in (*kernel, "/sys/fs/cgroup/memory/tasks"):
        try:
            os.close(os.open(place, os.O_WRONLY))
            ctx.log("WRITABLE " + place)
        except OSError:
            pass
    for place in ("/", "/etc", "/usr", "/dev", "/sys", os.getcwd()):
        try:
            Path(place, "x").touch()
            ctx.log("WRITABLE " + place)
        except OSError:
            pass
    Path.home().joinpath("kept").write_text("kept")
    Path("/tmp/scratch").write_text("scratch")
    ctx.log("interfaces " + str([name for _, name in socket.if_nameindex()]))
    ctx.log("processes " + str([name for name in os.listdir("/proc") if name.isdecimal()]))
    status = Path("/proc/self/status").read_text()
    ctx.log(next(line for line in status.splitlines() if line.startswith("CapBnd")))
    ctx.log("keys " + os.environ.get("SEORO_KEYS", "none"))
    subprocess.run(["setsid", "-f", "sleep", "41" + mark], check=True)
"""
SCENARIO = """import osc.helpers
import osc.mine
scenario main:
    do serial:
        look("{places}", "{mark}")
"""
STEPS = "import osc.sim\nscenario main:\n    do serial:\n        wait elapsed(0.2s)\n"


def options(folder: Path, **limits: object) -> ExecutorOptions:
    policy = Policy(everybody=Limits.model_validate(limits))
    return ExecutorOptions("lab-a", folder / "state", listen=f"unixsock-stream/{folder}/hub", policy=policy)


async def logs_of(made: ExecutorOptions, file: Path) -> tuple[State, list[str]]:
    async with open_executor(made) as started, seoro.Client(made.listen) as client:
        assert bool(started.no_sandbox) == (made.policy.everybody.sandbox == "off")
        run = await client.submit("lab-a", file)
        with anyio.fail_after(DEADLINE), suppress(seoro.BackendError):
            await run.result()
        return run.state, [record["message"] async for record in run.records() if record["kind"] == "log"]


def sleepers(mark: str) -> list[str]:
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            found.append(path.read_bytes().replace(b"\0", b" ").decode(errors="replace"))
    return [each for each in found if each.startswith(f"sleep 41{mark}")]


@sandboxed
async def test_a_sandboxed_run_sees_no_files_and_processes_of_the_executor(tmp_path: Path) -> None:
    secret, mark = tmp_path / "identity.key", str(os.getpid())
    secret.write_text("PRIVATE")
    library = tmp_path / "seoro.libraries"
    library.mkdir()
    (library / "mine.osc").write_text("action look:\n    places: string\n    mark: string\n")
    (library / "mine.py").write_text(LOOKING)
    places = [secret, tmp_path, tmp_path / "state", tmp_path / "state" / "runs", "/home", "/tmp", "/run", "/dev"]
    file = tmp_path / "main.osc"
    file.write_text(SCENARIO.replace("{places}", ":".join(map(str, places))).replace("{mark}", mark))
    state, logs = await logs_of(options(tmp_path, allow=["python"], sandbox="required"), file)
    seen = "\n".join(logs)
    assert state is State.PASSED, seen
    assert "PRIVATE" not in seen
    assert "WRITABLE" not in seen
    assert "runs.sqlite" not in seen
    assert f"{tmp_path}: ['state']" in logs
    assert "interfaces ['lo']" in logs
    assert "keys none" in logs
    assert "CapBnd:\t0000000000000000" in seen
    [processes] = [line for line in logs if line.startswith("processes")]
    assert processes.count(",") < 4
    assert sleepers(mark) == []  # its child processes have ended with it


@pytest.mark.more
@sandboxed
async def test_a_sandboxed_run_reaches_a_robot_by_keys_of_the_broker(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    endpoint = f"tls/127.0.0.1:{free_port()}"
    node = (
        "sim",
        "mujoco",
        "--world",
        "hall",
        "--rate",
        "max",
        "--listen",
        endpoint,
        "--keys",
        str(lab.keys("maze")),
    )
    policy = tmp_path / "policy.yaml"
    policy.write_text("everybody: {sandbox: required}\n")
    (tmp_path / "x").mkdir()
    file = tmp_path / "main.osc"
    file.write_text(STEPS)
    with (
        command(tmp_path / "sim.log", endpoint, *node),
        keyed_executor(tmp_path / "x", lab, "--policy", str(policy)) as there,
    ):
        async with seoro.Client(there.endpoint, lab.keys("anna")) as client:
            run = await client.submit("lab-a", file, simulator=seoro.Simulator(endpoint=endpoint))
            with anyio.fail_after(DEADLINE):
                verdict = await run.result()
    assert verdict.passed, verdict.reason


async def test_an_executor_without_required_sandboxes_does_not_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bubblewrap, "PROGRAM", "no-such-program")
    with pytest.raises(UsageError, match="requires sandboxes, but `no-such-program` is not installed"):
        async with open_executor(options(tmp_path, sandbox="required")):
            pass
    async with open_executor(options(tmp_path)) as started:
        assert "is not installed" in started.no_sandbox


@sandboxed
@pytest.mark.parametrize("mode", ["auto", "off"])
async def test_runs_have_equal_traces_with_and_without_a_sandbox(tmp_path: Path, mode: str) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    state, logs = await logs_of(options(tmp_path, sandbox=mode), file)
    assert state is State.PASSED
    assert logs == ["hello"]


# ---------------------------------------------------------------- the broker


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture
def inside(lab: KeyedLab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Broker]:
    """Yield the connection of a run to its broker."""
    monkeypatch.setenv(VARIABLE, str(lab.keys("lab-a")))
    made = job(tmp_path / "home")
    (tmp_path / "home" / sandbox.TEMPORARY).mkdir()
    ours, theirs = socket.socketpair()
    serving = threading.Thread(target=lambda: asyncio.run(broker.Broker(made).answer(ours)))
    serving.start()
    try:
        yield Broker(theirs)
    finally:
        theirs.close()
        serving.join()


def test_the_broker_signs_commands_to_nodes_only(inside: Broker) -> None:
    endpoint = "tls/127.0.0.1:7447"
    with pytest.raises(SessionError, match="missing keys to sign with"):
        inside.ask("sign", msgpack.packb(["seoro command 1", node_command(NAMESPACE, "hall", "drive")]))
    assert len(inside.ask("credentials", endpoint)) == 3
    assert inside.ask("sign", msgpack.packb(["seoro command 1", node_command(NAMESPACE, "hall", "drive")]))
    for statement in (
        msgpack.packb(["seoro command 1", executor_command(NAMESPACE, "lab-b", "submit")]),
        msgpack.packb(["seoro stop 1", node_command(NAMESPACE, "hall", "emergency_stop")]),
        msgpack.packb(["seoro executor 1", "lab-a", b"nonce", "boot", 1]),
        b"\xc1",
    ):
        with pytest.raises(SessionError, match="signs commands to nodes only"):
            inside.ask("sign", statement)


def test_the_broker_connects_to_allowed_endpoints_only(inside: Broker, tmp_path: Path) -> None:
    with pytest.raises(SessionError, match=r"does not allow scenarios to connect to tcp/192\.0\.2\.1:7447"):
        inside.ask("reach", "tcp/192.0.2.1:7447")
    with pytest.raises(SessionError, match="nothing answers there"):
        inside.ask("reach", f"tcp/127.0.0.1:{free_port()}")
    with pytest.raises(SessionError, match="expected one of tcp, tls, unixsock-stream"):
        inside.ask("reach", "udp/127.0.0.1:7447")
    for path in ("/run/../run/docker.sock", "some.sock", f"{tmp_path}/home/tmp/mine.sock"):
        with pytest.raises(SessionError, match="expected an absolute path outside"):
            inside.ask("reach", f"unixsock-stream/{path}")
    with pytest.raises(SessionError, match="unknown request"):
        inside.ask("open", "/etc/passwd")


def test_the_broker_connects_to_zenoh_only(inside: Broker, tmp_path: Path) -> None:
    """A run may send any bytes on this socket."""
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(tmp_path / "other.sock"))
        other.listen()

        def answer() -> None:
            with suppress(OSError):
                while True:
                    connection, _ = other.accept()
                    connection.sendall(b"-ERR unknown command")
                    connection.close()

        answering = threading.Thread(target=answer)
        answering.start()
        try:
            with pytest.raises(SessionError, match="cannot connect"):
                inside.ask("reach", f"unixsock-stream/{tmp_path}/other.sock")
        finally:
            other.shutdown(socket.SHUT_RDWR)
            answering.join()


def test_links_left_by_a_run_are_not_followed(tmp_path: Path) -> None:
    folder = tmp_path / "output"
    folder.mkdir()
    (tmp_path / "identity.key").write_text("PRIVATE\n" * 1000)
    (folder / "log.txt").symlink_to(tmp_path / "identity.key")
    with pytest.raises(FileNotFoundError, match="is not a file of the run"):
        open_left(folder / "log.txt", folder)
    cut(folder / "log.txt", 10)
    assert (tmp_path / "identity.key").stat().st_size == 8000
    os.mkfifo(folder / "pipe")
    with pytest.raises(FileNotFoundError, match="is not a file of the run"):
        open_left(folder / "pipe", folder)
    (folder / "real").write_text("real")
    (folder / "link").symlink_to("real")
    with open_left(folder / "link", folder) as file:
        assert file.read() == b"real"


def test_missing_keys_are_reported_as_without_a_sandbox(
    inside: Broker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "none"))  # of the broker, which looks when it is asked
    with pytest.raises(UsageError, match="contains no keys"):
        brokered_keys(inside, "tls/127.0.0.1:7447")
    assert brokered_keys(inside, "tcp/127.0.0.1:7447") is None
