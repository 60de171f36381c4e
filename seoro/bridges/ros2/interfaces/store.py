"""Store of interface definitions: the main type of this package."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.bridges.ros2.interfaces.definitions import Structure
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, InvalidValue, UnknownInterface
from seoro.bridges.ros2.interfaces.messages import Message, plain
from seoro.bridges.ros2.interfaces.packages import Package, bundled_packages, editions, packages_in
from seoro.bridges.ros2.interfaces.registry import Registry
from seoro.bridges.ros2.interfaces.schema_text import schema_packages
from seoro.bridges.ros2.interfaces.text import schema
from seoro.bridges.ros2.interfaces.type_descriptions import remote_packages, type_hash
from seoro.errors import UsageError

if TYPE_CHECKING:
    from seoro.bridges.ros2.interfaces.codec import Codec
    from seoro.bridges.ros2.interfaces.values import Builder


class TypeStore:
    """Definitions, type hashes and messages, by the names of interfaces.

    Names are such as `geometry_msgs/msg/Pose`. The messages of services and actions have names such as
    `std_srvs/srv/SetBool_Request` and `nav2_msgs/action/Spin_SendGoal_Request`. All methods accept names with dots
    instead of slashes, and without the kind if that is unambiguous. Errors list similar names. Definitions are
    read when they are needed. A store is immutable.

    Args:
        packages: The packages by name.
    """

    def __init__(self, packages: Mapping[str, Package]) -> None:
        self._packages = packages
        self._registry = Registry(packages)
        self._full_name = cache(self._registry.canonical)
        self._message_name = cache(self._registry.message)
        self._type_hash = cache(partial(type_hash, lookup=self._registry.structure))

    @classmethod
    def bundled(cls, distribution: str = "jazzy", folders: Iterable[Path] = ()) -> TypeStore:
        """Return the store of the packages that come with seoro.

        Args:
            distribution: ROS 2 distribution of the packages.
            folders: Folders with further packages; see `add_folder`.

        Raises:
            UsageError: The distribution is unknown, or a folder is invalid.
        """
        types = cls(bundled_packages(distribution))
        for folder in folders:
            types = types.add_folder(folder)
        return types

    def add_folder(self, path: Path) -> TypeStore:
        """Return a store with the packages of a folder, which replace packages of the same name.

        Args:
            path: A folder with `PACKAGE/msg/X.msg`, `PACKAGE/srv/X.srv` and `PACKAGE/action/X.action`, such as
                `share` of an installation of ROS 2.

        Raises:
            UsageError: The folder is missing, or contains no interface.
            InvalidDefinition: The name of a package or file is invalid in ROS 2.
        """
        return TypeStore({**self._packages, **packages_in(path)})

    def add_remote(self, description: Message, origin: str) -> TypeStore:
        """Return a store with the messages that a robot has described.

        The caller must compare the hash of a message with the hash that the robot announces.

        Args:
            description: A `type_description_interfaces/msg/TypeDescription`.
            origin: Node that has sent it, for messages.

        Raises:
            InvalidDefinition: The description is invalid.
        """
        return TypeStore({**self._packages, **remote_packages(description, self._packages, origin)})

    def add_schema(self, name: str, text: str, origin: str) -> TypeStore:
        """Return a store with the messages of a text, as of `schema`.

        Args:
            name: Full name of the message.
            text: Its definitions, in the MCAP encoding `ros2msg`.
            origin: Origin of the text, for messages.

        Raises:
            InvalidDefinition: The text is invalid.
        """
        return TypeStore({**self._packages, **schema_packages(name, text, self._packages, origin)})

    def names(self) -> tuple[str, ...]:
        """Return the full names of all messages, services and actions, sorted."""
        return self._registry.names()

    def canonical(self, name: str) -> str:
        """Return the full name of an interface, such as `std_msgs/msg/String` for `std_msgs/String`.

        Raises:
            UnknownInterface: The interface is unknown, or its kind is ambiguous.
        """
        return self._full_name(name)

    def structure(self, name: str) -> Structure:
        """Return the fields and constants of an interface.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: The definition is invalid; the message has the file and line.
        """
        return self._registry.structure(self.canonical(name))

    def type_hash(self, name: str) -> str:
        """Return the type hash of an interface, as in keys of rmw_zenoh: `RIHS01_` and 64 hexadecimal digits.

        Raises:
            UnknownInterface: No package defines it.
            InvalidDefinition: The definition is invalid; the message has the file and line.
        """
        return self._type_hash(self.canonical(name))

    def matching(self, name: str, type_hash: str) -> TypeStore | None:
        """Return the store in which an interface has the hash that a robot announces.

        It is this store if the hash matches, else one with another edition of the package, else None.

        Args:
            name: Name of the interface.
            type_hash: Type hash, as in keys of rmw_zenoh.

        Raises:
            UnknownInterface: No package of this store defines it.
            InvalidDefinition: The definition is invalid; the message has the file and line.
        """
        name = self.canonical(name)
        if self.type_hash(name) == type_hash:
            return self
        for store in self.editions(name):
            try:
                if store.type_hash(name) == type_hash:
                    return store
            except (UnknownInterface, InvalidDefinition):
                continue  # the edition lacks the interface, or refers to unknown interfaces
        return None

    def editions(self, name: str) -> Iterator[TypeStore]:
        """Yield stores with the editions of the package of an interface that come with seoro."""
        for edition in editions(self.canonical(name).partition("/")[0]):
            yield TypeStore({**self._packages, **edition})

    def schema(self, name: str) -> str:
        """Return the definitions of a message and of its nested types, in the MCAP encoding `ros2msg`.

        Raises:
            UnknownInterface: The interface is unknown, or is a service or an action.
            InvalidDefinition: The definition is invalid; the message has the file and line.
        """
        return schema(self._message_name(name), self._registry.structure)

    def message(self, name: str, value: Mapping[str, Any] | Message) -> Message:
        """Make a message from plain values.

        Args:
            name: Name of the interface.
            value: Members: numbers, booleans, strings, lists, numpy arrays, mappings or messages. Missing members
                get the defaults of the definition, or else zero or empty.

        Raises:
            UnknownInterface: The interface is unknown, or is a service or an action.
            InvalidDefinition: The definition is invalid, or has an unsupported type.
            InvalidValue: A member does not fit; the message has its path and the expected value.
        """
        return self._builder.build(self._message_name(name), value)

    def encode(self, name: str, value: Mapping[str, Any] | Message) -> bytes:
        """Encode a message as little-endian CDR with its header.

        Args and errors are those of `message`.
        """
        return self._codec.encode(self.message(name, value))

    def decode(self, name: str, payload: bytes) -> Message:
        """Decode a message from CDR of either byte order. Arrays are read-only views of the payload.

        Raises:
            UnknownInterface: The interface is unknown, or is a service or an action.
            InvalidDefinition: The definition is invalid, or has an unsupported type.
            InvalidPayload: The payload is not a valid message of the type.
        """
        return self._codec.decode(self._message_name(name), payload)

    def prepare(self, name: str) -> None:
        """Prepare the encoder and the decoder of a message, which takes some tenths of a second the first time.

        Raises:
            UnknownInterface: The interface is unknown, or is a service or an action.
            InvalidDefinition: The definition is invalid, or has an unsupported type.
        """
        self.decode(name, self.encode(name, {}))

    def plain(self, name: str, message: Message) -> dict[str, Any]:
        """Convert a message to dictionaries, lists, numbers and strings, in the order of the definition.

        Raises:
            InvalidValue: The message is of another type.
        """
        name = self._message_name(name)
        if message.__msgtype__ != name:
            raise InvalidValue(name, "", f"expected a {name}, got a {message.__msgtype__}")
        return plain(message)

    @cached_property
    def _codec(self) -> Codec:
        try:
            from seoro.bridges.ros2.interfaces.codec import Codec  # noqa: PLC0415 - imports rosbags and numpy
        except ModuleNotFoundError as error:
            raise UsageError(
                f"messages of ROS 2 need {error.name}", help="install it with: pip install 'seoro[ros2]'"
            ) from None
        return Codec(self._registry.structure)

    @cached_property
    def _builder(self) -> Builder:
        from seoro.bridges.ros2.interfaces.values import Builder  # noqa: PLC0415 - imports numpy

        return Builder(self._registry.structure, self._codec.message_class)
