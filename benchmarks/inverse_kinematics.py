"""Inverse kinematics: share of random reachable poses that are found, and processor time of a request.

    python benchmarks/inverse_kinematics.py [--poses 1000]

Poses are those of the tool at configurations drawn within the joint limits; so all of them are reachable. Searches
begin at another random configuration. The arms are those of all robots whose packages are installed. Poses that
no arm can reach, 5 % beyond the stretched arm, and downward into its own base, are timed as well.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator

import numpy as np

from seoro.files.yaml_lines import FileError
from sim_nodes.geometry import Array
from sim_nodes.manipulation.chain import Chain
from sim_nodes.manipulation.inverse_kinematics import pose_error, solutions
from sim_nodes.noise import Noise
from sim_nodes.robots.reading import available_robots, load_robot


def load_chains() -> Iterator[tuple[str, Chain]]:
    """Yield the arms with a tool of all robots whose packages are installed, by name."""
    for name in available_robots():
        try:
            robot = load_robot(name)
        except FileError as error:
            print(f"left out: {error}", file=sys.stderr)
            continue
        if robot.arm is not None and robot.arm.tool_link is not None:
            joints = [joint.name for joint in robot.arm.joints]
            yield name, Chain(robot.urdf, robot.base_link, robot.arm.tool_link, joints)


def search(chain: Chain, target: Array, start: Array, home: Array) -> tuple[bool, float]:
    """Return whether a solution was found, and the processor time until then [s]."""
    begin = time.process_time()
    found = next(solutions(chain, target, start, home, Noise(0, "benchmark")), None)
    elapsed = time.process_time() - begin
    if found is not None:
        assert max(pose_error(chain.tool_pose(found), target)) < 1e-5
        assert np.all((found >= chain.limits.lower) & (found <= chain.limits.upper))
    return found is not None, elapsed


def measure(name: str, chain: Chain, poses: int) -> str:
    """Return the row of an arm."""
    draw = np.random.default_rng(0)
    lower, upper = chain.limits.lower, chain.limits.upper
    home, found, times, refusals = (lower + upper) / 2.0, 0, [], []
    for _ in range(poses):
        target, start = chain.tool_pose(draw.uniform(lower, upper)), draw.uniform(lower, upper)
        is_found, elapsed = search(chain, target, start, home)
        found += is_found
        times.append(elapsed)
    for scale in (1.05, 0.0):
        target = np.diag([1.0, -1.0, -1.0, 1.0])
        target[:3, 3] = np.add(chain.shoulder, (scale * chain.reach, 0.0, 0.0))
        is_found, elapsed = search(chain, target, home, home)
        refusals.append(f"{'found' if is_found else 'refused'} in {1e3 * elapsed:.0f}")
    millis = 1e3 * np.array(times)
    middle, high, top = np.median(millis), np.percentile(millis, 99), millis.max()
    return (
        f"| {name} | {len(home)} | {found}/{poses} ({found / poses:.2%}) | {millis.mean():.1f} | {middle:.1f} "
        f"| {high:.0f} | {top:.0f} | {refusals[0]} | {refusals[1]} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=1000, help="poses of each arm")
    options = parser.parse_args()
    print(
        "| arm | joints | found | mean [ms] | median | 99 % | maximum | beyond reach [ms] | in the shoulder [ms] |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, chain in load_chains():
        print(measure(name, chain, options.poses), flush=True)


if __name__ == "__main__":
    main()
