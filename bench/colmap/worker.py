"""COLMAP on one drive, in the environment that bench_colmap.py makes. Prints a line of JSON.

worker.py true_masks DRIVE OUT PIXELS    the drive's masks as COLMAP reads them, movers dilated
worker.py match DRIVE MASKS DATABASE LENS    features, outside the masks, and matches; MASKS "-": none
worker.py map DRIVE DATABASE OUT SEED LENS   a reconstruction, scored against the drive's truth

LENS is "given" (the drive's) or "estimated" (by COLMAP, from its default).
"""

import json
import sys
from pathlib import Path

import numpy as np
import pycolmap
from PIL import Image, ImageFilter

THREADS = 2


def write_true_masks(drive, out, pixels):
    """0 where something moves or is nearer than `pixels` to it, 255 elsewhere."""
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted((drive / "masks").glob("*.png")):
        dilated = Image.open(path).convert("L").filter(ImageFilter.MaxFilter(2 * pixels + 1))
        dilated.point(lambda value: 0 if value > 127 else 255).save(out / (path.name + ".png"))


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


def true_centres(drive):
    """The camera's place in each frame, metres: the last column of poses.txt's 3 x 4 matrices."""
    return np.loadtxt(drive / "poses.txt").reshape(-1, 3, 4)[:, :, 3]


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


def score(reconstruction, drive):
    """Absolute trajectory error: the root of the mean squared distance after the best similarity."""
    truth = true_centres(drive)
    images = [image for image in reconstruction.images.values() if image.has_pose]
    centres = np.array([image.projection_center() for image in images])
    wanted = truth[[int(Path(image.name).stem) for image in images]]
    aligned = pycolmap.estimate_sim3d(centres, wanted) if len(images) >= 3 else None
    error = None  # three places on a line, or fewer, have no similarity
    if aligned is not None:
        placed = np.array([aligned * centre for centre in centres])
        error = float(np.sqrt(np.mean(np.sum((placed - wanted) ** 2, axis=1))))
    return {
        "registered": len(images),
        "trajectory_error_metres": error,
        "points": len(reconstruction.points3D),
        "points_on_movers": share_on_movers(reconstruction, drive),
    }


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
    return score(largest, drive) if largest else {"registered": 0}


def main():
    """One task, named by the first argument."""
    task, *rest = sys.argv[1:]
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR
    result = {}
    if task == "true_masks":
        write_true_masks(Path(rest[0]), Path(rest[1]), int(rest[2]))
    elif task == "match":
        match(Path(rest[0]), *rest[1:])
    else:
        result = reconstruct(Path(rest[0]), rest[1], Path(rest[2]), int(rest[3]), rest[4])
    print(json.dumps(result))


if __name__ == "__main__":
    main()
