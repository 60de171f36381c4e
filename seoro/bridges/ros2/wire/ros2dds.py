"""Dialect of zenoh-bridge-ros2dds, the bridge of robots that use DDS.

    keys      <name>, without its first slash; begins with the namespace of the bridge, if it has one

    tokens    @/<session>/@ros2_lv/<MP|MS>/<key>/<type>/<QoS>
              @/<session>/@ros2_lv/<SS|SC|AS|AC>/<key>/<type>

Slashes within a part of a token are written `§`. Messages have no attachments, and nodes are not announced.
Source: liveliness_mgt.rs of eclipse-zenoh/zenoh-plugin-ros2dds.
"""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.ros2.wire.entities import Endpoint, Entity, Kind, Node
from seoro.bridges.ros2.wire.qos import Durability, History, Qos, Reliability

_SPACE = "@ros2_lv"
_SLASH = "§"
_KINDS = {kind.value: kind for kind in Kind}
_TOPIC_PARTS = 7
_SERVICE_PARTS = 6
_HASH = "typehash="  # type hash in the user data of DDS

# Numbers of DDS, which differ from those of rmw. Without a history, the last message is kept.
_DURABILITIES = {"": Durability.VOLATILE, "0": Durability.VOLATILE, "1": Durability.TRANSIENT_LOCAL}
_HISTORIES = {"0": History.KEEP_LAST, "1": History.KEEP_ALL}


@dataclass(frozen=True)
class Ros2Dds:
    """Bridge of robots that use DDS; it has its own domain and namespace."""

    @property
    def name(self) -> str:
        """Name on the command line."""
        return "ros2dds"

    @property
    def tokens(self) -> str:
        """Key expression of the tokens of all bridges."""
        return f"@/*/{_SPACE}/**"

    def token(self, entity: Entity) -> str | None:
        """Return the token with which a bridge would announce an endpoint; None for nodes."""
        match entity:
            case Node():
                return None
            case Endpoint(kind=kind):
                name, type_name = _escape(entity.name[1:]), _escape(entity.type)
                token = f"@/{entity.session}/{_SPACE}/{kind.value}/{name}/{type_name}"
                if kind in {Kind.PUBLISHER, Kind.SUBSCRIPTION}:
                    return f"{token}/{_encode_qos(entity.qos or Qos(), entity.type_hash)}"
                return token

    def parse(self, token: str) -> Entity | None:
        """Parse a token; return None if it is invalid, or is that of the bridge itself."""
        parts = token.split("/")
        if len(parts) < _SERVICE_PARTS or parts[0] != "@" or parts[2] != _SPACE:
            return None
        kind = _KINDS.get(parts[3])
        if kind is None:
            return None
        endpoint = Endpoint(kind, "/" + _unescape(parts[4]), _unescape(parts[5]), parts[1])
        if kind not in {Kind.PUBLISHER, Kind.SUBSCRIPTION}:
            return endpoint
        if len(parts) < _TOPIC_PARTS:
            return None
        qos, type_hash = _decode_qos("/".join(parts[6:]), kind)  # user data may have slashes
        return Endpoint(kind, endpoint.name, endpoint.type, endpoint.session, type_hash, qos)

    def key(self, name: str, type_name: str, type_hash: str | None) -> str:
        """Return the key of a topic or service, which does not contain its type."""
        return name.strip("/")

    def key_expression(self, name: str, type_name: str) -> str:
        """Return the key of a topic or service."""
        return self.key(name, type_name, None)

    def type_hash(self, key: str) -> str | None:
        """Return None: keys contain no types."""
        return None

    def gid(self, token: str) -> bytes:
        """Return an empty GID: messages do not identify their senders."""
        return b""

    def attachment(self, sequence: int, stamp: int, gid: bytes) -> bytes | None:
        """Return None: messages have no attachments."""
        return None


def _encode_qos(qos: Qos, type_hash: str | None) -> str:
    reliability = 1 if qos.is_reliable else 0
    durability = 1 if qos.is_transient_local else 0
    history = 0 if qos.history is History.KEEP_LAST else 1
    text = f":{reliability}:{durability}:{history},{qos.depth}"
    return text if type_hash is None else f"{text}:{_HASH}{type_hash};"


def _decode_qos(text: str, kind: Kind) -> tuple[Qos | None, str | None]:
    """Parse the QoS profile, if valid, and the type hash, if present."""
    parts = text.split(":", 4)
    type_hash = _find_hash(parts[4]) if len(parts) > 4 else None
    # The default of DDS differs between writers and readers.
    default = Reliability.RELIABLE if kind is Kind.PUBLISHER else Reliability.BEST_EFFORT
    reliabilities = {"": default, "0": Reliability.BEST_EFFORT, "1": Reliability.RELIABLE}
    try:
        _, reliability, durability, history = parts[:4]
        kept, depth = history.split(",") if history else ("0", "1")
        qos = Qos(reliabilities[reliability], _DURABILITIES[durability], _HISTORIES[kept], max(int(depth), 1))
    except (ValueError, KeyError):
        return None, type_hash
    return qos, type_hash


def _find_hash(user_data: str) -> str | None:
    items = (item for item in user_data.split(";") if item.startswith(_HASH))
    return next((item[len(_HASH) :] for item in items), None)


def _escape(name: str) -> str:
    return name.replace("/", _SLASH)


def _unescape(part: str) -> str:
    return part.replace(_SLASH, "/")
