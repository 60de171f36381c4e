"""A fake of zenoh-bridge-ros2dds in front of a DDS robot, written after the plugin's sources.

It is the router of a test. It uses no code of seoro: tokens and keys are literals here, so that the tests compare
the dialect of seoro with an independent implementation. The robot has:

- a publisher of /chatter, whose messages are forwarded only while Zenoh has a subscriber;
- a latched publisher of /map_name, which keeps forwarded messages for late subscribers;
- a subscription of /cmd_vel, which forwards each message;
- a server of /add, which drops invalid requests, since the bridge cannot reply with an error.
"""

import json
import struct
from typing import Any

import zenoh
import zenoh.ext
from zenoh.handlers import Callback

STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
TWIST_HASH = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
HEADER = b"\0\1\0\0"
QUERIES_TIMEOUT = 5.0  # [s] default time limit of a server


class FakeBridge:
    """The bridge at an endpoint, for a namespace such as `bot1/` or none."""

    def __init__(self, endpoint: str, namespace: str = "") -> None:
        settings = {
            "mode": "router",
            "listen": {"endpoints": [endpoint]},
            "scouting": {
                "multicast": {"enabled": False},
                "gossip": {"enabled": True, "autoconnect": {"router": []}},
                "delay": 20,
            },
            "timestamping": {"enabled": True},
        }
        self._zenoh = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
        self._namespace = namespace
        self._zid = str(self._zenoh.zid())
        self.arrived: list[tuple[bytes, bytes | None]] = []
        self.announced: dict[str, bool] = {}
        self._kept: list[Any] = [self._token("")]
        self._chatter = self._publisher("chatter")
        self._map_name = zenoh.ext.declare_advanced_publisher(
            self._zenoh, f"{namespace}map_name", cache=zenoh.ext.CacheConfig(10), publisher_detection=True
        )
        self._topic("MP", "map_name", "std_msgs§msg§String", ":1:1:0,1")
        self._subscribe("cmd_vel")
        self._serve("add")
        self._watch()

    def _token(self, what: str) -> Any:
        ending = f"/{what}" if what else ""
        return self._zenoh.liveliness().declare_token(f"@/{self._zid}/@ros2_lv{ending}")

    def _topic(self, kind: str, name: str, type_name: str, qos: str, type_hash: str = STRING_HASH) -> None:
        key = f"{self._namespace}{name}".replace("/", "§")
        self._kept.append(self._token(f"{kind}/{key}/{type_name}/{qos}:typehash={type_hash};"))

    def _publisher(self, name: str) -> Any:
        self._topic("MP", name, "std_msgs§msg§String", ":1:0:0,10")
        return self._zenoh.declare_publisher(f"{self._namespace}{name}")

    def _subscribe(self, name: str) -> None:
        def forward(sample: zenoh.Sample) -> None:
            attachment = sample.attachment
            self.arrived.append((sample.payload.to_bytes(), attachment.to_bytes() if attachment else None))

        callback = Callback(forward, indirect=False)
        self._kept.append(self._zenoh.declare_subscriber(f"{self._namespace}{name}", callback))
        self._topic("MS", name, "geometry_msgs§msg§Twist", ":1:0:0,10", TWIST_HASH)

    def _serve(self, name: str) -> None:
        key = f"{self._namespace}{name}"

        def respond(query: zenoh.Query) -> None:
            payload = query.payload.to_bytes() if query.payload is not None else b""
            if len(payload) == 20 and payload[:4] == HEADER:
                with query:
                    query.reply(key, HEADER + struct.pack("<q", sum(struct.unpack("<qq", payload[4:]))))
            else:
                self._kept.append(query)  # no reply: the client's timeout ends the call

        callback = Callback(respond, indirect=False)
        self._kept.append(self._zenoh.declare_queryable(key, callback, complete=False))
        self._kept.append(self._token(f"SS/{key.replace('/', '§')}/example_interfaces§srv§AddTwoInts"))

    def _watch(self) -> None:
        """Follow the announcements of other bridges."""

        def note(sample: zenoh.Sample) -> None:
            self.announced[str(sample.key_expr)] = sample.kind == zenoh.SampleKind.PUT

        callback = Callback(note, indirect=False)
        self._kept.append(self._zenoh.liveliness().declare_subscriber("@/*/@ros2_lv/**", callback, history=True))

    def robot_says(self, text: str) -> bool:
        """Publish a message of the robot; return False without a subscriber: the bridge does not read it then."""
        if not self._chatter.matching_status.matching:
            return False
        self._chatter.put(_string(text))
        return True

    def robot_latches(self, text: str) -> None:
        """Publish a latched message of the robot."""
        self._map_name.put(_string(text))

    def close(self) -> None:
        self._zenoh.close()  # type: ignore[no-untyped-call]


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return HEADER + struct.pack("<I", len(data)) + data
