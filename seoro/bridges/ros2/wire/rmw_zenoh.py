"""The dialect of rmw_zenoh, the middleware of ROS 2 that uses Zenoh itself.

    keys      <domain>/<name>/<DDS type>/<hash>
    tokens    @ros2_lv/<domain>/<session>/<node>/<node>/NN/<enclave>/<namespace>/<name>
              @ros2_lv/<domain>/<session>/<node>/<endpoint>/<MP|MS|SS|SC>/<enclave>/<namespace>/<name>/
                  <topic or service>/<DDS type>/<hash>/<QoS>

Slashes within a part of a token are `%`. Releases to come add parts at the end, which are not read.
Source: the design document of ros2/rmw_zenoh, and its liveliness_utils.cpp.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import xxhash

from seoro.bridges.ros2.addresses import LARGEST_DOMAIN
from seoro.bridges.ros2.wire.attachment import Attachment
from seoro.bridges.ros2.wire.dialect import dds_type, ros_type
from seoro.bridges.ros2.wire.entities import Endpoint, Entity, Kind, Node
from seoro.bridges.ros2.wire.qos import INFINITE, Durability, History, Liveliness, Qos, Reliability

NO_HASH = "TypeHashNotSupported"  # what Humble, which computes none, has in the place of a hash

_SPACE = "@ros2_lv"
_NODE = "NN"
_NODE_PARTS = 9
_ENDPOINT_PARTS = 13
_KINDS = {kind.value: kind for kind in (Kind.PUBLISHER, Kind.SUBSCRIPTION, Kind.SERVER, Kind.CLIENT)}
_SECOND = 1_000_000_000  # [ns]
_NUMBER = re.compile(r"[0-9]{1,20}")  # of a node or an endpoint, of 64 bits; Python reads no number without bounds

# rmw's numbers; 0 is what the middleware chooses, which for rmw_zenoh is what is written as nothing at all.
_RELIABILITIES = {"": Reliability.RELIABLE, "0": Reliability.RELIABLE, "1": Reliability.RELIABLE}
_RELIABILITIES |= {"2": Reliability.BEST_EFFORT}
_DURABILITIES = {"": Durability.VOLATILE, "0": Durability.VOLATILE, "2": Durability.VOLATILE}
_DURABILITIES |= {"1": Durability.TRANSIENT_LOCAL}
_HISTORIES = {"": History.KEEP_LAST, "0": History.KEEP_LAST, "1": History.KEEP_LAST, "2": History.KEEP_ALL}
_LIVELINESSES = {"": Liveliness.AUTOMATIC, "0": Liveliness.AUTOMATIC, "1": Liveliness.AUTOMATIC}
_LIVELINESSES |= {"3": Liveliness.MANUAL_BY_TOPIC}
_DEFAULT_DEPTH = 42


@dataclass(frozen=True)
class RmwZenoh:
    """rmw_zenoh in a domain (ROS_DOMAIN_ID)."""

    domain: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= LARGEST_DOMAIN:
            raise ValueError(f"a domain of ROS 2 is a number from 0 to {LARGEST_DOMAIN}, not {self.domain}")

    @property
    def name(self) -> str:
        """What people call it."""
        return "rmw_zenoh"

    @property
    def tokens(self) -> str:
        """Key expression of all tokens of the domain."""
        return f"{_SPACE}/{self.domain}/**"

    def token(self, entity: Entity) -> str | None:
        """The token of a node or an endpoint; actions have none but those of their services and topics."""
        match entity:
            case Node():
                return f"{self._beginning(entity, entity.number)}/{_NODE}/{_place(entity)}"
            case Endpoint(kind=Kind.ACTION_SERVER | Kind.ACTION_CLIENT):
                return None
            case Endpoint(node=node, number=number):
                assert node is not None and number is not None, "endpoints of rmw_zenoh belong to nodes"
                what = "/".join(
                    (
                        _mangle(entity.name),
                        dds_type(entity.type),
                        entity.type_hash or NO_HASH,
                        encode_qos(entity.qos or Qos()),
                    )
                )
                return f"{self._beginning(node, number)}/{entity.kind.value}/{_place(node)}/{what}"

    def _beginning(self, node: Node, number: int) -> str:
        return f"{_SPACE}/{self.domain}/{node.session}/{node.number}/{number}"

    def parse(self, token: str) -> Entity | None:
        """What a token of any domain announces, or None if it cannot be read."""
        parts = token.split("/")
        if len(parts) < _NODE_PARTS or parts[0] != _SPACE:
            return None
        if _NUMBER.fullmatch(parts[3]) is None or _NUMBER.fullmatch(parts[4]) is None:
            return None
        node = Node(parts[2], int(parts[3]), parts[8], _demangle(parts[7]), _demangle(parts[6]))
        if parts[5] == _NODE:
            return node
        kind = _KINDS.get(parts[5])
        if kind is None or len(parts) < _ENDPOINT_PARTS:
            return None
        return Endpoint(
            kind,
            _demangle(parts[9]),
            ros_type(parts[10]),
            node.session,
            None if parts[11] == NO_HASH else parts[11],
            decode_qos(parts[12]),
            int(parts[4]),
            node,
        )

    def key(self, name: str, type_name: str, type_hash: str | None) -> str:
        """The key of a topic or service."""
        return f"{self.domain}/{name.strip('/')}/{dds_type(type_name)}/{type_hash or NO_HASH}"

    def every_key(self, name: str, type_name: str) -> str:
        """The key expression of a topic or service, however its type is defined."""
        return self.key(name, type_name, "*")

    def type_hash(self, key: str) -> str | None:
        """The hash at the end of a key, unless the sender computes none."""
        last = key.rpartition("/")[2]
        return None if last == NO_HASH else last

    def gid(self, token: str) -> bytes:
        """The 128 bits of XXH3 of the token, the lower half first."""
        return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")

    def attachment(self, sequence: int, stamp: int, gid: bytes) -> bytes:
        """What is sent beside each message."""
        return Attachment(sequence, stamp, gid).pack()


def encode_qos(qos: Qos) -> str:
    """The part of a token that tells the QoS.

    What is empty stands for rmw_zenoh's defaults, of which that of durability has changed between releases. So all
    that may differ is written out.
    """
    reliability = 1 if qos.is_reliable else 2
    durability = 1 if qos.is_transient_local else 2
    history = 1 if qos.history is History.KEEP_LAST else 2
    liveliness = "" if qos.liveliness is Liveliness.AUTOMATIC else "3"
    times = f"{_encode_time(qos.deadline)}:{_encode_time(qos.lifespan)}:{liveliness},{_encode_time(qos.lease)}"
    return f"{reliability}:{durability}:{history},{qos.depth}:{times}"


def decode_qos(text: str) -> Qos | None:
    """What that part of a token says, or None if it cannot be read."""
    try:
        reliability, durability, history, deadline, lifespan, liveliness = text.split(":")[:6]
        kept, depth = history.split(",")
        alive, lease = liveliness.split(",", 1)
        return Qos(
            _RELIABILITIES[reliability],
            _DURABILITIES[durability],
            _HISTORIES[kept],
            int(depth or _DEFAULT_DEPTH) or _DEFAULT_DEPTH,  # 0 leaves it to the middleware
            _decode_time(deadline),
            _decode_time(lifespan),
            _LIVELINESSES[alive],
            _decode_time(lease),
        )
    except (ValueError, KeyError):
        return None


def _encode_time(nanoseconds: int | None) -> str:
    if nanoseconds is None:
        return ","
    return f"{nanoseconds // _SECOND},{nanoseconds % _SECOND}"


def _decode_time(text: str) -> int | None:
    """[ns], or None for a time without end; either number is left out where it is that of a time without end."""
    seconds, nanoseconds = text.split(",")
    total = int(seconds or INFINITE // _SECOND) * _SECOND + int(nanoseconds or INFINITE % _SECOND)
    return total if 0 < total < INFINITE else None


def _place(node: Node) -> str:
    return f"{_mangle(node.enclave)}/{_mangle(node.namespace)}/{node.name}"


def _mangle(name: str) -> str:
    return name.replace("/", "%") or "%"


def _demangle(part: str) -> str:
    return part.replace("%", "/")
