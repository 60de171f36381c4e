from tests.bridges.ros2.expose.conftest import simulator

__all__ = ["simulator"]
