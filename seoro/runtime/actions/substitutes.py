"""Replacements for actions that the libraries of seoro only declare, for messages."""

from __future__ import annotations

from typing import Final

PROGRAM: Final = "write `run_process({command})` of `osc.helpers`"
COMMANDS: Final = {
    "docker_run": "'docker run --rm --init IMAGE COMMAND'",
    "docker_exec": "'docker exec CONTAINER COMMAND'",
    "docker_copy": "'docker cp CONTAINER:PATH .'",
    "docker_put": "'docker cp PATH CONTAINER:TARGET'",
    "kubernetes_create_from_yaml": "'kubectl apply -f FILE'",
    "kubernetes_delete": "'kubectl delete pod TARGET'",
    "kubernetes_patch_network_policy": "'kubectl patch networkpolicy TARGET -p PATCH'",
    "kubernetes_patch_pod": "'kubectl patch pod TARGET -p BODY'",
    "kubernetes_pod_exec": "'kubectl exec TARGET -- COMMAND'",
    "kubernetes_wait_for_network_policy_status": "'kubectl wait networkpolicy/TARGET --for=create'",
    "kubernetes_wait_for_pod_status": "'kubectl wait pod/TARGET --for=condition=Ready'",
    "capture_screen": "'ffmpeg -f x11grab -framerate 25 -i :0 capture.mp4', wait_for_shutdown: false",
}
_WORLD: Final = "run with `--sim pybullet --world WORLD`: seoro starts and steps the simulator"
OTHERS: Final = {
    "simulation_pybullet.initialize": _WORLD,
    "simulation_pybullet.run": _WORLD,
    "actor_pybullet.spawn": "write `spawn` of an `osc_actor`, of `osc.gazebo`, with `--sim pybullet`",
    "actor_pybullet.set_joint_motor_control": "write `drive` of `osc.driving`, with `--sim pybullet`",
    "actor_pybullet.distance_traveled": "write `odometry_distance_traveled` of `osc.ros`, with `--sim pybullet`",
}


def substitute(action: str, library: str) -> str:
    """Suggest a replacement for an action that a library only declares.

    Args:
        action: Name of the action.
        library: Name of the library.
    """
    name = library.removeprefix("osc.")
    command = COMMANDS.get(action)
    instead = PROGRAM.format(command=command) if command is not None else OTHERS.get(action)
    if instead is None:
        return f"the library `{library}` only declares it"
    return f"{instead}, or install the package `scenario_execution_{name}`, whose classes seoro runs"
