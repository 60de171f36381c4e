"""Runs and commands that need a message definition from the robot."""

import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import anyio

from seoro.bridges.ros2.descriptions import SERVICE
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.recording import open_bag
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.embed import prepare
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import options, ran_of
from tests.bridges.ros2.test_descriptions import STATE, VALUE, Describer, own_types
from tests.runtime.conftest import load_text


@asynccontextmanager
async def telling_robot(router: str, folder: Path) -> AsyncIterator[TypeStore]:
    """A robot with a package of its own, which publishes `/state` all the time."""
    types = own_types(TypeStore.bundled(), folder)
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as system,
        system.node("robot") as node,
        node.serving("~/get_type_description", SERVICE, Describer(types).describe),
        node.publishing("/state", STATE) as publication,
        anyio.create_task_group() as tasks,
    ):

        async def publish() -> None:
            while True:
                publication.publish(VALUE)
                await anyio.sleep(0.02)

        tasks.start_soon(publish)
        yield types
        tasks.cancel_scope.cancel()


async def test_a_scenario_reads_and_records_types_defined_only_by_the_robot(tmp_path: Path, router: str) -> None:
    text = f"""
import osc.ros

scenario main:
    do serial:
        bag_record(['/state'], timestamp_suffix: false)
        check_data("/state", "{STATE}", "1.5", member_name: "parts.0.voltage") with:
            timeout(10s)
"""
    settings = replace(options(router), output_directory=tmp_path / "out")
    async with (
        telling_robot(router, tmp_path / "theirs") as theirs,
        prepare(load_text(tmp_path, text, ()), settings) as run,
        run.running(),
    ):
        ran = await ran_of(run)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    topic = open_bag(tmp_path / "out" / "rosbag2").topics["/state"]
    assert topic.type_hash == theirs.type_hash(STATE)
    assert not any("without the definition" in text for _, text in ran.logs)


async def test_a_topic_is_echoed_by_the_definition_of_the_robot(tmp_path: Path, router: str) -> None:
    command = [
        *(sys.executable, "-c", "import sys; from seoro.cli.main import main; sys.exit(main(sys.argv[1:]))"),
        *("ros", "topic", "echo", "/state", "--field", "header.frame_id", "--count", "1", "--ros", router),
    ]
    async with telling_robot(router, tmp_path):
        with anyio.fail_after(30.0):
            done = await anyio.run_process(command, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"map\n", b"")
