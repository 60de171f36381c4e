"""Every device accepts or refuses each fault, as in the table of `docs/how-to/faults.md`."""

from __future__ import annotations

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadArea,
    DeadBeams,
    DeadPixels,
    DeadSector,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Quantity,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client
from tests.sim_nodes.engines import needs_pictures
from tests.sim_nodes.manipulation.cell import ARM, Cell

QUANTITIES = {
    "lidar": Quantity.LENGTH,
    "odometry": Quantity.ANGLE,
    "imu": Quantity.ACCELERATION,
    "front": Quantity.BRIGHTNESS,
    "wrist": Quantity.BRIGHTNESS,
    "motors": Quantity.ANGULAR_RATE,
    "joints": Quantity.ANGLE,
    "gripper": Quantity.LENGTH,
}
ARRIVALS = {"message_loss", "freeze", "delay", "power_loss"}
VALUES = {"gaussian_noise", "bias"}
BEAMS = {"beam_loss", "dead_sector", "dead_beams"}
PIXELS = {"dead_pixels", "dead_area"}
POSSIBLE = {
    "lidar": ARRIVALS | VALUES | BEAMS,
    "odometry": ARRIVALS | VALUES,
    "imu": ARRIVALS | VALUES,
    "bumper": ARRIVALS,
    "front": ARRIVALS | VALUES | PIXELS,
    "wrist": ARRIVALS | VALUES | PIXELS,
    "motors": ARRIVALS | VALUES | {"wheel_slip"},
    "joints": ARRIVALS | VALUES,
    "gripper": ARRIVALS | VALUES,
    "robot": {"power_loss"},
}


def faults(device: str) -> tuple[Fault, ...]:
    """Return a fault of each kind, with the quantities of the device, if it has any."""
    quantity = QUANTITIES.get(device, Quantity.LENGTH)
    return (
        GaussianNoise(deviation={quantity: 0.05}),
        Bias(offset={quantity: 0.05}),
        BeamLoss(share=0.5),
        DeadSector(start=0.0, end=1.0),
        DeadBeams(beams=(0, 1)),
        DeadPixels(share=0.1),
        DeadArea(left=0.0, top=0.0, right=0.5, bottom=1.0),
        MessageLoss(probability=0.5),
        Freeze(),
        Delay(time=0.2),
        WheelSlip(left=0.5, right=0.5),
        PowerLoss(),
    )


@pytest.mark.parametrize("robot", [ROBOT, ARM])
def test_every_device_accepts_or_refuses_each_fault(robot: str) -> None:
    needs_pictures("mujoco")
    client = Cell() if robot == ARM else Client("empty")
    [info] = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    for device in info.devices:
        taken = set()
        for fault in faults(device):
            request = wire.InjectFault(id="fault", robot=robot, device=device, fault=fault, limit=1.0)
            try:
                client.ask(wire.INJECT_FAULT, request)
                client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="fault"))
            except RequestRefused as refused:
                assert str(refused).startswith(f"{device} cannot have {fault.kind}"), refused
            else:
                taken.add(fault.kind)
        assert taken == POSSIBLE[device], device
    assert set(info.devices) <= POSSIBLE.keys()
