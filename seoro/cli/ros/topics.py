"""`seoro ros topic`: list, echo, measure and publish topics."""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections import deque
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import asdict
from enum import Enum
from itertools import pairwise
from typing import Any

import anyio

from seoro.actions.ros_messages import member_of
from seoro.bridges.ros2.descriptions import decode_message
from seoro.bridges.ros2.graph import types_of
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.interfaces.messages import plain
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.wire import PRESETS, Endpoint, Qos
from seoro.bridges.ros2.wire.qos import matching_qos
from seoro.bridges.session import Bound
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, resolve_type
from seoro.cli.ros.values import as_json, as_yaml, count_of, read_words
from seoro.cli.tables import table
from seoro.errors import BackendError

WINDOW = 10_000  # messages for a rate
WAITING = Bound(10_000)  # messages, independent of the history of publishers: bursts are complete
REPORT = 1.0  # [s] between reports of a rate


async def show_info(options: argparse.Namespace) -> int:
    """Print publishers and subscriptions of a topic with QoS, and compare their type definitions."""
    async with connected(options) as node:
        topic = node.resolve(options.name)
        publishers, subscriptions = (
            node.others(found) for found in (node.graph.publishers(topic), node.graph.subscriptions(topic))
        )
        types = _topic_type(node, topic, None)
        if options.json:
            ends = {"publishers": publishers, "subscriptions": subscriptions}
            parts = {name: [_plain(node, each) for each in found] for name, found in ends.items()}
            print(as_json({"topic": topic, "type": types, **parts}))
            return Exit.PASSED
        for name, found in (("publisher", publishers), ("subscription", subscriptions)):
            print(count_of(len(found), name))
            if found:
                print(table([_described(node, each) for each in found], "  "))
    return Exit.PASSED


def _topic_type(node: RosNode, topic: str, given: str | None) -> str:
    found = types_of(node.others((*node.graph.subscriptions(topic), *node.graph.publishers(topic))))
    return resolve_type("topic", topic, given, found, node.graph.topics(hidden=True))


def _described(node: RosNode, endpoint: Endpoint) -> list[str]:
    owner = "behind the bridge" if endpoint.node is None else endpoint.node.full_name
    return [owner, endpoint.type, _qos_text(endpoint.qos), _agreement(node, endpoint)]


def _plain(node: RosNode, endpoint: Endpoint) -> dict[str, Any]:
    """Return an endpoint as JSON data: durations of QoS are in nanoseconds, None for infinite ones."""
    return {
        "node": None if endpoint.node is None else endpoint.node.full_name,
        "type": endpoint.type,
        "qos": None if endpoint.qos is None else asdict(endpoint.qos, dict_factory=_values),
        "definition": _agreement(node, endpoint),
    }


def _values(items: list[tuple[str, Any]]) -> dict[str, Any]:
    return {name: value.value if isinstance(value, Enum) else value for name, value in items}


def _qos_text(qos: Qos | None) -> str:
    if qos is None:
        return "unknown QoS"
    depth = "all" if qos.history.value == "keep_all" else f"last {qos.depth}"
    return f"{qos.reliability.value}, {qos.durability.value}, keeps {depth}"


def _agreement(node: RosNode, endpoint: Endpoint) -> str:
    """Compare the type definition of an endpoint with that of seoro."""
    types = node.system.types
    if endpoint.type_hash is None:
        return "unknown definition"
    owner = endpoint.node
    has_description = owner is not None and bool(node.graph.servers(f"{owner.full_name}/get_type_description"))
    if endpoint.type not in types.names():
        source = "read from the node" if has_description else "give one with `--interfaces`"
        return f"no definition in seoro: {source}"
    if types.type_hash(endpoint.type) == endpoint.type_hash:
        return "same definition"
    return f"other definition{' (read from the node)' if has_description else ''}: {endpoint.type_hash}"


async def echo(options: argparse.Namespace) -> int:
    """Print messages as they arrive."""
    async with _subscribed(options, is_decoded=True) as (node, subscription):
        count = 0
        async for received in subscription:
            print(_shown(options, await decode_message(node, subscription, received)), flush=True)
            count += 1
            if count == options.count:
                break
    return Exit.PASSED


def _shown(options: argparse.Namespace, message: Message) -> str:
    found = member_of(plain(message), options.field or "")
    if options.json:
        return as_json(found)
    return as_yaml(found, full=options.full) + ("" if options.field else "\n---")


async def measure_rate(options: argparse.Namespace) -> int:
    """Print the rate of messages once a second."""
    async with _subscribed(options, is_decoded=False) as (_, subscription):
        arrivals: deque[int] = deque(maxlen=options.window or WINDOW)
        sizes: deque[int] = deque(maxlen=arrivals.maxlen)
        reported, count = time.monotonic(), 0
        async for received in subscription:
            arrivals.append(received.arrived)
            sizes.append(len(received.payload))
            count += 1
            if (now := time.monotonic()) - reported >= REPORT or count == options.count:
                reported = now
                found = _rate(arrivals, sizes)
                print(as_json(found) if options.json else _rate_text(found), flush=True)
            if count == options.count:
                break
    return Exit.PASSED


def _rate(arrivals: deque[int], sizes: deque[int]) -> dict[str, float]:
    """Return the rate [Hz], its bandwidth [byte/s], intervals [s] and messages; only the last one at first."""
    gaps = [(later - earlier) / 1e9 for earlier, later in pairwise(arrivals)]
    if not gaps or sum(gaps) <= 0.0:
        return {"messages": len(arrivals)}
    rate = len(gaps) / sum(gaps)
    return {
        "rate": rate,
        "bandwidth": rate * statistics.fmean(sizes),
        "shortest": min(gaps),
        "longest": max(gaps),
        "deviation": statistics.pstdev(gaps),
        "messages": len(arrivals),
    }


def _rate_text(found: Mapping[str, float]) -> str:
    if "rate" not in found:
        return "waiting for a second message"
    return (
        f"{found['rate']:.3f} Hz, {found['bandwidth'] / 1e3:.1f} kB/s; interval {found['shortest']:.4f} to "
        f"{found['longest']:.4f} s, standard deviation {found['deviation']:.4f} s, window {found['messages']}"
    )


def _warn_of_losses(subscription: Subscription) -> None:
    if lost := subscription.lost + subscription.missed:
        print(f"warning: lost {count_of(lost, 'message')}", file=sys.stderr)


@asynccontextmanager
async def _subscribed(
    options: argparse.Namespace, *, is_decoded: bool
) -> AsyncIterator[tuple[RosNode, Subscription]]:
    """Subscribe to the topic of the options, with the type and QoS of its publishers."""
    async with connected(options) as node:
        topic = node.resolve(options.name)
        type_name = _topic_type(node, topic, options.type)
        offered = [each.qos for each in node.others(node.graph.publishers(topic)) if each.qos is not None]
        qos = PRESETS[options.qos] if options.qos else matching_qos(offered)
        async with node.subscribing(topic, type_name, qos, WAITING, is_decoded=is_decoded) as subscription:
            try:
                yield node, subscription
            finally:
                _warn_of_losses(subscription)


async def publish(options: argparse.Namespace) -> int:
    """Publish a message once, several times, or at a rate until Ctrl-C."""
    given, value = read_words(options.words)
    async with connected(options) as node:
        topic = node.resolve(options.name)
        type_name = _topic_type(node, topic, given)
        node.system.types.encode(type_name, value)  # reports errors before it waits
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
            f"no subscription to {publication.topic} within {limit:g} s; nothing was published "
            "(`--wait 0` publishes without waiting)"
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
    print(f"published {count_of(number, 'message')} on {publication.topic}")
