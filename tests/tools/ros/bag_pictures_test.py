"""Pictures of recordings that rosbags wrote: ROS 1, ROS 2, MCAP."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

BEGIN = 1_700_000_000_000_000_000  # nanoseconds
STEP = 50_000_000
COLOUR = (10, 20, 200)  # blue, green, red
TOPICS = ("/cam/raw", "/cam/jpeg", "/cam/grey")


def messages(store, extra):
    """Three pictures for each topic; the second one is recorded before the first."""
    types = store.types
    grey = np.full((4, 6), 7, np.uint16) * 257
    colour = np.full((4, 6, 3), COLOUR, np.uint8)
    jpeg = cv2.imencode(".jpg", colour)[1].reshape(-1)
    for number in (1, 0, 2):
        time = BEGIN + number * STEP
        stamp = types["builtin_interfaces/msg/Time"](time // 10**9, time % 10**9)
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **extra)
        image = types["sensor_msgs/msg/Image"]
        yield TOPICS[0], image(header, 4, 6, "rgb8", 0, 18, np.ascontiguousarray(colour[:, :, ::-1]).reshape(-1))
        yield TOPICS[1], types["sensor_msgs/msg/CompressedImage"](header, "jpeg", jpeg)
        yield TOPICS[2], image(header, 4, 6, "mono16", 0, 12, grey.view(np.uint8).reshape(-1))


def fill(writer, store, serialize, extra, topics):
    """Writes the topics' messages, each recorded a nanosecond after the one before."""
    connections = {}
    for number, (topic, message) in enumerate(messages(store, extra)):
        if topic not in topics:
            continue
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
        writer.write(connections[topic], BEGIN + number, serialize(message, message.__msgtype__))


class BagPictures(unittest.TestCase):
    """The script as a user starts it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def run_script(self, path, *flags):
        """Its exit code, stderr and output folder."""
        out = self.root / f"out_{len(list(self.root.glob('out_*')))}"
        done = subprocess.run([sys.executable, SCRIPT, path, f"--out={out}", *flags], capture_output=True, text=True, check=False)
        return done.returncode, done.stderr, out

    def ros1(self, topics=TOPICS):
        """A bag of ROS 1."""
        store = get_typestore(Stores.ROS1_NOETIC)
        with Writer1(self.root / "a.bag") as writer:
            fill(writer, store, store.serialize_ros1, {"seq": 0}, topics)
        return self.root / "a.bag"

    def ros2(self, plugin):
        """A recording of ROS 2."""
        store = get_typestore(Stores.ROS2_HUMBLE)
        with Writer2(self.root / plugin.name, version=9, storage_plugin=plugin) as writer:
            fill(writer, store, store.serialize_cdr, {}, TOPICS)
        return self.root / plugin.name

    def test_every_recording_gives_the_same_pictures_and_times(self):
        mcap, sqlite = self.ros2(StoragePlugin.MCAP), self.ros2(StoragePlugin.SQLITE3)
        for path in (self.ros1(), mcap, mcap / "MCAP.mcap", sqlite, sqlite / "SQLITE3.db3"):
            with self.subTest(path=path.name):
                code, said, out = self.run_script(path, "--topic=/cam/raw")
                self.assertEqual(code, 0, said)
                lines = (out / "pictures.csv").read_text().splitlines()
                self.assertEqual([line.split(",")[0] for line in lines], ["1700000000.000000000", "1700000000.050000000", "1700000000.100000000"])
                for line in lines:
                    picture = cv2.imread(str(out / line.split(",")[1]), cv2.IMREAD_UNCHANGED)
                    np.testing.assert_array_equal(picture, np.full((4, 6, 3), COLOUR, np.uint8))

    def test_keeps_what_is_compressed_and_what_is_deep(self):
        path = self.ros1()
        _, _, out = self.run_script(path, "--topic=/cam/jpeg")
        self.assertEqual((out / "pictures" / "000000.jpg").read_bytes()[:2], b"\xff\xd8")
        _, _, out = self.run_script(path, "--topic=/cam/grey")
        picture = cv2.imread(str(out / "pictures" / "000000.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(picture, np.full((4, 6, 3), 7 * 257, np.uint16))

    def test_takes_the_only_topic(self):
        self.assertEqual(self.run_script(self.ros1(TOPICS[:1]))[0], 0)

    def test_says_what_is_wrong_and_writes_nothing(self):
        path = self.ros1()
        damaged, text = self.root / "damaged.bag", self.root / "text.mcap"
        damaged.write_bytes(path.read_bytes()[:5000])
        text.write_text("no recording")
        for flags, code, what in (
            ((path,), 2, "several topics have pictures; name one with --topic: /cam/grey, /cam/jpeg, /cam/raw"),
            ((path, "--topic=/lidar"), 2, "no pictures in --topic=/lidar"),
            ((damaged,), 3, "cannot be read as a recording"),
            ((text,), 3, "cannot be read as a recording"),
            ((self.root / "none.bag",), 3, "no such file"),
        ):
            with self.subTest(what=what):
                got, said, out = self.run_script(*flags)
                self.assertEqual(got, code, said)
                self.assertIn(what, said)
                self.assertEqual(said.count("\n"), 1, said)
                self.assertFalse(out.exists())


if __name__ == "__main__":
    SCRIPT = sys.argv.pop(1)
    unittest.main()
