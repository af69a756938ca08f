"""A small drive with every kind of truth and a run of it, made by code: what the tests score.

    root/frames, masks, ids, scene.json     a synthetic drive: a car and a pedestrian move, a van
                                            stands
    root/labels                             the same masks with void pixels
    root/tracks.csv, boxes.csv, poses.txt, camera.json, own_vehicle.png
    root/run                                its run: maps near the truth, masks, a trajectory
"""

import json
import os
import tempfile
import unittest
from pathlib import Path

import cv2
import numpy as np

WIDTH, HEIGHT, STRIDE, FRAMES = 97, 64, 5, 7
RATE = 4
OBJECTS = [  # id, class, relation, moving, distance, (x, y), step, half size
    (1, "car", "ahead", True, 12.5, (20, 30), (5, 0), (9, 6)),
    (2, "pedestrian", "crossing", True, 22.0, (70, 40), (-4, 1), (3, 7)),
    (3, "van", "standing", False, 45.0, (50, 12), (0, 0), (8, 5)),
]


class FolderCase(unittest.TestCase):
    """With an empty folder, `root`."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(dir=os.environ.get("TEST_TMPDIR"))
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)


def noise(frame, salt, shape):
    """From 0 to 1, the same everywhere."""
    place = np.arange(shape[0] * shape[1], dtype=np.uint64).reshape(shape)
    mixed = (place + np.uint64(1000003 * frame + 7919 * salt)) * np.uint64(2654435761)
    return ((mixed ^ (mixed >> np.uint64(13))) % np.uint64(65521)).astype(float) / 65521


def write_png(path, image):
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image)


def ids_of(frame):
    ids = np.zeros((HEIGHT, WIDTH), np.uint16)
    for number, _, _, _, _, (x, y), (dx, dy), (rx, ry) in reversed(OBJECTS):
        x, y = x + dx * frame, y + dy * frame
        rx += 2 * (frame % 3) * (number == 2)  # walks
        ids[max(0, y - ry):y + ry + 1, max(0, x - rx):x + rx + 1] = number
    return ids


def write_truth(root):
    frames = []
    for k in range(FRAMES):
        ids = ids_of(k)
        moving = np.isin(ids, [o[0] for o in OBJECTS if o[3]])
        mask = np.where(moving, 255, 0).astype(np.uint8)
        picture = 255 * noise(k, 0, (HEIGHT, WIDTH))
        write_png(root / f"frames/{k:06d}.png", picture.astype(np.uint8))
        write_png(root / f"masks/{k:06d}.png", mask)
        write_png(root / f"ids/{k:06d}.png", ids)
        mask[:9, 30:60] = 128
        if k == 5:
            mask[mask == 255] = 128  # a frame without movers
        write_png(root / f"labels/{k:06d}.png", mask)
        frames.append({"index": k, "objects": [
            {"id": o[0], "class": o[1], "relation": o[2], "moving": o[3],
             "distance_metres": o[4] + k, "area_pixels": int((ids == o[0]).sum())}
            for o in OBJECTS if (ids == o[0]).any()]})
    scene = {"width": WIDTH, "height": HEIGHT, "frames": frames}
    (root / "scene.json").write_text(json.dumps(scene))
    own = np.zeros((HEIGHT, WIDTH), np.uint8)
    own[55:] = 255
    write_png(root / "own_vehicle.png", own)


def write_further_truth(root):
    rows = ["frame,id,type,x1,y1,x2,y2,moving,truncated,occluded,depth,range"]
    points = ["track,label,frame,x,y"]
    for k in range(FRAMES):
        for number, name, _, moving, distance, (x, y), (dx, dy), (rx, ry) in OBJECTS:
            kind = {"car": "Car", "pedestrian": "Pedestrian", "van": "Van"}[name]
            x, y = x + dx * k, y + dy * k
            depth = "" if number == 3 else distance + k
            rows.append(f"{k},{number},{kind},{x - rx},{y - ry},{x + rx},{y + ry},{int(moving)},0,"
                        f"{2 * (k == 3)},{depth},{'far' * (number == 3)}")
            points.append(f"{number},{1 + number * moving},{k},{x + 0.25 * k},{y - 0.5}")
        rows.append(f"{k},9,Misc,80,2,92,9,,0,0,,")
        points.append(f"8,1,{k},{3.5 + k},{HEIGHT - 9.25}")
        points.append(f"9,1,{k},{WIDTH + 5},4")  # outside
    (root / "boxes.csv").write_text("\n".join(rows) + "\n")
    (root / "tracks.csv").write_text("\n".join(points) + "\n")
    poses = []
    for k in range(FRAMES):
        turn, ahead = 0.02 * k, 0.4 * k
        poses.append([np.cos(turn), 0, np.sin(turn), 0.05 * k * k, 0, 1, 0, 0,
                      -np.sin(turn), 0, np.cos(turn), ahead])
    text = "\n".join(" ".join(f"{v:.9f}" for v in row) for row in poses)
    (root / "poses.txt").write_text(text + "\n")
    camera = {"focal_pixels": 100.0, "width": WIDTH, "height": HEIGHT, "frames_per_second": RATE}
    (root / "camera.json").write_text(json.dumps(camera))


def line(k):
    """Frame 0 has the map of the prior; from frame 4 no pair was learnt from."""
    counts = ("candidates", "dropped_by_density", "dropped_by_novelty", "added",
              "dropped_by_consistency", "dropped_by_model_density", "dropped_by_age",
              "dropped_by_budget")
    return {"index": k, "image": f"{k:06d}.png", "time_seconds": k / RATE,
            "outcome": "learnt" if 0 < k < 4 else "answered", "reason": None, "doubt": None,
            "width_pixels": WIDTH, "height_pixels": HEIGHT, "features": 0, "matches": 0,
            "motion_model": "none", "inliers": 0, "noise_pixels": 0, "labelled_static": 0,
            "labelled_dynamic": 0, "frame_gap": 0, "decided_by": {},
            "step": None, "points": dict.fromkeys(counts, 0), "model_size": 10 * (k > 0),
            "theta": [0.0], "a": 1, "b": 0, "log_likelihood_per_point": 0,
            "factor_rebuilt": False, "jitter": 0, "dynamic_share": 0, "clamped_variances": 0,
            "saturated_deviations": 0, "milliseconds": {}}


def write_run(root):
    run = root / "run"
    x = np.minimum(np.arange(0, WIDTH - 1 + STRIDE, STRIDE), WIDTH - 1)
    y = np.minimum(np.arange(0, HEIGHT - 1 + STRIDE, STRIDE), HEIGHT - 1)
    for k in range(FRAMES):
        near = np.isin(np.roll(ids_of(k), 2, axis=1), (1, 2))  # two pixels beside the truth
        p = np.where(near, 0.55 + 0.4 * noise(k, 1, near.shape), 0.7 * noise(k, 2, near.shape)**2)
        p = p if k else np.full(near.shape, 0.2)
        full = np.round(65535 * p).astype(np.uint16)
        deviation = np.round(65535 * (0.1 + 0.3 * p * noise(k, 3, near.shape))).astype(np.uint16)
        write_png(run / f"grid/{k:06d}.prob.png", full[np.ix_(y, x)])
        write_png(run / f"grid/{k:06d}.std.png", deviation[np.ix_(y, x)])
        if k == 0:
            continue
        write_png(run / f"full/{k:06d}.prob.png", full)
        write_png(run / f"full/{k:06d}.std.png", deviation)
        ids = np.where(np.isin(np.roll(ids_of(k), 1, axis=0), (1, 2)), np.roll(ids_of(k), 1, 0), 0)
        ids[(ids == 2) & (k > 3)] = 4  # the number changes
        ids[50:54, 2:30 + 5 * (k % 2)] = 7  # a false object
        ids[14:24, 20 + 5 * k:26 + 6 * k] = 1
        write_png(run / f"ids/{k:06d}.png", ids.astype(np.uint16))
        write_png(run / f"masks/{k:06d}.png", np.where(ids > 0, 255, 0).astype(np.uint8))
    (run / "frames.jsonl").write_text("".join(json.dumps(line(k)) + "\n" for k in range(FRAMES)))
    description = {
        "format": "egosieve run", "format_version": 2, "version": "0", "device": "none", "seed": 1,
        "flags": {"from": "0", "stride": str(STRIDE)},
        "input": {"path": str(root / "frames"), "kind": "folder", "fingerprint": f"0-{FRAMES}",
                  "width_pixels": WIDTH, "height_pixels": HEIGHT},
        "maps": {"stride_pixels": STRIDE, "columns": len(x), "rows": len(y),
                 "probability": "", "deviation": "", "deviation_full_scale": 4.0},
        "ended": "done", "ended_message": "", "frames_answered": FRAMES, "frames_learnt": 3,
        "frames_failed": 0, "seconds": 1.0, "started_utc": "", "finished_utc": ""}
    (run / "run.json").write_text(json.dumps(description))
    estimate = {"focal_pixels": 97.0, "width": WIDTH, "height": HEIGHT}
    (run / "camera.json").write_text(json.dumps(estimate))
    poses = ["# seconds tx ty tz qx qy qz qw"]
    for k in range(1, FRAMES):
        half = 0.0105 * k
        poses.append(f"{k / RATE:.6f} {0.03 * k * k:.6f} 0 {0.41 * k:.6f} 0 {np.sin(half):.9f} 0 "
                     f"{np.cos(half):.9f}")
    (run / "trajectory.txt").write_text("\n".join(poses) + "\n")


def write_drive(root):
    root.mkdir(parents=True, exist_ok=True)
    write_truth(root)
    write_further_truth(root)
    write_run(root)
    return root
