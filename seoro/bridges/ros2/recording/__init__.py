"""Recording and playing bags, as rosbag2 has them: folders with MCAP files.

`record` and `play` are for nodes of a ROS 2 system, `write_bag` and `open_bag` for bags alone.
"""

from seoro.bridges.ros2.recording.errors import RecordingFailed, RefusedRecording, UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.mending import mend_bag
from seoro.bridges.ros2.recording.metadata import BagTopic, Extent
from seoro.bridges.ros2.recording.naming import bag_folder, check_storage
from seoro.bridges.ros2.recording.player import Playback, play
from seoro.bridges.ros2.recording.reader import Bag, open_bag
from seoro.bridges.ros2.recording.recorder import Recording, record
from seoro.bridges.ros2.recording.sources import BagMessage
from seoro.bridges.ros2.recording.writer import BagWriter, write_bag

__all__ = [
    "Bag",
    "BagMessage",
    "BagTopic",
    "BagWriter",
    "Extent",
    "Playback",
    "Recording",
    "RecordingFailed",
    "RefusedRecording",
    "UnknownTopic",
    "UnreadableBag",
    "bag_folder",
    "check_storage",
    "mend_bag",
    "open_bag",
    "play",
    "record",
    "write_bag",
]
