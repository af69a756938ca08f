#!/usr/bin/python3
"""The latency of the example of ROS 2, tools/examples/ros2: from a picture's publication to its mask and objects.

    ./run bench_live [--video FILE] [--seconds S] [--profile NAME] [--focal PIXELS]

Builds the node against the installed library and the stub of rclcpp in tests/tools/embed/ros2, and plays the video to it at 30 pictures per second,
grey, scaled to 640 pixels in width. The newest picture comes first, so pictures that it has no time for are dropped. Writes live.json and live.md in
bench/results. Of the first WARM_UP seconds, in which programs are compiled and the model is empty, nothing counts.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import RESULTS, ROOT, call, machine, markdown  # noqa: E402

DATA = Path(os.environ.get("EGOSIEVE_DATA", ROOT.parent / "shared" / "data"))
ARCHIVE = ROOT / "bazel-bin" / "tools" / "embed" / "install" / "egosieve.tar"
STUB = ROOT / "tests" / "tools" / "embed" / "ros2" / "stub" / "cmake"
WIDTH, RATE, WARM_UP = 640, 30, 5


def build_node(folder):
    """The node's program."""
    tree, build = folder / "tree", folder / "build"
    tree.mkdir()
    call("tar", "--extract", f"--file={ARCHIVE}", f"--directory={tree}")
    packages = [f"-D{name}_DIR={STUB}" for name in ("ament_cmake", "rclcpp", "sensor_msgs", "vision_msgs")]
    call("cmake", "-S", tree / "share" / "egosieve" / "examples" / "ros2", "-B", build, f"-DCMAKE_PREFIX_PATH={tree}", *packages)
    call("cmake", "--build", build)
    return build / "segmenter_node"


def write_pictures(video, seconds, file):
    """The video's pictures as the player reads them; how many, and their height."""
    capture, count = cv2.VideoCapture(str(video)), 0
    with open(file, "wb") as out:
        while count < RATE * seconds and (picture := capture.read()[1]) is not None:
            height = round(picture.shape[0] * WIDTH / picture.shape[1])
            grey = cv2.cvtColor(cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2GRAY)
            out.write(grey.tobytes())
            count += 1
    if count == 0:
        sys.exit(f"bench_live: no pictures in {video}; set EGOSIEVE_DATA or give --video")
    return count, height


def play(node, file, height, options):
    """{number of a picture: milliseconds until its objects}"""
    environment = os.environ | {"PLAY": str(file), "WIDTH": str(WIDTH), "HEIGHT": str(height), "RATE": str(RATE), "FOCAL": str(options.focal)}
    words = [node, "--ros-args", "-p", f"profile:={options.profile}", "-p", "camera_info_seconds:=0.1"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    lines = [line.split() for line in done.stdout.splitlines() if line.startswith("objects")]
    return {int(line[1]): float(line[2]) for line in lines}


def main():
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--video", type=Path, default=DATA / "strangers" / "seattle_street1.mp4")
    parser.add_argument("--seconds", type=int, default=30)
    parser.add_argument("--profile", default="fast", help="fast or default")
    parser.add_argument("--focal", type=float, default=0, help="pixels of pictures of that width; 0: learnt")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        node = build_node(Path(folder))
        count, height = write_pictures(options.video, options.seconds, Path(folder) / "pictures")
        latencies = play(node, Path(folder) / "pictures", height, options)
    warm = [milliseconds for number, milliseconds in latencies.items() if number >= WARM_UP * RATE]
    median, late = np.quantile(warm, [0.5, 0.95])
    seconds = (count - WARM_UP * RATE) / RATE
    record = {"video": options.video.name, "profile": options.profile, "size": [WIDTH, height], "date": str(date.today()), "machine": machine(), "load": load,
              "median_ms": median, "below_95_ms": late, "masks_per_second": len(warm) / seconds, "pictures_per_second": RATE}  # fmt: skip
    table = markdown(["profile", ">median, ms", ">95 % below, ms", ">masks per second", ">pictures per second"],
                     [(options.profile, f"{median:.0f}", f"{late:.0f}", f"{len(warm) / seconds:.1f}", RATE)])  # fmt: skip
    page = (
        f"# Latency of a live camera\n\n`./run bench_live --seconds={options.seconds} --profile={options.profile}`, {record['date']}, {record['machine']}, "
        f"load {load:.1f} before. {record['video']},\n{WIDTH} x {height}, through the [example of ROS 2](../../tools/examples/ros2/segmenter_node.cc): from a picture's "
        f"publication to its mask and objects,\nafter {WARM_UP} seconds. A picture that waits is replaced by a newer one.\n\n{table}"
    )
    (RESULTS / "live.json").write_text(json.dumps(record, indent=1) + "\n")
    (RESULTS / "live.md").write_text(page)
    print(page, end="")


if __name__ == "__main__":
    main()
