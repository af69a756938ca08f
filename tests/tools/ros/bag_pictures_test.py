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
PLAIN = {"8UC1": 9, "8UC3": COLOUR, "16UC1": 9000, "16UC3": (100, 2000, 30000)}


def plain_messages(store, extra, step):
    """Two pictures, `step` apart, in each encoding that tells the type of the values alone."""
    for number in (0, 1):
        time = BEGIN + number * step
        header = store.types["std_msgs/msg/Header"](stamp=store.types["builtin_interfaces/msg/Time"](time // 10**9, time % 10**9), frame_id="", **extra)
        for encoding, value in PLAIN.items():
            channels, depth = int(encoding[-1]), np.uint16 if encoding.startswith("16") else np.uint8
            picture = np.full((4, 6, channels), value, depth)
            picture[0, 0] = number
            data = picture.reshape(-1).view(np.uint8)
            yield "/" + encoding, store.types["sensor_msgs/msg/Image"](header, 4, 6, encoding, 0, len(data) // 4, data)


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


def fill(writer, store, serialize, recorded, topics):
    """Writes the topics' messages, each recorded a nanosecond after the one before."""
    connections = {}
    for number, (topic, message) in enumerate(recorded):
        if topics and topic not in topics:
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
            fill(writer, store, store.serialize_ros1, messages(store, {"seq": 0}), topics)
        return self.root / "a.bag"

    def plain(self, step):
        """A bag of ROS 1 with a topic for each of PLAIN."""
        store = get_typestore(Stores.ROS1_NOETIC)
        with Writer1(self.root / f"plain_{step}.bag") as writer:
            fill(writer, store, store.serialize_ros1, plain_messages(store, {"seq": 0}, step), ())
        return self.root / f"plain_{step}.bag"

    def ros2(self, plugin):
        """A recording of ROS 2."""
        store = get_typestore(Stores.ROS2_HUMBLE)
        with Writer2(self.root / plugin.name, version=9, storage_plugin=plugin) as writer:
            fill(writer, store, store.serialize_cdr, messages(store, {}), TOPICS)
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

    def test_reads_encodings_that_tell_the_type_of_the_values_alone(self):
        path = self.plain(STEP)
        for encoding, value in PLAIN.items():
            with self.subTest(encoding=encoding):
                code, said, out = self.run_script(path, f"--topic=/{encoding}")
                self.assertEqual(code, 0, said)
                picture = cv2.imread(str(out / "pictures" / "000001.png"), cv2.IMREAD_UNCHANGED)
                self.assertEqual(picture.dtype, np.uint16 if encoding.startswith("16") else np.uint8)
                np.testing.assert_array_equal(picture[1:], np.full((3, 6, 3), value, picture.dtype))

    def test_refuses_equal_times(self):
        code, said, out = self.run_script(self.plain(0), "--topic=/8UC1")
        self.assertEqual(code, 3)
        self.assertIn("two pictures of /8UC1 have equal times, 1700000000.0", said)
        self.assertFalse(out.exists())

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
