#!/usr/bin/env python3
"""The pictures of a ROS recording, with their times, as `egosieve segment` reads them.

    ./run bag FILE... --out=DIR [--topic=NAME]

FILE is a bag of ROS 1 (.bag; several are read as one), a recording of ROS 2 (its folder, or a .db3) or an MCAP file with
messages of ROS. Writes DIR/pictures/NNNNNN.png, or .jpg as it was recorded, and last DIR/pictures.csv, a line
"SECONDS,pictures/NAME" each, in order of the times in the messages' headers, which must differ. Images of encoding 8UC1 and
16UC1 are read as grey, 8UC3 and 16UC3 as blue, green, red. Exit codes as egosieve's: 0 done, 1 it cannot be
written, 2 usage, 3 the recording cannot be read.

Reading is rosbags' and rosbags-image's, which `./run bag` installs into an environment of their own.
"""

import argparse
import dataclasses
import re
import shutil
import sys
from pathlib import Path

import cv2
from rosbags.highlevel import AnyReader
from rosbags.image import message_to_cvimage
from rosbags.typesys import Stores, get_typestore

# Of images whose encoding tells the type of their values alone, by the number of channels.
CHANNELS = {"1": "mono", "3": "bgr", "4": "bgra"}
IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")


def fail(code, text):
    """One line, and the end."""
    print(f"bag: {text}", file=sys.stderr)
    sys.exit(code)


def encoded(message):
    """A file's extension and bytes: JPEG and PNG as they were recorded, all else as PNG."""
    if hasattr(message, "format"):
        data = bytes(message.data)
        for extension, begin in ((".jpg", b"\xff\xd8"), (".png", b"\x89PNG")):
            if data.startswith(begin):
                return extension, data
    encoding = getattr(message, "encoding", "")
    if plain := re.fullmatch(r"(8|16)UC([134])", encoding):
        encoding = CHANNELS[plain[2]] + plain[1]
        message = dataclasses.replace(message, encoding=encoding)
    picture = message_to_cvimage(message, "bgr16" if encoding.endswith("16") else "bgr8")
    return ".png", cv2.imencode(".png", picture)[1].tobytes()


def choose(reader, topic):
    """The connections of the topic that was named, or of the only one with pictures."""
    pictures = [connection for connection in reader.connections if connection.msgtype in IMAGE_TYPES]
    topics = sorted({connection.topic for connection in pictures})
    if not topics:
        there = {f"{connection.topic} of {connection.msgtype}" for connection in reader.connections}
        fail(3, f"no topic has pictures ({', '.join(IMAGE_TYPES)}); there are {', '.join(sorted(there)) or 'none'}")
    if topic is None and len(topics) > 1:
        fail(2, f"several topics have pictures; name one with --topic: {', '.join(topics)}")
    if topic is not None and topic not in topics:
        fail(2, f"no pictures in --topic={topic}; there are {', '.join(topics)}")
    return [connection for connection in pictures if connection.topic == (topic or topics[0])]


def write(reader, connections, out):
    """The pictures, then their list; returns how many. The same picture recorded again is listed once."""
    (out / "pictures").mkdir(parents=True)
    names = {}  # by time
    for number, (connection, recorded, raw) in enumerate(reader.messages(connections=connections)):
        message = reader.deserialize(raw, connection.msgtype)
        extension, data = encoded(message)
        stamp = message.header.stamp
        time = stamp.sec * 1_000_000_000 + stamp.nanosec or recorded
        name = names.setdefault(time, f"pictures/{number:06d}{extension}")
        if not (out / name).exists():
            (out / name).write_bytes(data)
        elif (out / name).read_bytes() != data:
            raise ValueError(f"two pictures of {connection.topic} have equal times, {time / 1e9:.9f} s, so the headers tell no times")
    if not names:
        raise ValueError(f"{connections[0].topic} has no message")
    lines = [f"{time // 10**9}.{time % 10**9:09d},{name}\n" for time, name in sorted(names.items())]
    unfinished = out / "pictures.csv.new"
    unfinished.write_text("".join(lines))
    unfinished.rename(out / "pictures.csv")
    return len(names)


def main():
    """Flags, recording, pictures."""
    parser = argparse.ArgumentParser(prog="./run bag", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="the recording")
    parser.add_argument("--out", type=Path, required=True, help="a new folder for the pictures and their list")
    parser.add_argument("--topic", help="of the pictures; needed where several have some")
    options = parser.parse_args()
    if options.out.exists() and (not options.out.is_dir() or any(options.out.iterdir())):
        fail(2, f"--out={options.out} is there already and not empty; name another folder")
    for path in options.files:
        if not path.exists():
            fail(3, f"{path}: no such file or folder")
    is_made = False
    try:
        with AnyReader(options.files, default_typestore=get_typestore(Stores.LATEST)) as reader:
            connections = choose(reader, options.topic)
            is_made = True
            count = write(reader, connections, options.out)
    except OSError as error:
        fail(1, error)
    except Exception as error:  # of a damaged recording the library raises errors of many kinds
        if is_made:
            shutil.rmtree(options.out, ignore_errors=True)
        what = " ".join(str(error).split()) or type(error).__name__
        fail(3, f"{options.files[0]} cannot be read as a recording of ROS: {what}")
    print(f"{count} pictures: egosieve segment {options.out / 'pictures.csv'} --out=RUN")


if __name__ == "__main__":
    main()
