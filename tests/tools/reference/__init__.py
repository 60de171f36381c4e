"""Reference pages, generated from the code.

A page of `docs/reference` contains `<!-- generated: NAME -->` where `GENERATORS[NAME]` inserts Markdown when the
site is built. Nothing generated is committed, so help texts and schemas have one source.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final

from tests.tools.reference.codes import codes
from tests.tools.reference.commands import commands
from tests.tools.reference.cookbook import cookbook
from tests.tools.reference.libraries import libraries
from tests.tools.reference.robots import referenced_robots
from tests.tools.reference.ros_errors import moveit_error_codes, nav2_error_codes
from tests.tools.reference.rules import bridge_rules, simulator_rules
from tests.tools.reference.schemas import (
    campaign_file,
    lab_file,
    profile_file,
    project_settings,
    robot_file,
    world_file,
)
from tests.tools.reference.verbs import executor_verbs, node_verbs, result_codes

GENERATORS: Final[Mapping[str, Callable[[], str]]] = {
    "bridge rules": bridge_rules,
    "campaign file": campaign_file,
    "codes": codes,
    "commands": commands,
    "cookbook": cookbook,
    "executor verbs": executor_verbs,
    "lab file": lab_file,
    "libraries": libraries,
    "moveit error codes": moveit_error_codes,
    "navigation error codes": nav2_error_codes,
    "node verbs": node_verbs,
    "profile file": profile_file,
    "project settings": project_settings,
    "referenced robots": referenced_robots,
    "result codes": result_codes,
    "robot file": robot_file,
    "simulator rules": simulator_rules,
    "world file": world_file,
}
"""Functions that return Markdown, by the name in the placeholder."""

PLACEHOLDER: Final = re.compile(r"^<!-- generated: ([a-z ]+) -->$", re.MULTILINE)


def insert(page: str) -> str:
    """Replace the placeholders of a page.

    Raises:
        KeyError: A placeholder has an unknown name.
    """
    return PLACEHOLDER.sub(lambda found: GENERATORS[found[1]]().rstrip("\n"), page)
