"""Actions of `osc.nav2`.

Actions that simulated robots support use the backend of the actor; others use the ROS 2 system of the run.
"""

# ruff: noqa: F401 - the library consists of what this module contains

from seoro.actions.nav2_docking import dock, dock_at_pose, undock
from seoro.actions.nav2_goals import follow_waypoints, init_nav2, nav_through_poses, nav_to_pose
from seoro.actions.nav2_gps import follow_gps_waypoints
from seoro.actions.nav2_localization import request_nomotion_update
from seoro.actions.nav2_motions import assisted_teleop, backup, drive_on_heading, spin, wait_in_place
from seoro.actions.nav2_planning import (
    check_path,
    compute_path_through_poses,
    compute_path_to_pose,
    compute_route,
    follow_computed_path,
    smooth_path,
    track_route,
)
from seoro.actions.nav2_services import (
    check_lifecycle,
    clear_costmap,
    clear_costmap_around_robot,
    clear_costmap_except_region,
    limit_speed,
    limit_speed_share,
    load_map,
    manage_lifecycle,
    save_map,
)
