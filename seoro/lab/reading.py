"""Reading and checking of lab files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.files.world_names import WorldName
from seoro.files.yaml_lines import Lines, read_settings
from seoro.lab.schema import BridgeFile, LabFile, RobotFile, SimulatorFile


class Lab:
    """A lab file that was read.

    Args:
        file: Content of the file.
        lines: Positions of its keys.
        folder: Folder of the file.
    """

    def __init__(self, file: LabFile, lines: Lines, folder: Path) -> None:
        self._file = file
        self._lines = lines
        self._folder = folder

    @property
    def simulator(self) -> tuple[str, SimulatorFile] | None:
        """Name in the lab and description of the simulator; None without one."""
        return next(iter(self._file.simulators.items()), None)

    @property
    def world(self) -> str | None:
        """World of the simulator; a world file with an absolute path."""
        if self.simulator is None or (world := self.simulator[1].world) is None:
            return None
        return WorldName.parse(world).located(lambda path: resolved(self._folder / path))

    @property
    def bridges(self) -> Mapping[str, BridgeFile]:
        """Bridges, by their names in the lab."""
        return self._file.bridges

    @property
    def robots(self) -> Mapping[str, RobotFile]:
        """Robots, by their names in the lab, which are those of their actors by default."""
        return self._file.robots

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Endpoints of all running nodes."""
        named = [each.connect for each in self._file.bridges.values()]
        named += [each.connect for each in self._file.simulators.values() if each.connect is not None]
        return tuple(dict.fromkeys(named))

    @property
    def bag(self) -> Path | None:
        """Bag of the recorded robots; None without one."""
        return next((self._folder / robot.bag for robot in self._file.robots.values() if robot.bag), None)

    @property
    def is_recorded(self) -> bool:
        """Whether all robots are recorded, so that their bag is the clock of runs."""
        return self.bag is not None and not self._file.simulators and not self._file.bridges

    def address(self, where: str | None) -> tuple[str | None, str | None]:
        """Return the endpoint of a simulator or bridge and its name there.

        Without an endpoint, the simulator is started for runs; without a name, it is the only node there.
        Recorded robots are at the address (None, None).
        """
        if where is None:
            return None, None
        if where in self._file.bridges:
            bridge = self._file.bridges[where]
            return bridge.connect, bridge.name
        simulator = self._file.simulators[where]
        return simulator.connect, simulator.name

    def remote_name(self, robot: str) -> str:
        """Return the name of a robot at its node."""
        return self._file.robots[robot].name_there or robot

    def position_of(self, actor: str) -> str:
        """Return the file and line of the robot of an actor."""
        return self._lines.at(("robots", actor))

    def profile_of(self, robot: str) -> str | Path | None:
        """Return the name or the file of the profile of a recorded robot; None without one."""
        profile = self._file.robots[robot].profile
        return self._folder / profile if profile is not None and profile.endswith(".yaml") else profile

    def reset_of(self, robot: str) -> Path | None:
        """Return the file of the reset scenario of a robot; None without one.

        Raises:
            UsageError: The file is missing.
        """
        after = self._file.robots[robot].after
        if after is None or after.scenario is None:
            return None
        path = self._folder / after.scenario
        if not path.is_file():
            place = self._lines.at(("robots", robot, "after", "scenario"))
            raise UsageError(f"{place}: robots.{robot}.after: file not found: {path}")
        return path

    def check(self) -> None:
        """Check rules that the schema does not express.

        Raises:
            UsageError: A rule is broken; lists all problems.
        """
        found = list(self._conflicts())
        if found:
            raise UsageError("; ".join(found))

    def _conflicts(self) -> Iterator[str]:
        file, at = self._file, self._lines.at
        recorded = {name: robot for name, robot in file.robots.items() if robot.bag is not None}
        if not file.simulators and not file.bridges and not recorded:
            yield f"{at(())}: the lab has neither a simulator nor a bridge"
        yield from self._conflicts_of_bags(recorded)
        for name in list(file.simulators)[1:]:
            yield (
                f"{at(('simulators', name))}: simulators.{name}: a run has one simulator, which is its clock: put "
                f"all simulated robots into {next(iter(file.simulators))}"
            )
        for name in file.simulators.keys() & file.bridges.keys():
            yield f"{at(('bridges', name))}: bridges.{name}: duplicate name, also of a simulator"
        known = {*file.simulators, *file.bridges}
        taken: dict[tuple[str, str], str] = {}
        for actor, robot in file.robots.items():
            if robot.where is None:
                continue
            if robot.where not in known:
                yield (
                    f"{at(('robots', actor, 'in'))}: robots.{actor}: unknown simulator or bridge "
                    f"'{robot.where}' (simulators and bridges of this file: {', '.join(sorted(known)) or 'none'})"
                )
            remote = (robot.where, robot.name_there or actor)
            if remote in taken:
                yield f"{self.position_of(actor)}: robots.{actor}: duplicate robot, also of {taken[remote]}"
            taken[remote] = actor

    def _conflicts_of_bags(self, recorded: Mapping[str, RobotFile]) -> Iterator[str]:
        for name, robot in recorded.items():
            if self._folder / str(robot.bag) != self.bag:
                place = self._lines.at(("robots", name, "bag"))
                yield f"{place}: robots.{name}: the recorded robots of a lab have one bag: expected {self.bag}"


def read_lab(path: Path) -> Lab:
    """Read a lab file.

    Raises:
        UsageError: The file cannot be read or is invalid; the message has the file and the line.
    """
    file, lines = read_settings(path, LabFile)
    lab = Lab(file, lines, path.parent)
    lab.check()
    return lab
