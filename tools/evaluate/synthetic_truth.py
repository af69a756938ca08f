"""Truth in a folder of `egosieve synthesize`: objects with their headings, by pixel and frame."""

from pathlib import Path

import numpy as np

from .errors import InputError
from .run_folder import read_image, read_json


def drive_folder(path):
    """The synthetic drive at `path`, which may be its masks/; None if it is none."""
    for folder in (Path(path), Path(path).parent if Path(path).name == "masks" else None):
        if folder and (folder / "scene.json").exists():
            return folder
    return None


def is_person(thing):
    return thing["class"] in ("pedestrian", "cyclist")


class SyntheticTruth:
    """objects: by frame, then by id: class, relation, moving, distance_metres, area_pixels."""

    def __init__(self, folder):
        self.folder = Path(folder)
        scene = read_json(self.folder / "scene.json")
        try:
            self.size = scene["height"], scene["width"]
            self.objects = {frame["index"]: {o["id"]: o for o in frame["objects"]}
                            for frame in scene["frames"]}
        except (KeyError, TypeError) as error:
            raise InputError(f"{folder}/scene.json is damaged: {error!r}") from None

    def ids(self, frame):
        """Numbers of all objects by pixel, 0: none."""
        path = self.folder / "ids" / f"{frame:06d}.png"
        image = read_image(path)
        if image.dtype != np.uint16 or image.shape != self.size:
            raise InputError(f"{path} is no 16-bit grey image of {self.size[1]} x {self.size[0]} "
                             "pixels; synthesise the drive again")
        return image.astype(np.int32)

    def moving_ids(self, frame):
        """The same without standing objects."""
        ids = self.ids(frame)
        moving = [number for number, o in self.objects[frame].items() if o["moving"]]
        return np.where(np.isin(ids, moving), ids, 0)
