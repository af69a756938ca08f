"""COLMAP on one drive, in the environment that bench_colmap.py makes. Prints a line of JSON.

worker.py match DRIVE MASKS DATABASE LENS    features, outside the masks, and matches; MASKS "-": none
worker.py map DRIVE DATABASE OUT SEED LENS   a reconstruction: where its images were taken, and its points

LENS is "given" (the drive's) or "estimated" (by COLMAP, from its default).
"""

import json
import sys
from pathlib import Path

import numpy as np
import pycolmap
from PIL import Image

THREADS = 2


def match(drive, masks, database, lens):
    """One camera, and neighbours by number; all else is COLMAP's default."""
    camera = json.loads((drive / "camera.json").read_text())
    reader = pycolmap.ImageReaderOptions()
    if lens == "given":
        reader.camera_model = "SIMPLE_PINHOLE"
        reader.camera_params = f"{camera['focal_pixels']},{camera['width'] / 2},{camera['height'] / 2}"
    if masks != "-":
        reader.mask_path = masks
    extraction = pycolmap.FeatureExtractionOptions()
    extraction.num_threads = THREADS
    matching = pycolmap.FeatureMatchingOptions()
    matching.num_threads = THREADS
    pycolmap.set_random_seed(0)
    pycolmap.extract_features(database, drive / "frames", camera_mode=pycolmap.CameraMode.SINGLE, reader_options=reader, extraction_options=extraction, device=pycolmap.Device.cpu)  # fmt: skip
    pycolmap.match_sequential(database, matching_options=matching, device=pycolmap.Device.cpu)


def share_on_movers(reconstruction, drive):
    """Of the 3-D points, those that are seen on movers in most of their images."""
    masks = {}
    for image_id, image in reconstruction.images.items():
        masks[image_id] = np.array(Image.open(drive / "masks" / image.name).convert("L")) > 127
    moving = 0
    for point in reconstruction.points3D.values():
        hits = []
        for element in point.track.elements:
            x, y = reconstruction.images[element.image_id].points2D[element.point2D_idx].xy
            mask = masks[element.image_id]
            hits.append(mask[min(int(y), mask.shape[0] - 1), min(int(x), mask.shape[1] - 1)])
        moving += np.mean(hits) > 0.5
    return moving / max(len(reconstruction.points3D), 1)


def reconstruct(drive, database, out, seed, lens):
    """The largest of the models; of none, no image is registered."""
    out.mkdir(parents=True, exist_ok=True)
    options = pycolmap.IncrementalPipelineOptions()
    options.num_threads = THREADS
    options.random_seed = options.mapper.random_seed = options.triangulation.random_seed = seed
    options.extract_colors = False
    options.ba_refine_focal_length = options.ba_refine_extra_params = lens == "estimated"
    pycolmap.set_random_seed(seed)
    models = pycolmap.incremental_mapping(database, drive / "frames", out, options)
    largest = max(models.values(), key=lambda model: model.num_reg_images(), default=None)
    if not largest:
        return {"places": {}}
    images = [image for image in largest.images.values() if image.has_pose]
    return {
        "places": {Path(image.name).stem: image.projection_center().tolist() for image in images},
        "points": len(largest.points3D),
        "points_on_movers": share_on_movers(largest, drive),
    }


def main():
    """One task, named by the first argument."""
    task, *rest = sys.argv[1:]
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR
    result = {}
    if task == "match":
        match(Path(rest[0]), *rest[1:])
    else:
        result = reconstruct(Path(rest[0]), rest[1], Path(rest[2]), int(rest[3]), rest[4])
    print(json.dumps(result))


if __name__ == "__main__":
    main()
