"""A simulator node of level `drive`, with `zenoh` and `msgpack` alone: `python minimal_node.py ENDPOINT`."""

import cmath
import json
import math
import sys
import threading

import msgpack
import zenoh

STEP = 0.01  # [s]
ROBOT = {"name": "dot", "kinds": ["differential_drive_robot", "robot", "osc_actor"]}
UNSUPPORTED = 0


class Simulator:
    def load_world(self, request):
        self.steps, self.end, self.goal = 0, 0, ""
        self.position, self.yaw, self.ahead, self.turn = 0j, 0.0, 0.0, 0.0  # [m], [rad], [m/s], [rad/s]
        return self.get_simulator_features(request)

    def get_simulator_features(self, _):
        verbs = [name for name in vars(Simulator) if not name.startswith("_")]
        clock = {"time": self.steps * STEP, "step": STEP, "state": "paused"}
        return {"features": verbs, "robots": [ROBOT], "world": "floor", **clock}

    def advance(self, request):
        while (now := self.steps * STEP) < request["until"] - 1e-9:
            if self.goal and self.steps == self.end:
                occurrence = {"id": self.goal, "time": now, "outcome": "succeeded"}
                self.stop_robot({})
                return {"time": now, "occurrences": [occurrence]}
            self.position += cmath.rect(self.ahead * STEP, self.yaw + self.turn * STEP / 2)
            self.yaw += self.turn * STEP
            self.steps += 1
        return {"time": now}

    def drive(self, request):
        self.goal, self.ahead, self.turn = request["id"], request["linear"], request["angular"]
        self.end = self.steps + math.ceil(request["duration"] / STEP - 1e-9)

    def stop_robot(self, _):
        self.goal, self.ahead, self.turn = "", 0.0, 0.0

    cancel_goal = reset_simulation = stop_robot

    def get_relative_pose(self, request):
        point = self.position + cmath.rect(request["distance"], self.yaw)
        turned = {"roll": 0.0, "pitch": 0.0, "yaw": math.remainder(self.yaw, math.tau)}
        return {"position": {"x": point.real, "y": point.imag, "z": 0.0}, "orientation": turned}


def answer(query):
    key = str(query.key_expr)
    if carry_out := getattr(simulator, key.rpartition("/")[2].lstrip("_"), None):
        query.reply(key, msgpack.packb(carry_out(msgpack.unpackb(query.payload.to_bytes())) or {}))
    else:
        query.reply_err(msgpack.packb({"code": UNSUPPORTED, "message": f"unknown verb: {key}"}))


simulator = Simulator()
simulator.load_world({})
network = {"mode": "router", "listen/endpoints": [sys.argv[1]], "scouting/multicast/enabled": False}
configuration = zenoh.Config()
for path, value in network.items():
    configuration.insert_json5(path, json.dumps(value))
with zenoh.open(configuration) as session:
    queryable = session.declare_queryable("seoro/1/default/node/minimal/cmd/*", answer)
    token = session.liveliness().declare_token("seoro/1/default/alive/node/minimal/1")
    print("ready", flush=True)
    threading.Event().wait()
