"""A folder of masks as truth: which mask belongs to which frame, and the meaning of its pixels.

    pixel   0 static, 128 void (unknown), else dynamic; a pixel of a colour mask is dynamic if any
            channel is not 0 (void: all channels 128)
    frame   by name, if the input was a folder and every mask has the name, without extension, of a
            frame in it; else by number, if every mask's name has one (its last run of digits) and
            all differ; else by order, if there are as many masks as frames, as far as these are
            known: the k-th file in natural order is the mask of the k-th frame
"""

import re
from pathlib import Path

import cv2
import numpy as np

from .errors import InputError, UsageError
from .run_folder import read_image

STATIC, VOID, DYNAMIC = 0, 128, 255
EXTENSIONS = {".png", ".jpg", ".jpeg", ".jpe", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".pnm",
              ".pbm", ".webp", ".jp2"}
MATCHES = ("auto", "name", "number", "order")


def natural_key(name):
    """Bytes in their order, but runs of digits by their numbers."""
    key = []
    for part in re.findall(rb"\d+|\D", str(name).encode(errors="surrogateescape"), re.DOTALL):
        digits = part.lstrip(b"0")
        key.append((ord("0"), len(digits), digits) if part.isdigit() else (part[0], 0, b""))
    return key, str(name)


def list_images(folder):
    """In natural order; empty if there are none, or no folder."""
    folder = Path(folder)
    if not folder.is_dir():
        return []
    files = [path for path in folder.iterdir() if path.is_file() and path.name[0] != "."
             and path.suffix.lower() in EXTENSIONS]
    return sorted(files, key=natural_key)


def frame_names(path):
    """Names, without extension, of the images in a folder, in the frames' order."""
    return [image.stem for image in list_images(path)]


def number_in(stem):
    """The last run of digits: 121 in "frame_0121"; None without one."""
    digits = re.findall(r"\d+", stem)
    return int(digits[-1]) if digits else None


def _by(keys, files):
    """Files by their keys; empty if a key is missing or two files have the same."""
    keys = list(keys)
    return {} if None in keys or len(set(keys)) < len(keys) else dict(zip(keys, files))


def list_masks(folder, names, match="auto"):
    """(matched by name, number or order; paths by frame). names: the frames' names by index."""
    files = list_images(folder)
    if not files:
        what = "image in" if Path(folder).is_dir() else "folder"
        raise InputError(f"no {what} {folder}; give the folder of masks to --truth")
    index = {name: i for i, name in enumerate(names)}
    ways = {"name": lambda: _by((index.get(file.stem) for file in files), files),
            "number": lambda: _by((number_in(file.stem) for file in files), files),
            "order": lambda: dict(enumerate(files))}
    for way in ways if match == "auto" else (match,):
        if way == "order" and match == "auto" and names and len(names) != len(files):
            raise UsageError(f"the {len(files)} masks in {folder} have neither the names nor the "
                             f"numbers of the {len(names)} frames; rename them")
        if paths := ways[way]():
            return way, paths
    raise UsageError(f"the masks in {folder} do not match the frames by {match}; rename them, or "
                     "use another --match")


def read_mask(path):
    """STATIC, VOID or DYNAMIC per pixel."""
    image = read_image(path, cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH)
    if image.dtype != np.uint8:
        raise InputError(f"the mask {path} has no 8-bit pixels; remove or replace it")
    image = image.reshape(*image.shape[:2], -1)
    truth = np.full(image.shape[:2], DYNAMIC, np.uint8)
    truth[(image == STATIC).all(axis=2)] = STATIC
    truth[(image == VOID).all(axis=2)] = VOID
    return truth
