"""Reading lab files, and finding what is wrong with them before anything is started."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from pydantic import ValidationError

from seoro.errors import InvalidUse
from seoro.input_files import resolved
from seoro.lab.schema import BridgeFile, LabFile, RobotFile, SimulatorFile
from seoro.yaml_files import FileError, Lines, problems, read_text, read_yaml


class Lab:
    """A lab file that has been read.

    Args:
        file: What it says.
        lines: Where in the file it says so.
        folder: Of the file.
    """

    def __init__(self, file: LabFile, lines: Lines, folder: Path) -> None:
        self._file = file
        self._lines = lines
        self._folder = folder

    @property
    def simulator(self) -> tuple[str, SimulatorFile] | None:
        """The simulator with its name in the lab, if there is one."""
        return next(iter(self._file.simulators.items()), None)

    @property
    def world(self) -> str | None:
        """The world of the simulator; a file with its folder."""
        if self.simulator is None or (world := self.simulator[1].world) is None:
            return None
        return str(resolved(self._folder / world)) if Path(world).suffix in {".yaml", ".yml"} else world

    @property
    def bridges(self) -> Mapping[str, BridgeFile]:
        """The bridges, by their names in the lab."""
        return self._file.bridges

    @property
    def robots(self) -> Mapping[str, RobotFile]:
        """The robots, by their names, which are those of actors unless actors are bound otherwise."""
        return self._file.robots

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Where everything of it is reached that runs already."""
        named = [each.connect for each in self._file.bridges.values()]
        named += [each.connect for each in self._file.simulators.values() if each.connect is not None]
        return tuple(dict.fromkeys(named))

    def address(self, where: str) -> tuple[str | None, str | None]:
        """Endpoint of a simulator or bridge, None if it is started for runs, and its name there if it has one."""
        if where in self._file.bridges:
            bridge = self._file.bridges[where]
            return bridge.connect, bridge.name
        simulator = self._file.simulators[where]
        return simulator.connect, simulator.name

    def called(self, robot: str) -> str:
        """What a robot is called where it lives."""
        return self._file.robots[robot].called or robot

    def place(self, actor: str) -> str:
        """The file and line where it has a robot."""
        return self._lines.at(("robots", actor))

    def reset_of(self, robot: str) -> Path | None:
        """The file of the scenario by which a robot is left in order, if it is.

        Raises:
            InvalidUse: There is no such file.
        """
        after = self._file.robots[robot].after
        if after is None or after.scenario is None:
            return None
        path = self._folder / after.scenario
        if not path.is_file():
            place = self._lines.at(("robots", robot, "after", "scenario"))
            raise InvalidUse(f"{place}: robots.{robot}.after: there is no file {path}")
        return path

    def check(self) -> None:
        """Check what the form alone does not tell.

        Raises:
            InvalidUse: Something cannot be; lists everything that cannot.
        """
        found = list(self._contradictions())
        if found:
            raise InvalidUse("; ".join(found))

    def _contradictions(self) -> Iterator[str]:
        file, at = self._file, self._lines.at
        if not file.simulators and not file.bridges:
            yield f"{at(())}: the lab has neither a simulator nor a bridge"
        for name in list(file.simulators)[1:]:
            yield (
                f"{at(('simulators', name))}: simulators.{name}: the clock of a run is that of one simulator: put "
                f"what is simulated into {next(iter(file.simulators))}"
            )
        for name in file.simulators.keys() & file.bridges.keys():
            yield f"{at(('bridges', name))}: bridges.{name}: a simulator is called {name}, too"
        known = {*file.simulators, *file.bridges}
        taken: dict[tuple[str, str], str] = {}
        for actor, robot in file.robots.items():
            if robot.where not in known:
                yield (
                    f"{at(('robots', actor, 'in'))}: robots.{actor}: there is no simulator and no bridge "
                    f"'{robot.where}' in this lab: there are {', '.join(sorted(known))}"
                )
            home = (robot.where, robot.called or actor)
            if home in taken:
                yield f"{self.place(actor)}: robots.{actor}: {taken[home]} lives in that robot already"
            taken[home] = actor


def read_lab(path: Path) -> Lab:
    """Read a lab file.

    Raises:
        InvalidUse: It cannot be read, or something in it is wrong; the message has the file and the line.
    """
    try:
        text = read_text(path)
        content = read_yaml(text, str(path))
        lines = Lines(text, str(path))
        lab = Lab(LabFile.model_validate(content), lines, path.parent)
    except FileError as error:
        raise InvalidUse(str(error)) from error
    except ValidationError as error:
        raise InvalidUse(problems(error, lines, LabFile)) from error
    lab.check()
    return lab
