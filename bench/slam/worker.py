"""ORB-SLAM3 on one drive, in the environment that bench_slam.py makes. Prints a line of JSON.

worker.py vocabulary DRIVE FILE          a tree of ORB features as DBoW2 reads it as text
worker.py track DRIVE MASKS VOCABULARY   where the frames were taken; MASKS "-": none
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


def split(bits, members):
    """Up to BRANCHES centres of the members, and whose each member is."""
    if len(members) < BRANCHES:
        return bits[members], np.arange(len(members))
    until = (cv2.TERM_CRITERIA_COUNT, 6, 0)
    _, nearest, centres = cv2.kmeans(bits[members], BRANCHES, None, until, 1, cv2.KMEANS_RANDOM_CENTERS)
    return centres > 0.5, nearest.ravel()


def write_vocabulary(drive, path):
    """Breadth first: a node's parent precedes it."""
    orb = cv2.ORB_create(600)
    found = [orb.detectAndCompute(cv2.imread(str(frame), 0), None)[1] for frame in sorted((drive / "frames").glob("*.png"))[::5]]
    bits = np.unpackbits(np.vstack([each for each in found if each is not None]), axis=1).astype(np.float32)
    cv2.setRNGSeed(1)
    nodes, level_nodes = [], [(0, np.arange(len(bits)))]
    for level in range(1, LEVELS + 1):
        below = []
        for parent, members in level_nodes:
            centres, nearest = split(bits, members)
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


def track(drive, masks, vocabulary):
    """The camera's place in each frame with a pose."""
    import pyorbslam3

    camera = json.loads((drive / "camera.json").read_text())
    settings = SETTINGS.format(focal=camera["focal_pixels"], x=camera["width"] / 2, y=camera["height"] / 2,
                               width=camera["width"], height=camera["height"])  # fmt: skip
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(settings)
        file.flush()
        slam = pyorbslam3.Slam(vocabulary, file.name, pyorbslam3.Sensor.MONOCULAR)
    places = {}
    for index, frame in enumerate(sorted((drive / "frames").glob("*.png"))):
        image = cv2.imread(str(frame), 0)
        if masks != "-":
            image = paint_over(image, cv2.imread(f"{masks}/{frame.name}.png", 0) == 0)
        result = slam.track_monocular(image, index / camera["frames_per_second"])
        time.sleep(PAUSE_SECONDS)
        if result.pose_valid:
            places[index] = np.array(result.pose_wc)[:3, 3].tolist()
    print(json.dumps({"places": places}), flush=True)
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
