"""COLMAP on one drive or clip, in the environment that bench_colmap.py makes. Prints a line of JSON.

worker.py match DRIVE MASKS DATABASE LENS [FEATURES]    features, outside the masks, and matches; MASKS "-": none; FEATURES: of a picture at most
worker.py map DRIVE DATABASE OUT SEED LENS   a reconstruction: where its images were taken, and its points
worker.py model DRIVE DATABASE OUT SEED MAPPER    the largest model as OUT/largest; MAPPER: incremental or global
worker.py score DRIVE MODEL                  a model's size, errors, and observations on movers
worker.py project DRIVE MODEL PICTURE        where all points lie in a picture, and which are on movers
worker.py undistort PICTURES MODEL OUT       the model's pictures that are there, as image_undistorter writes them

LENS is "given" (the drive's) or "estimated" (by COLMAP, from its default). OMP_NUM_THREADS limits the threads, else 2.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pycolmap
from PIL import Image

THREADS = int(os.environ.get("OMP_NUM_THREADS", 2))


def match(drive, masks, database, lens, features=None):
    """One camera, and neighbours by number; all else is COLMAP's default."""
    reader = pycolmap.ImageReaderOptions()
    if lens == "given":
        camera = json.loads((drive / "camera.json").read_text())
        reader.camera_model = "SIMPLE_PINHOLE"
        reader.camera_params = f"{camera['focal_pixels']},{camera['width'] / 2},{camera['height'] / 2}"
    if masks != "-":
        reader.mask_path = masks
    extraction = pycolmap.FeatureExtractionOptions()
    extraction.num_threads = THREADS
    if features:
        extraction.sift.max_num_features = int(features)
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


def model(drive, database, out, seed, mapper):
    """The largest of the models, with COLMAP's estimate of the lens; all else is COLMAP's default."""
    out.mkdir(parents=True, exist_ok=True)
    options = pycolmap.GlobalPipelineOptions() if mapper == "global" else pycolmap.IncrementalPipelineOptions()
    options.num_threads = THREADS
    options.random_seed = options.mapper.random_seed = seed
    if mapper == "incremental":
        options.triangulation.random_seed = seed
    pycolmap.set_random_seed(seed)
    mapping = pycolmap.global_mapping if mapper == "global" else pycolmap.incremental_mapping
    models = mapping(database, drive / "frames", out, options)
    largest = max(models.values(), key=lambda one: one.num_reg_images(), default=pycolmap.Reconstruction())
    (out / "largest").mkdir(exist_ok=True)
    largest.write(out / "largest")
    return {"registered": largest.num_reg_images()}


def greys(one, drive):
    """Of each observation that belongs to a point, in pictures with true masks: the point's number and the mask's grey there."""
    points, values = [], []
    for image in one.images.values():
        mask = drive / "masks" / image.name
        seen = [point for point in image.points2D if point.has_point3D()]
        if image.has_pose and seen and mask.exists():
            truth = np.array(Image.open(mask).convert("L"))
            x, y = np.array([point.xy for point in seen], int).T
            points += [point.point3D_id for point in seen]
            values += truth[np.minimum(y, truth.shape[0] - 1), np.minimum(x, truth.shape[1] - 1)].tolist()
    return np.array(points), np.array(values)


def score(drive, path):
    """Observations on grey of a mask count nowhere; of a model without images there are no scores."""
    one = pycolmap.Reconstruction(path)
    if not one.num_reg_images():
        return {"registered": 0}
    values = greys(one, drive)[1]
    moving, still = int((values > 191).sum()), int((values < 64).sum())
    return {
        "registered": one.num_reg_images(),
        "points": one.num_points3D(),
        "observations_on_movers": moving / max(moving + still, 1),
        "reprojection_error_pixels": one.compute_mean_reprojection_error(),
        "track_length": one.compute_mean_track_length(),
    }


def project(drive, path, name):
    """[x, y, on a mover] of every point in a picture: on a mover are those with at least half of the observations there."""
    one = pycolmap.Reconstruction(path)
    points, values = greys(one, drive)
    picture = next(image for image in one.images.values() if image.name == name)
    found = []
    for number, point in one.points3D.items():
        place, seen = picture.project_point(point.xyz), values[points == number]
        if place is not None:
            found.append([*map(float, place), bool(len(seen) and (seen > 191).mean() >= 0.5)])
    return {"points": found}


def main():
    """One task, named by the first argument."""
    task, *rest = sys.argv[1:]
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR
    result = {}
    if task == "match":
        match(Path(rest[0]), *rest[1:])
    elif task == "model":
        result = model(Path(rest[0]), rest[1], Path(rest[2]), int(rest[3]), rest[4])
    elif task == "score":
        result = score(Path(rest[0]), rest[1])
    elif task == "project":
        result = project(Path(rest[0]), rest[1], rest[2])
    elif task == "undistort":
        names = [image.name for image in pycolmap.Reconstruction(rest[1]).images.values() if image.has_pose and (Path(rest[0]) / image.name).exists()]
        pycolmap.undistort_images(rest[2], rest[1], rest[0], image_names=names, num_threads=THREADS)
    else:
        result = reconstruct(Path(rest[0]), rest[1], Path(rest[2]), int(rest[3]), rest[4])
    print(json.dumps(result))


if __name__ == "__main__":
    main()
