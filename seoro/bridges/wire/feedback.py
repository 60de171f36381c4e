"""How far robots are on their way, by the names of the feedback of Nav2's actions."""

from __future__ import annotations

from seoro.bridges.wire.message import Message, Verb


class FeedbackRequest(Message):
    """Ask how far a robot is on its way to its goal; without a goal that is refused as INCORRECT_STATE."""

    robot: str


class NavigationFeedback(Message):
    """How far a robot is on its way to its goal.

    Attributes:
        robot: The robot.
        time: Of the simulator's clock [s].
        navigation_time: Since the goal was taken up [s].
        distance_remaining: Along the plan to the pose that it drives to, then straight from pose to pose [m].
        estimated_time_remaining: At the mean speed until now [s].
        number_of_recoveries: On the way to this goal.
        number_of_poses_remaining: Including the one that it drives to.
    """

    robot: str
    time: float
    navigation_time: float
    distance_remaining: float
    estimated_time_remaining: float
    number_of_recoveries: int
    number_of_poses_remaining: int


GET_NAVIGATION_FEEDBACK = Verb("get_navigation_feedback", FeedbackRequest, NavigationFeedback)
