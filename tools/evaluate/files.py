"""Files and tables, and the errors that end the program with one line and an exit code
(tools/cli/exit_code.h)."""

import json
import os
from pathlib import Path

import cv2
import numpy as np


class UsageError(Exception):
    """A flag, a value or a folder does not fit."""

    code = 2


class InputError(Exception):
    """A file is missing or damaged."""

    code = 3


def read_json(path):
    try:
        return json.loads(Path(path).read_text(encoding="utf-8", errors="replace"))
    except FileNotFoundError:
        raise InputError(f"there is no {path}") from None
    except ValueError:
        raise InputError(f"{path} is no JSON; remove or replace it") from None


def read_image(path, flags=cv2.IMREAD_UNCHANGED):
    if not Path(path).is_file():
        raise InputError(f"{path} is not there, or is no file")
    image = cv2.imread(str(path), flags)
    if image is None:
        raise InputError(f"{path} is no image that can be read; remove or replace it")
    return image


def read_numbers(path, size):
    """A map of scores or of numbers of objects; size: (height, width)."""
    image = read_image(path)
    if image.dtype != np.uint16 or image.shape != size:
        raise InputError(f"{path} is no 16-bit grey image of {size[1]} x {size[0]} pixels; remove "
                         "it and make it again")
    return image.astype(np.int32)


def write_file(path, text):
    """The whole file, or none."""
    scratch = Path(f"{path}.{os.getpid()}.tmp")
    scratch.write_text(text, encoding="utf-8", errors="replace")
    scratch.replace(path)


def to_json(value):
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"


def to_text(table, decimals=4):
    """A table for people, its first column to the left; "-": no value."""
    first = table.columns[0]
    table = table.astype(object).where(table.notna(), "-").set_index(first)
    table = table.rename_axis(index=None, columns=first)
    return table.to_string(float_format=f"{{:.{decimals}f}}".format) + "\n"
