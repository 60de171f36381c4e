"""Options of scenarios of this folder that need more than a simulator."""

from collections.abc import Iterator

import pytest

import seoro
from seoro.embed.options import OptionFields
from tests.routers import routing

ON_ROS = "wait_for_a_topic"


@pytest.fixture
def osc_options(osc_options: OptionFields, request: pytest.FixtureRequest) -> Iterator[OptionFields]:
    """Start a router for the scenario with topics of ROS 2."""
    if request.node.path.stem != ON_ROS:
        yield osc_options
        return
    with routing() as endpoint:
        yield {**osc_options, "clock": "real", "ros": seoro.Ros(endpoint, dialect="rmw_zenoh")}
