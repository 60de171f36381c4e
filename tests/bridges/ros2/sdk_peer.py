"""A node of another implementation of the rmw_zenoh protocol, for tests: `python sdk_peer.py PORT`.

It reads lines `publish TEXT` (on /from_sdk) and `call A B` (of /seoro_add). It prints messages on /to_sdk,
requests to its /sdk_add and the results of its calls. Definitions are literals, so that the node does not search
the network for them.
"""

import sys

from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2ServiceServer, ROS2Subscriber

REQUEST = "int64 a\nint64 b\n"
RESPONSE = "int64 sum\n"


def report(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def main() -> None:
    where = {"router_port": int(sys.argv[1]), "domain_id": 0}
    string = {"msg_type": "std_msgs/msg/String", "msg_definition": "string data\n"}
    add = {
        "srv_type": "example_interfaces/srv/AddTwoInts",
        "request_definition": REQUEST,
        "response_definition": RESPONSE,
    }
    publisher = ROS2Publisher("/from_sdk", **string, **where, node_name="sdk_talker")
    ROS2Subscriber("/to_sdk", callback=lambda message: report("received", message.data), **string, **where)

    def respond(request: object) -> object:
        report("asked", request.a, request.b)  # type: ignore[attr-defined]
        return server.response_msg_class(sum=request.a + request.b)  # type: ignore[attr-defined]

    server = ROS2ServiceServer("/sdk_add", callback=respond, **add, **where)
    client = ROS2ServiceClient("/seoro_add", **add, **where, timeout=5.0)
    report("ready")
    for line in sys.stdin:
        match line.split():
            case ["publish", text]:
                publisher.publish(data=text)
            case ["call", a, b]:
                response = client.call(a=int(a), b=int(b))
                report("called", response.sum if response else None)


if __name__ == "__main__":
    main()
