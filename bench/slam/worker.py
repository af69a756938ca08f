"""ORB-SLAM3 on one drive, in the environment that bench_slam.py makes. Prints a line of JSON.

worker.py vocabulary DRIVE FILE          a tree of ORB features as DBoW2 reads it as text
worker.py track DRIVE MASKS VOCABULARY   a trajectory, scored against the drive's truth; MASKS "-": none
"""

import json
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

BRANCHES, LEVELS = 4, 6
PAUSE_SECONDS = 0.15  # between frames, for the threads that map

SETTINGS = """%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: {focal}
Camera1.fy: {focal}
Camera1.cx: {x}
Camera1.cy: {y}
Camera1.k1: 0.0
Camera1.k2: 0.0
Camera1.p1: 0.0
Camera1.p2: 0.0
Camera.width: {width}
Camera.height: {height}
Camera.fps: 10
Camera.RGB: 0
ORBextractor.nFeatures: 1500
ORBextractor.scaleFactor: 1.2
ORBextractor.nLevels: 8
ORBextractor.iniThFAST: 20
ORBextractor.minThFAST: 7
Viewer.KeyFrameSize: 0.05
Viewer.KeyFrameLineWidth: 1.0
Viewer.GraphLineWidth: 0.9
Viewer.PointSize: 2.0
Viewer.CameraSize: 0.08
Viewer.CameraLineWidth: 3.0
Viewer.ViewpointX: 0.0
Viewer.ViewpointY: -0.7
Viewer.ViewpointZ: -1.8
Viewer.ViewpointF: 500.0
"""


def split(bits, members, random):
    """Up to BRANCHES centres of the members by k-majority, and whose each member is."""
    if len(members) < BRANCHES:
        return bits[members], np.arange(len(members))
    centres = bits[random.choice(members, BRANCHES, replace=False)].copy()
    for _ in range(6):
        distance = bits[members] @ (1 - 2 * centres.T) + centres.sum(1)[None]
        nearest = distance.argmin(1)
        for branch in np.unique(nearest):
            centres[branch] = bits[members[nearest == branch]].mean(0) > 0.5
    return centres, nearest


def write_vocabulary(drive, path):
    """Breadth first: a node's parent precedes it."""
    orb = cv2.ORB_create(600)
    found = [orb.detectAndCompute(cv2.imread(str(frame), 0), None)[1] for frame in sorted((drive / "frames").glob("*.png"))[::5]]
    bits = np.unpackbits(np.vstack([each for each in found if each is not None]), axis=1).astype(np.int16)
    random = np.random.default_rng(0)
    nodes, level_nodes = [], [(0, np.arange(len(bits)))]
    for level in range(1, LEVELS + 1):
        below = []
        for parent, members in level_nodes:
            centres, nearest = split(bits, members, random)
            for branch, centre in enumerate(centres):
                nodes.append((parent, level == LEVELS, np.packbits(centre.astype(np.uint8))))
                below.append((len(nodes), members[nearest == branch]))
        level_nodes = below
    lines = [f"{BRANCHES} {LEVELS} 0 0"] + [f"{parent} {int(leaf)} {' '.join(map(str, word))} 1.0" for parent, leaf, word in nodes]
    path.write_text("\n".join(lines) + "\n")
    return {"words": len(level_nodes)}


def paint_over(image, masked):
    """The masked part becomes a smooth continuation of the rest, with a soft seam."""
    if not masked.any():
        return image
    rest = (~masked).astype(np.float32)
    pixels = image.astype(np.float32)
    smooth = cv2.GaussianBlur(pixels * rest, (0, 0), 40) / np.maximum(cv2.GaussianBlur(rest, (0, 0), 40), 1e-4)
    seam = cv2.GaussianBlur(masked.astype(np.float32), (0, 0), 4)
    pixels[masked] = smooth[masked]
    return (pixels * (1 - seam) + smooth * seam).clip(0, 255).astype(np.uint8)


def error_after_similarity(estimated, true):
    """Root of the mean squared distance, metres (Umeyama, 1991)."""
    a, b = estimated - estimated.mean(0), true - true.mean(0)
    u, singular, v = np.linalg.svd(b.T @ a / len(a))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ v))])
    scale = (singular * signs).sum() / ((a**2).sum() / len(a))
    return float(np.sqrt(((scale * a @ (u * signs @ v).T - b) ** 2).sum(1).mean()))


def track(drive, masks, vocabulary):
    """Frames with a pose, and their trajectory's error."""
    import pyorbslam3

    camera = json.loads((drive / "camera.json").read_text())
    settings = SETTINGS.format(focal=camera["focal_pixels"], x=camera["width"] / 2, y=camera["height"] / 2,
                               width=camera["width"], height=camera["height"])  # fmt: skip
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(settings)
        file.flush()
        slam = pyorbslam3.Slam(vocabulary, file.name, pyorbslam3.Sensor.MONOCULAR)
    centres = np.loadtxt(drive / "poses.txt").reshape(-1, 3, 4)[:, :, 3]
    estimated, true = [], []
    for index, frame in enumerate(sorted((drive / "frames").glob("*.png"))):
        image = cv2.imread(str(frame), 0)
        if masks != "-":
            image = paint_over(image, cv2.imread(f"{masks}/{frame.name}.png", 0) == 0)
        result = slam.track_monocular(image, index / camera["frames_per_second"])
        time.sleep(PAUSE_SECONDS)
        if result.pose_valid:
            estimated.append(np.array(result.pose_wc)[:3, 3])
            true.append(centres[index])
    error = error_after_similarity(np.array(estimated), np.array(true)) if len(estimated) > 5 else None
    length = float(np.linalg.norm(np.diff(centres, axis=0), axis=1).sum())
    print(json.dumps({"tracked": len(estimated), "trajectory_error_metres": error, "length_metres": length}), flush=True)
    slam.shutdown()


def main():
    """One task, named by the first argument."""
    task, drive, *rest = sys.argv[1:]
    if task == "vocabulary":
        print(json.dumps(write_vocabulary(Path(drive), Path(rest[0]))))
    else:
        track(Path(drive), *rest)


if __name__ == "__main__":
    main()
