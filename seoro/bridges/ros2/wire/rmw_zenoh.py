"""Dialect of rmw_zenoh, the ROS 2 middleware on Zenoh.

    keys      <domain>/<name>/<DDS type>/<hash>

    tokens    @ros2_lv/<domain>/<session>/<node>/<node>/NN/<enclave>/<namespace>/<name>

              @ros2_lv/<domain>/<session>/<node>/<endpoint>/<MP|MS|SS|SC>/<enclave>/<namespace>/<name>/
                  <topic or service>/<DDS type>/<hash>/<QoS>

Slashes within a part of a token are written `%`. Later releases may append parts, which are ignored.
Source: the design document of ros2/rmw_zenoh, and its liveliness_utils.cpp.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import xxhash

from seoro.bridges.addresses import LARGEST_DOMAIN
from seoro.bridges.ros2.wire.attachment import Attachment
from seoro.bridges.ros2.wire.entities import Endpoint, Entity, Kind, Node
from seoro.bridges.ros2.wire.qos import INFINITE, Durability, History, Liveliness, Qos, Reliability

NO_HASH = "TypeHashNotSupported"  # placeholder of Humble, which has no type hashes

_SPACE = "@ros2_lv"
_NODE = "NN"
_NODE_PARTS = 9
_ENDPOINT_PARTS = 13
_KINDS = {kind.value: kind for kind in (Kind.PUBLISHER, Kind.SUBSCRIPTION, Kind.SERVER, Kind.CLIENT)}
_SECOND = 1_000_000_000  # [ns]
_NUMBER = re.compile(r"[0-9]{1,20}")  # 64-bit number of a node or endpoint; Python limits the length of numbers

# Numbers of rmw. 0 is the default of the middleware, and so is an empty part.
_RELIABILITIES = {"": Reliability.RELIABLE, "0": Reliability.RELIABLE, "1": Reliability.RELIABLE}
_RELIABILITIES |= {"2": Reliability.BEST_EFFORT}
_DURABILITIES = {"": Durability.VOLATILE, "0": Durability.VOLATILE, "2": Durability.VOLATILE}
_DURABILITIES |= {"1": Durability.TRANSIENT_LOCAL}
_HISTORIES = {"": History.KEEP_LAST, "0": History.KEEP_LAST, "1": History.KEEP_LAST, "2": History.KEEP_ALL}
_LIVELINESSES = {"": Liveliness.AUTOMATIC, "0": Liveliness.AUTOMATIC, "1": Liveliness.AUTOMATIC}
_LIVELINESSES |= {"3": Liveliness.MANUAL_BY_TOPIC}
_DEFAULT_DEPTH = 42

_ROS_TYPE = re.compile(r"(\w+)/(\w+)/(\w+)")
_DDS_TYPE = re.compile(r"(\w+)::(\w+)::dds_::(\w+)_")


@dataclass(frozen=True)
class RmwZenoh:
    """rmw_zenoh in a domain (ROS_DOMAIN_ID)."""

    domain: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= LARGEST_DOMAIN:
            raise ValueError(f"invalid domain {self.domain}: expected a number from 0 to {LARGEST_DOMAIN}")

    @property
    def name(self) -> str:
        """Name on the command line."""
        return "rmw_zenoh"

    @property
    def tokens(self) -> str:
        """Key expression of all tokens of the domain."""
        return f"{_SPACE}/{self.domain}/**"

    def token(self, entity: Entity) -> str | None:
        """Return the token of a node or an endpoint; None for actions, which are announced by their parts."""
        match entity:
            case Node():
                return f"{self._prefix(entity, entity.number)}/{_NODE}/{_qualified(entity)}"
            case Endpoint(kind=Kind.ACTION_SERVER | Kind.ACTION_CLIENT):
                return None
            case Endpoint(node=node, number=number):
                assert node is not None and number is not None, "endpoints of rmw_zenoh belong to nodes"
                name, kind = _mangle(entity.name), dds_type(entity.type)
                parts = f"{name}/{kind}/{entity.type_hash or NO_HASH}/{encode_qos(entity.qos or Qos())}"
                return f"{self._prefix(node, number)}/{entity.kind.value}/{_qualified(node)}/{parts}"

    def _prefix(self, node: Node, number: int) -> str:
        return f"{_SPACE}/{self.domain}/{node.session}/{node.number}/{number}"

    def parse(self, token: str) -> Entity | None:
        """Parse a token of any domain; return None if it is invalid."""
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
        """Return the key of a topic or service."""
        return f"{self.domain}/{name.strip('/')}/{dds_type(type_name)}/{type_hash or NO_HASH}"

    def key_expression(self, name: str, type_name: str) -> str:
        """Return the key expression of a topic or service, for all type hashes."""
        return self.key(name, type_name, "*")

    def type_hash(self, key: str) -> str | None:
        """Return the hash at the end of a key; None for a sender without type hashes."""
        last = key.rpartition("/")[2]
        return None if last == NO_HASH else last

    def gid(self, token: str) -> bytes:
        """Return the XXH3 hash of the token: 128 bits, the lower half first."""
        return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")

    def attachment(self, sequence: int, stamp: int, gid: bytes) -> bytes:
        """Make the attachment of a message."""
        return Attachment(sequence, stamp, gid).pack()


def dds_type(name: str) -> str:
    """Return the DDS name of a type: `std_msgs::msg::dds_::String_` for `std_msgs/msg/String`."""
    match = _ROS_TYPE.fullmatch(name)
    return f"{match[1]}::{match[2]}::dds_::{match[3]}_" if match else name


def ros_type(name: str) -> str:
    """Return the ROS name of a DDS type."""
    match = _DDS_TYPE.fullmatch(name)
    return f"{match[1]}/{match[2]}/{match[3]}" if match else name


def encode_qos(qos: Qos) -> str:
    """Encode a QoS profile for a token.

    Empty parts stand for the defaults of rmw_zenoh. The default durability has changed between releases, so all
    policies that may differ are written out.
    """
    reliability = 1 if qos.is_reliable else 2
    durability = 1 if qos.is_transient_local else 2
    history = 1 if qos.history is History.KEEP_LAST else 2
    liveliness = "" if qos.liveliness is Liveliness.AUTOMATIC else "3"
    times = f"{_encode_time(qos.deadline)}:{_encode_time(qos.lifespan)}:{liveliness},{_encode_time(qos.lease)}"
    return f"{reliability}:{durability}:{history},{qos.depth}:{times}"


def decode_qos(text: str) -> Qos | None:
    """Parse the QoS profile of a token; return None if it is invalid."""
    try:
        reliability, durability, history, deadline, lifespan, liveliness = text.split(":")[:6]
        kept, depth = history.split(",")
        alive, lease = liveliness.split(",", 1)
        return Qos(
            _RELIABILITIES[reliability],
            _DURABILITIES[durability],
            _HISTORIES[kept],
            int(depth or _DEFAULT_DEPTH) or _DEFAULT_DEPTH,  # 0 is the default of the middleware
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
    """Parse a duration [ns]; None if it is infinite. Empty numbers are those of the infinite duration."""
    seconds, nanoseconds = text.split(",")
    total = int(seconds or INFINITE // _SECOND) * _SECOND + int(nanoseconds or INFINITE % _SECOND)
    return total if 0 < total < INFINITE else None


def _qualified(node: Node) -> str:
    return f"{_mangle(node.enclave)}/{_mangle(node.namespace)}/{node.name}"


def _mangle(name: str) -> str:
    return name.replace("/", "%") or "%"


def _demangle(part: str) -> str:
    return part.replace("%", "/")
