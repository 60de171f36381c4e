"""A bridge to robots on rails."""

from tests.bridges.robot.conftest import rails, start_rails

__all__ = ["rails", "start_rails"]
