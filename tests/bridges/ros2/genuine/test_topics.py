"""Topics between seoro and genuine nodes, in both directions."""

from __future__ import annotations

from functools import partial
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.messages import plain
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Endpoint, History, Liveliness, Qos, Reliability
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.bridges.ros2.genuine.steering import from_json, own_node, steered, to_json

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

TYPES = TypeStore.bundled()
LATE = 5.0  # [s]
STRING = "std_msgs/msg/String"
COUNT = 4  # messages of each type
LATCHED = {"durability": "transient_local", "depth": COUNT}
OWN_LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=COUNT)
PROFILES = [
    Qos(),
    Qos(Reliability.BEST_EFFORT, depth=5),
    Qos(durability=Durability.TRANSIENT_LOCAL, depth=1),
    Qos(history=History.KEEP_ALL),
    Qos(depth=7, deadline=200_000_000, lifespan=3_000_000_000),
    Qos(liveliness=Liveliness.MANUAL_BY_TOPIC, lease=1_500_000_000),
]


async def received(subscription: Subscription, count: int) -> list[object]:
    """Return the next messages as JSON data."""
    with anyio.fail_after(DEADLINE):
        return [plain(subscription.decode(await subscription.receive())) for _ in range(count)]


def publishers(graph: RosGraph, topic: str) -> tuple[Endpoint, ...]:
    return graph.publishers(topic)


def policies(qos: Qos) -> dict[str, object]:
    """Return a profile as arguments of a steered node."""
    return {
        "reliability": qos.reliability.value,
        "durability": qos.durability.value,
        "history": qos.history.value,
        "depth": qos.depth,
        "deadline": qos.deadline,
        "lifespan": qos.lifespan,
        "liveliness": qos.liveliness.value,
        "lease": qos.lease,
    }


async def test_drawn_messages_of_all_types_arrive_unchanged(ros2: Ros2, router: str) -> None:
    # Entities stay until the end: rclpy's executor may miss new ones while others are destroyed in another thread.
    async with steered(ros2, router) as genuine, own_node(router, TYPES) as own:
        types = [name for name in await genuine.ask("types") if name in TYPES.names()]
        assert len(types) > 120
        assert {"sensor_msgs/msg/PointCloud2", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"} <= set(types)
        for seed, name in enumerate(types):
            there, back = f"/there/t{seed}", f"/back/t{seed}"
            await genuine.ask("publisher", topic=there, type=name, **LATCHED)
            sent = await genuine.ask("publish_examples", topic=there, seed=seed, count=COUNT)
            async with own.subscribing(there, name, OWN_LATCHED) as subscription:
                assert await received(subscription, COUNT) == from_json(sent), name
            await genuine.ask("subscribe", topic=back, type=name, **LATCHED)
            async with own.publishing(back, name, OWN_LATCHED) as publication:
                for message in sent:
                    publication.publish(from_json(message))
                found = [(await genuine.event("message", topic=back))["message"] for _ in sent]
            assert found == to_json(sent), name


async def test_both_sides_see_the_same_types_and_policies(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router, TYPES) as own:
        for index, qos in enumerate(PROFILES):
            topic = f"/qos{index}"
            await genuine.ask("publisher", topic=topic, type=STRING, **policies(qos))
            [seen] = await own.graph.wait_for(partial(publishers, topic=topic), DEADLINE)
            assert (seen.qos, seen.type_hash) == (qos, TYPES.type_hash(STRING))
            async with own.publishing(topic, STRING, qos):
                with anyio.fail_after(DEADLINE):
                    while len(found := (await genuine.ask("endpoints", topic=topic))["publishers"]) < 2:
                        await anyio.sleep(0.05)
            theirs, ours = sorted(found, key=lambda each: each["node"] != "/steered")
            assert {**ours, "node": ""} == {**theirs, "node": ""}
            assert ours["node"] == "/seoro"


async def test_late_subscriptions_receive_the_last_latched_messages(ros2: Ros2, router: str) -> None:
    messages = [{"data": str(number)} for number in range(8)]
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("publisher", topic="/theirs", type=STRING, durability="transient_local", depth=5)
        await genuine.ask("publish", topic="/theirs", messages=messages)
        latched = Qos(durability=Durability.TRANSIENT_LOCAL, depth=5)
        async with own.subscribing("/theirs", STRING, latched) as subscription:
            assert await received(subscription, 5) == messages[3:]
        async with own.publishing("/ours", STRING, latched) as publication:
            for message in messages:
                publication.publish(message)
            await genuine.ask("subscribe", topic="/ours", type=STRING, durability="transient_local", depth=5)
            found = [(await genuine.event("message", topic="/ours"))["message"] for _ in range(5)]
        assert found == messages[3:]


@pytest.mark.parametrize("size", [1_000_000, 10_000_000])
async def test_large_messages_arrive_in_both_directions(ros2: Ros2, router: str, size: int) -> None:
    array, count = "std_msgs/msg/UInt8MultiArray", 5
    async with steered(ros2, router) as genuine, own_node(router) as own:
        # With any other history, rmw_zenoh drops messages if this process reads late.
        await genuine.ask("publisher", topic="/theirs", type=array, history="keep_all")
        async with own.subscribing("/theirs", array) as subscription:
            with anyio.fail_after(DEADLINE):
                while subscription.unread == 0:  # until the publisher knows the subscription
                    await genuine.ask("publish_bytes", topic="/theirs", size=1)
                    await anyio.sleep(0.1)
                await genuine.ask("publish_bytes", topic="/theirs", size=size, count=count, pause=0.2)
                found: list[Any] = []
                while len(found) < count:
                    data = subscription.decode(await subscription.receive()).data
                    found += [data] * (len(data) == size)
            assert [(each[0], each[-1]) for each in found] == [(number, number) for number in range(count)]
            assert subscription.missed == 0
        await genuine.ask("subscribe", topic="/ours", type=array, sizes=True)
        async with own.publishing("/ours", array) as publication:
            with anyio.fail_after(DEADLINE):
                await publication.wait_for_subscription()
                for number in range(count):
                    arrived = None
                    while arrived is None:  # neither side waits longer than a second for a reader that is late
                        publication.publish({"data": bytes([number]) * size})
                        with anyio.move_on_after(LATE):
                            arrived = await genuine.event("message", topic="/ours")
                    assert arrived["message"] == size


async def test_a_graph_of_100_nodes_with_1000_publishers_is_seen(ros2: Ros2, router: str) -> None:
    async with own_node(router) as own, steered(ros2, router) as genuine:
        await genuine.ask("many", nodes=100, endpoints=10)
        with anyio.fail_after(DEADLINE):
            await own.graph.wait_for(
                lambda graph: sum(topic.startswith("/many/") for topic in graph.topics()) == 1000, DEADLINE
            )
        assert sum(name.startswith("/many_") for name in own.graph.nodes()) == 100
        genuine.process.kill()
        await own.graph.wait_for(lambda graph: not any("many" in name for name in graph.nodes()), DEADLINE)
