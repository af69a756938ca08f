"""The pictures of a run's input: files of pictures, a video, or the videos of one drive, one after the other."""

import glob
import os
import re
from pathlib import Path

import cv2

from evaluate.files import InputError

MOVE = "give the input that was segmented with --input"


def natural(path):
    """A sort key by which runs of digits compare as numbers."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", str(path))]


def folders_of(path, name):
    """What a picture's name may be relative to: the folder, that of a list's files, or the one that all files of a glob share."""
    if path.is_dir():
        return [path]
    if path.suffix in (".txt", ".csv") and path.is_file():
        words = re.split(r"[\s,]+", path.read_text(encoding="utf-8", errors="replace"))
        return [path.parent / word.removesuffix(name) for word in words if word.endswith(name)] + [path.parent / "data"]
    found = [path] if path.exists() else [Path(file) for file in glob.glob(str(path))]
    if not found:
        raise InputError(f"there is no {path}; {MOVE}")
    return [Path(os.path.commonpath([file.parent for file in found]))]


def videos_of(path):
    """The video, or those of a folder or a glob in natural order."""
    if path.is_file():
        return [path]
    return sorted((Path(name) for name in glob.glob(str(path / "*" if path.is_dir() else path)) if Path(name).is_file()), key=natural)


def decoded(videos):
    """A reader for each picture, which stands at that picture."""
    for video in videos:
        capture = cv2.VideoCapture(str(video))
        while capture.grab():
            yield capture


def pictures(source, lines):
    """(line, its picture, blue green red) for each of a run's lines with a map, in order.

    InputError where the input lacks one, or it has another size than the run says.
    """
    folder = next((folder for folder in folders_of(source, lines[0].image) if (folder / lines[0].image).is_file()), None)
    if folder:
        read = ((line, cv2.imread(str(folder / line.image))) for line in lines)
    else:
        read = from_videos(decoded(videos_of(source)), lines)
    for line, picture in read:
        if picture is None or picture.shape[:2] != line.size:
            raise InputError(f"frame {line.index} of {source} is not what was segmented; {MOVE}")
        yield line, picture


def from_videos(captures, lines):
    """The lines' pictures by their indices; None where the videos end before."""
    index = -1
    for line in lines:
        while index < line.index:
            capture, index = next(captures, None), index + 1
        yield line, capture.retrieve()[1] if capture else None
