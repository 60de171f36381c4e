"""Recording and playback of rosbag2 bags: folders with MCAP files.

`record` and `play` need a node of a ROS 2 system; `write_bag` and `open_bag` access bags alone.
"""

from seoro.bridges.ros2.recording.errors import RecordingFailed, RefusedRecording, UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, Extent
from seoro.bridges.ros2.recording.player import Playback, play
from seoro.bridges.ros2.recording.reader import Bag, open_bag, repair_bag
from seoro.bridges.ros2.recording.recorder import Recording, record
from seoro.bridges.ros2.recording.writer import BagWriter, bag_folder, write_bag

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
    "open_bag",
    "play",
    "record",
    "repair_bag",
    "write_bag",
]
