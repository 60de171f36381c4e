"""A simulator node in its own process, without code of seoro: `python odd_node.py ENDPOINT FAULT`.

It has a clock, and one robot that can be stopped. `FAULT` names its violation of the protocol.
"""

import json
import math
import os
import sys
import time

import msgpack
import zenoh

FAULT = sys.argv[2]
MAJOR = 2 if FAULT == "version" else 1
VERBS: tuple[str, ...] = ("get_simulator_features", "load_world", "advance", "stop_robot", "reset_simulation")
if FAULT.startswith("error"):
    VERBS += ("reinitialize_global_localization", "watch_localization", "get_localization")


class Node:
    def __init__(self) -> None:
        self.now = 0.0

    def features(self) -> dict[str, object]:
        return {
            "engine": "odd",
            "engine_version": "1",
            "version": "1",
            "features": VERBS,
            "spawn_formats": (),
            "world": "plain",
            "available_worlds": ("plain",),
            "robots": ({"name": "robot", "kinds": ("differential_drive_robot", "osc_actor"), "frames": ()},),
            "time": math.nan if FAULT == "first time" else self.now,
            "step": {"step 0": 0.0, "step nan": math.nan, "step -1": -1.0}.get(FAULT, 0.01),
            "state": "paused",
        }

    def advance(self, until: float) -> dict[str, object]:
        before = self.now
        self.now = max(before, until)
        answer: dict[str, object] = {"time": self.now}
        match FAULT:
            case "nan":
                answer["time"] = math.nan
            case "infinite":
                answer["time"] = math.inf
            case "back" if before > 1.0:
                answer["time"] = before - 0.5
            case "beyond":
                answer["time"] = self.now = until + 5.0
            case "stands":
                answer["time"] = self.now = 0.0
            case "leaves":
                position, extent = {"x": 2.5, "y": 0.0, "z": 0.0}, (-2.0, -2.0, 2.0, 2.0)
                answer["departures"] = [
                    {"time": self.now, "robot": "robot", "position": position, "extent": extent}
                ]
            case "ahead":
                answer["contacts"] = [{"time": self.now + 0.5, "first": "robot", "second": "box"}]
            case "late":
                answer["contacts"] = [{"time": before - 0.5, "first": "robot", "second": "box"}]
            case "time of nothing":
                answer["contacts"] = [{"time": math.nan, "first": "robot", "second": "box"}]
            case "goal":
                answer["occurrences"] = [{"id": "goal-7", "time": self.now, "outcome": "succeeded"}]
        return answer

    def carry_out(self, verb: str, request: dict[str, float]) -> dict[str, object]:
        match verb:
            case "get_simulator_features":
                return self.features()
            case "load_world":
                self.now = 0.0
                return self.features()
            case "advance":
                return self.advance(request["until"])
            case "get_localization":
                error = {"error nan": math.nan, "error -1": -1.0}.get(FAULT, 0.1)
                return {"pose": None, "covariance": None, "particles": 0, "error": error}
        return {}


def main() -> None:
    node = Node()
    settings = {
        "mode": "router",
        "listen": {"endpoints": [sys.argv[1]]},
        "scouting": {"multicast": {"enabled": False}},
    }
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))

    def answer(query: zenoh.Query) -> None:
        key = str(query.key_expr)
        verb = key.rsplit("/", 1)[-1]
        with query:
            if verb in VERBS:
                request = msgpack.unpackb(query.payload.to_bytes()) if query.payload else {}
                query.reply(key, msgpack.packb(node.carry_out(verb, request)))
            else:
                query.reply_err(msgpack.packb({"code": 0, "message": f"unknown verb {verb!r}"}))

    queryable = session.declare_queryable(f"seoro/{MAJOR}/default/node/odd/cmd/*", answer)
    token = session.liveliness().declare_token(f"seoro/{MAJOR}/default/alive/node/odd/b1")
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    time.sleep(60.0)
    del queryable, token
    os._exit(0)


if __name__ == "__main__":
    main()
