"""A bridge to robots on rails."""

from tests.bridges.robot.conftest import all_rails, rails, start_rails

__all__ = ["all_rails", "rails", "start_rails"]
