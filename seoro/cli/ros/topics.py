"""`seoro ros topic`: topics of a system, what is published on them, and publishing on them."""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections import deque
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from itertools import pairwise
from typing import Any

import anyio

from seoro.actions.ros_messages import member_of
from seoro.bridges.ros2.descriptions import decoded
from seoro.bridges.ros2.graph import types_of
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.interfaces.plain import plain
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.wire import PRESETS, Durability, Endpoint, Qos, Reliability
from seoro.bridges.session import Bound
from seoro.cli.exits import Exit
from seoro.cli.ros.reaching import of_others, only_type, reached
from seoro.cli.ros.values import as_json, as_yaml, counted, print_types, read_value, table
from seoro.errors import BackendError

WINDOW = 10_000  # messages of which rates are computed at most
WAITING = Bound(10_000)  # whatever publishers keep: what comes in a burst is shown, too
REPORT = 1.0  # [s] between two reports of a rate


async def list_topics(options: argparse.Namespace) -> int:
    """Print the topics with their types."""
    async with reached(options) as node:
        topics = node.graph.topics(hidden=options.all)
    print_types(topics, in_json=options.json)
    return Exit.PASSED


async def show_info(options: argparse.Namespace) -> int:
    """Print who publishes a topic and who subscribes, with quality of service, and whether definitions agree."""
    async with reached(options) as node:
        topic = node.resolve(options.name)
        publishers, subscriptions = (
            of_others(node, found) for found in (node.graph.publishers(topic), node.graph.subscriptions(topic))
        )
        only_type("topic", topic, None, types_of((*publishers, *subscriptions)), node.graph.topics(hidden=True))
        for name, found in (("publisher", publishers), ("subscription", subscriptions)):
            print(counted(len(found), name))
            if found:
                print(table([_described(node, each) for each in found]))
    return Exit.PASSED


def _described(node: RosNode, endpoint: Endpoint) -> list[str]:
    owner = "behind the bridge" if endpoint.node is None else endpoint.node.full_name
    return [owner, endpoint.type, _qos_text(endpoint.qos), _agreement(node, endpoint)]


def _qos_text(qos: Qos | None) -> str:
    if qos is None:
        return "quality of service not told"
    depth = "all" if qos.history.value == "keep_all" else f"last {qos.depth}"
    return f"{qos.reliability.value}, {qos.durability.value}, keeps {depth}"


def _agreement(node: RosNode, endpoint: Endpoint) -> str:
    """Whether the definition of a type is that which seoro has."""
    types = node.system.types
    if endpoint.type_hash is None:
        return "its definition is not told"
    owner = endpoint.node
    tells = owner is not None and bool(node.graph.servers(f"{owner.full_name}/get_type_description"))
    if endpoint.type not in types.names():
        told = "the node is asked for it" if tells else "give one with `--interfaces`"
        return f"seoro has no definition of it: {told}"
    if types.type_hash(endpoint.type) == endpoint.type_hash:
        return "defined as here"
    return f"defined otherwise{', as the node tells' if tells else ''}: {endpoint.type_hash}"


async def echo(options: argparse.Namespace) -> int:
    """Print messages as they come."""
    async with _following(options, is_decoded=True) as (node, subscription):
        count = 0
        async for received in subscription:
            print(_shown(options, await decoded(node, subscription, received)), flush=True)
            count += 1
            if count == options.count:
                break
    return Exit.PASSED


def _shown(options: argparse.Namespace, message: Message) -> str:
    found = member_of(plain(message), options.member or "")
    if options.json:
        return as_json(found)
    return as_yaml(found, full=options.full) + ("" if options.member else "\n---")


async def measure_rate(options: argparse.Namespace) -> int:
    """Print at which rate messages arrive, once a second."""
    async with _following(options, is_decoded=False) as (_, subscription):
        arrivals: deque[int] = deque(maxlen=options.window or WINDOW)
        sizes: deque[int] = deque(maxlen=arrivals.maxlen)
        reported, count = time.monotonic(), 0
        async for received in subscription:
            arrivals.append(received.arrived)
            sizes.append(len(received.payload))
            count += 1
            if (now := time.monotonic()) - reported >= REPORT or count == options.count:
                reported = now
                print(_rate(arrivals, sizes), flush=True)
            if count == options.count:
                break
    return Exit.PASSED


def _rate(arrivals: deque[int], sizes: deque[int]) -> str:
    moments = list(arrivals)
    gaps = [(later - earlier) / 1e9 for earlier, later in pairwise(moments)]
    if not gaps or sum(gaps) <= 0.0:
        return "one message so far"
    rate = len(gaps) / sum(gaps)
    return (
        f"{rate:.3f} Hz, {rate * statistics.fmean(sizes) / 1e3:.1f} kB/s; from one to the next {min(gaps):.4f} to "
        f"{max(gaps):.4f} s, standard deviation {statistics.pstdev(gaps):.4f} s, of {len(moments)}"
    )


def _tell_losses(subscription: Subscription) -> None:
    if lost := subscription.lost + subscription.missed:
        print(f"warning: {counted(lost, 'message')} got lost", file=sys.stderr)


@asynccontextmanager
async def _following(
    options: argparse.Namespace, *, is_decoded: bool
) -> AsyncIterator[tuple[RosNode, Subscription]]:
    """Be subscribed to the topic of the options, by a type and a quality of service that fit its publishers."""
    async with reached(options) as node:
        topic = node.resolve(options.name)
        publishers = of_others(node, node.graph.publishers(topic))
        found = types_of((*publishers, *of_others(node, node.graph.subscriptions(topic))))
        type_name = only_type("topic", topic, options.type, found, node.graph.topics(hidden=True))
        qos = PRESETS[options.qos] if options.qos else fitting_qos(publishers)
        async with node.subscribing(topic, type_name, qos, WAITING, is_decoded=is_decoded) as subscription:
            try:
                yield node, subscription
            finally:
                _tell_losses(subscription)


def fitting_qos(publishers: Iterable[Endpoint]) -> Qos:
    """What a subscription can ask of all: reliable if all publishers are, what was published before likewise."""
    offered = [each.qos for each in publishers if each.qos is not None]
    reliable = all(qos.is_reliable for qos in offered)
    keeps = bool(offered) and all(qos.is_transient_local for qos in offered)
    return Qos(
        reliability=Reliability.RELIABLE if reliable else Reliability.BEST_EFFORT,
        durability=Durability.TRANSIENT_LOCAL if keeps else Durability.VOLATILE,
        depth=max((qos.depth for qos in offered), default=100),
    )


async def publish(options: argparse.Namespace) -> int:
    """Publish a message, once, several times, or at a rate until Ctrl-C."""
    value = read_value(options.value)
    async with reached(options) as node:
        topic = node.resolve(options.name)
        found = types_of(of_others(node, (*node.graph.subscriptions(topic), *node.graph.publishers(topic))))
        type_name = only_type("topic", topic, options.type, found, node.graph.topics(hidden=True))
        node.system.types.encode(type_name, value)  # what is wrong with it is said before anybody is waited for
        qos = PRESETS[options.qos] if options.qos else None
        async with node.publishing(topic, type_name, qos) as publication:
            await _wait_for_subscription(publication, options.wait)
            count = options.count or (0 if options.rate else 1)
            await _publish(publication, value, count, options.rate)
    return Exit.PASSED


async def _wait_for_subscription(publication: Publication, limit: float) -> None:
    if limit <= 0.0:
        return
    try:
        await publication.wait_for_subscription(limit)
    except TimeoutError:
        raise BackendError(
            f"nobody has subscribed to {publication.topic} for {limit:g} s, and nothing was published; "
            "`--wait 0` publishes all the same"
        ) from None


async def _publish(publication: Publication, value: Mapping[str, Any], count: int, rate: float | None) -> None:
    start = time.monotonic()
    number = 0
    while True:
        publication.publish(value)
        number += 1
        if number == count:
            break
        if rate is not None:
            await anyio.sleep(max(0.0, start + number / rate - time.monotonic()))
    print(f"published {counted(number, 'message')} on {publication.topic}")
