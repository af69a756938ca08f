"""egosieve-view: a run's recording, read back by Rerun's own reader."""

import json
import subprocess
import sys
import unittest

import cv2
import numpy as np
from rerun.chunk import RrdReader

sys.path.insert(0, "tests/tools/evaluate")

import drive  # noqa: E402

IMAGE = "/world/camera/image"
OVERLAPS = {1: 0.9, 2: 0.25, 3: 0.4, 4: 0.8}  # by frame; the others have none
DOUBT = "the picture is dark"
HEAD = "frame,time_seconds,id,left,top,width,height,area,probability,sure"


def rows_of(file):
    """{entity: {frame: {component: value}}}; what holds for all frames is of frame None."""
    entities = {}
    for chunk in RrdReader(file).stream():
        batch = chunk.to_record_batch()
        frames = batch["frame"].to_pylist() if "frame" in batch.schema.names else [None] * batch.num_rows
        for k, frame in enumerate(frames):
            found = entities.setdefault(chunk.entity_path, {}).setdefault(frame, {})
            found.update({name: batch[name][k] for name in batch.schema.names if batch[name][k].is_valid})
    return entities


def value(row, name):
    """A component's values as an array."""
    return np.array(row[name].as_py()[0])


class Recording(drive.FolderCase):
    """The program as a user starts it, on a small run of frames 1 to 6."""

    def setUp(self):
        super().setUp()
        self.root = drive.write_drive(self.root / "drive")
        self.run_folder = self.root / "run"
        (self.run_folder / "tracks.csv").write_text(f"{HEAD}\n1,0.25,1,16,24,19,13,240,0.75,0.5\n1,0.25,4,60,30,7,15,90,0.7,0.5\n3,0.75,1,26,24,19,13,240,0.75,0.5\n")
        lines = [drive.line(k) | {"expected_overlap": OVERLAPS.get(k), "doubt": DOUBT if k == 5 else None} for k in range(1, drive.FRAMES)]
        self.write_lines(lines)

    def write_lines(self, lines):
        (self.run_folder / "frames.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))

    def view(self, *flags):
        done = subprocess.run([sys.executable, "tools/view/egosieve-view", self.run_folder, *flags], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def picture(self, row):
        return cv2.imdecode(value(row, "EncodedImage:blob").astype(np.uint8), cv2.IMREAD_COLOR).astype(int)

    def test_holds_what_the_run_holds(self):
        file = self.run_folder / "view.rrd"
        said = self.view()
        self.assertIn(f"{file}: 6 frames, {file.stat().st_size / 1e6:.1f} MB; look at it with: ", said)
        found = rows_of(file)
        for frame in range(1, drive.FRAMES):
            row = found[IMAGE][frame]
            self.assertEqual(row["time"].value, frame * 10**9 // drive.RATE)
            picture = cv2.imread(str(self.root / f"frames/{frame:06d}.png")).astype(int)
            self.assertLess(np.abs(self.picture(row) - picture).mean(), 10)
            ids = cv2.imread(str(self.run_folder / f"ids/{frame:06d}.png"), cv2.IMREAD_UNCHANGED)
            np.testing.assert_array_equal(value(found[f"{IMAGE}/masks"][frame], "SegmentationImage:buffer"), ids.reshape(-1))
            scores = cv2.imread(str(self.run_folder / f"grid/{frame:06d}.prob.png"), cv2.IMREAD_UNCHANGED)
            np.testing.assert_array_equal(value(found["/probability"][frame], "DepthImage:buffer"), (scores >> 8).reshape(-1))
        boxes = found[f"{IMAGE}/movers"]
        self.assertEqual(boxes[1]["Boxes2D:labels"].as_py(), ["mover 1", "mover 4"])
        np.testing.assert_allclose(boxes[1]["Boxes2D:centers"].as_py(), [[25.5, 30.5], [63.5, 37.5]])
        np.testing.assert_allclose(boxes[1]["Boxes2D:half_sizes"].as_py(), [[9.5, 6.5], [3.5, 7.5]])
        self.assertEqual((boxes[2]["Boxes2D:class_ids"].as_py(), boxes[3]["Boxes2D:class_ids"].as_py()), ([], [1]))
        np.testing.assert_allclose(value(found["/world/camera"][3], "Transform3D:translation"), [0.27, 0, 1.23], rtol=1e-6)
        focal = value(found[IMAGE][None], "Pinhole:image_from_camera")
        np.testing.assert_allclose(focal[[0, 4]], 97)

    def test_tells_what_is_doubtful(self):
        self.view()
        found = rows_of(self.run_folder / "view.rrd")
        told = {frame: row["Scalars:scalars"].as_py()[0] for frame, row in found["/doubt/expected_overlap"].items() if frame is not None}
        self.assertEqual(told, OVERLAPS)
        why = {frame: row["TextLog:text"].as_py()[0] for frame, row in found["/doubt/why"].items()}
        self.assertEqual(why, {2: "the map's probabilities expect an IoU of 0.25 between its mask and what moves", 5: DOUBT})

    def test_takes_pictures_of_a_video_by_their_index(self):
        file = self.root / "my.avi"
        writer = cv2.VideoWriter(str(file), cv2.VideoWriter_fourcc(*"MJPG"), drive.RATE, (drive.WIDTH + 1, drive.HEIGHT))
        for k in range(drive.FRAMES):
            writer.write(np.full((drive.HEIGHT, drive.WIDTH + 1, 3), 30 * k, np.uint8))
        writer.release()
        lines = [drive.line(k) | {"expected_overlap": None, "width_pixels": drive.WIDTH + 1} for k in (2, 3, 6)]
        self.write_lines(lines)
        (self.run_folder / "tracks.csv").unlink()
        for frame in (2, 3, 6):
            (self.run_folder / f"ids/{frame:06d}.png").unlink()
            scores = cv2.imread(str(self.run_folder / f"grid/{frame:06d}.prob.png"), cv2.IMREAD_UNCHANGED)
            cv2.imwrite(str(self.run_folder / f"grid/{frame:06d}.prob.png"), np.pad(scores, ((0, 0), (0, 1)), mode="edge")[:, :21])
        said = self.view(f"--input={file}", f"--out={self.root}/my.rrd")
        self.assertIn("no masks and numbers: egosieve refine", said)
        found = rows_of(self.root / "my.rrd")[IMAGE]
        for frame in (2, 3, 6):
            self.assertLess(abs(self.picture(found[frame]).mean() - 30 * frame), 3)

    def test_takes_pictures_of_lists_and_globs(self):
        (self.root / "list.csv").write_text("".join(f"{k},frames/{k:06d}.png\n" for k in range(drive.FRAMES)))
        for source in ("list.csv", "frames/*.png"):
            self.assertIn("6 frames", self.view(f"--input={self.root}/{source}"))

    def test_takes_every_nth_frame(self):
        self.assertIn("3 frames", self.view("--every=2"))
        self.assertEqual([frame for frame in rows_of(self.run_folder / "view.rrd")[IMAGE] if frame], [1, 3, 5])


if __name__ == "__main__":
    unittest.main()
