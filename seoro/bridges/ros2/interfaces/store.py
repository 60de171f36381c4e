"""The interfaces of a ROS 2 system: what the rest of the room, and whoever uses it, asks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.bridges.ros2.interfaces.definitions import Structure
from seoro.bridges.ros2.interfaces.described import told_packages
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, InvalidValue, UnknownInterface
from seoro.bridges.ros2.interfaces.hashes import type_hash
from seoro.bridges.ros2.interfaces.messages import Message
from seoro.bridges.ros2.interfaces.packages import Package, bundled_packages, editions, packages_in
from seoro.bridges.ros2.interfaces.registry import Registry
from seoro.bridges.ros2.interfaces.text import schema
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.bridges.ros2.interfaces.codec import Codec
    from seoro.bridges.ros2.interfaces.values import Builder


class TypeStore:
    """Definitions, type hashes and messages, by the names of interfaces.

    Names are such as `geometry_msgs/msg/Pose`, or, of what services and actions consist of,
    `std_srvs/srv/SetBool_Request` and `nav2_msgs/action/Spin_SendGoal_Request`. All methods take them with dots
    instead of slashes, and without the kind where that is clear; errors name those that come near. Definitions are
    read when they are needed. A store never changes.

    Args:
        packages: The packages that it consists of, by name.
    """

    def __init__(self, packages: Mapping[str, Package]) -> None:
        self._packages = packages
        self._registry = Registry(packages)
        self._canonical: dict[str, str] = {}
        self._messages: dict[str, str] = {}
        self._hashes: dict[str, str] = {}

    @classmethod
    def bundled(cls, distribution: str = "jazzy") -> TypeStore:
        """The packages that come with seoro.

        Args:
            distribution: The distribution of ROS 2.

        Raises:
            InvalidUse: seoro has none of that distribution.
        """
        return cls(bundled_packages(distribution))

    def add_folder(self, path: Path) -> TypeStore:
        """A store that has the packages of a folder too.

        A package takes the place of the whole package of the same name in this store.

        Args:
            path: A folder with `PACKAGE/msg/X.msg`, `PACKAGE/srv/X.srv` and `PACKAGE/action/X.action`, such as
                `share` of an installation of ROS 2.

        Raises:
            InvalidUse: There is no such folder, or no interface in it.
            InvalidDefinition: A package or a file has a name that ROS 2 does not have.
        """
        return TypeStore({**self._packages, **packages_in(path)})

    def add_told(self, description: Message, origin: str) -> TypeStore:
        """A store in which the messages that a robot has described are as it says.

        Whoever asks for one of them compares its hash with the one that the robot announces.

        Args:
            description: A `type_description_interfaces/msg/TypeDescription`.
            origin: Who has told it, for messages.

        Raises:
            InvalidDefinition: Messages cannot be like that.
        """
        return TypeStore({**self._packages, **told_packages(description, self._packages, origin)})

    def names(self) -> tuple[str, ...]:
        """The full names of all messages, services and actions that are defined, sorted."""
        return self._registry.names()

    def canonical(self, name: str) -> str:
        """The full name of an interface: `std_msgs.msg.String` and `std_msgs/String` are `std_msgs/msg/String`.

        Raises:
            UnknownInterface: No package defines it, or the kind has to be said.
        """
        known = self._canonical.get(name)
        if known is None:
            known = self._canonical[name] = self._registry.canonical(name)
        return known

    def structure(self, name: str) -> Structure:
        """The fields and constants of an interface.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: Its definition cannot be read; says the file and the line.
        """
        return self._registry.structure(self.canonical(name))

    def type_hash(self, name: str) -> str:
        """The type hash, `RIHS01_` and 64 hexadecimal digits, that keys of rmw_zenoh have of it.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: Its definition cannot be read; says the file and the line.
        """
        name = self.canonical(name)
        known = self._hashes.get(name)
        if known is None:
            known = self._hashes[name] = type_hash(name, self._registry.structure)
        return known

    def matching(self, name: str, type_hash: str) -> TypeStore | None:
        """The store in which an interface has the hash that a robot says it has.

        That is this store if it agrees. Else it is one with another edition of the interface's package, if seoro
        has one that agrees; or else None.

        Args:
            name: The interface.
            type_hash: The hash, such as that of a key of rmw_zenoh.

        Raises:
            UnknownInterface: No package of this store defines it.
            InvalidDefinition: Its definition cannot be read; says the file and the line.
        """
        name = self.canonical(name)
        if self.type_hash(name) == type_hash:
            return self
        package = name.partition("/")[0]
        for edition in editions(package):
            store = TypeStore({**self._packages, package: edition})
            try:
                if store.type_hash(name) == type_hash:
                    return store
            except (UnknownInterface, InvalidDefinition):
                continue  # that edition has no such interface, or needs what other packages here have not
        return None

    def schema(self, name: str) -> str:
        """The definition of a message and of all that it refers to, as MCAP files have it (encoding `ros2msg`).

        Raises:
            UnknownInterface: No package defines it, or it is no message but a service or an action.
            InvalidDefinition: Its definition cannot be read; says the file and the line.
        """
        return schema(self._message_name(name), self._registry.structure)

    def message(self, name: str, value: Mapping[str, Any] | Message) -> Message:
        """A message of plain values.

        Args:
            name: The interface.
            value: The members: numbers, truth values, texts, lists, numpy arrays, mappings or messages. Those that
                are missing get the defaults of the definition, or else zero or empty.

        Raises:
            UnknownInterface: No package defines it, or it is no message but a service or an action.
            InvalidDefinition: Its definition cannot be read, or has a type that cannot be encoded.
            InvalidValue: A member does not fit; says its path and what was expected.
        """
        return self._builder.build(self._message_name(name), value)

    def encode(self, name: str, value: Mapping[str, Any] | Message) -> bytes:
        """The little-endian CDR of a message, with its header.

        Args and errors are those of `message`.
        """
        return self._codec.encode(self.message(name, value))

    def decode(self, name: str, payload: bytes) -> Message:
        """The message in a payload of CDR of either byte order. Arrays are views of the payload, and read-only.

        Raises:
            UnknownInterface: No package defines it, or it is no message but a service or an action.
            InvalidDefinition: Its definition cannot be read, or has a type that cannot be decoded.
            InvalidPayload: The payload is no message of that type.
        """
        return self._codec.decode(self._message_name(name), payload)

    def prepare(self, name: str) -> None:
        """Load and make what encodes and decodes a message, which takes some tenths of a second the first time.

        Raises:
            UnknownInterface: No package defines it, or it is no message but a service or an action.
            InvalidDefinition: Its definition cannot be read, or has a type that cannot be encoded.
        """
        self.decode(name, self.encode(name, {}))

    def plain(self, name: str, message: Message) -> dict[str, Any]:
        """A message as dictionaries, lists, numbers and texts, in the order of the definition.

        Raises:
            InvalidValue: The message is of another type.
        """
        from seoro.bridges.ros2.interfaces.plain import plain  # noqa: PLC0415 - imports numpy

        name = self._message_name(name)
        if message.__msgtype__ != name:
            raise InvalidValue(name, "", f"expected a {name}, got a {message.__msgtype__}")
        return plain(message)

    def _message_name(self, name: str) -> str:
        known = self._messages.get(name)
        if known is None:
            known = self._messages[name] = self._registry.message(name)
        return known

    @cached_property
    def _codec(self) -> Codec:
        try:
            from seoro.bridges.ros2.interfaces.codec import Codec  # noqa: PLC0415 - imports rosbags and numpy
        except ModuleNotFoundError as error:
            raise InvalidUse(
                f"messages of ROS 2 need {error.name}", help="install it with: pip install 'seoro[ros2]'"
            ) from None
        return Codec(self._registry.structure)

    @cached_property
    def _builder(self) -> Builder:
        from seoro.bridges.ros2.interfaces.values import Builder  # noqa: PLC0415 - imports numpy

        return Builder(self._registry.structure, self._codec.message_class)
