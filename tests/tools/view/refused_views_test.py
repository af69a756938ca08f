"""egosieve-view: what is missing or wrong is told in one line, and nothing is written."""

import json
import os
import subprocess
import sys
import unittest

import cv2
import numpy as np

sys.path.insert(0, "tests/tools/evaluate")

import drive  # noqa: E402


class Refused(drive.FolderCase):
    """The program without Rerun, on a small run."""

    def setUp(self):
        super().setUp()
        self.root = drive.write_drive(self.root / "drive")
        (self.root / "none" / "rerun").mkdir(parents=True)
        (self.root / "none" / "rerun" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'rerun'\")\n")

    def check(self, code, what, *flags, run="run"):
        before = sorted(self.root.rglob("*"))
        environment = dict(os.environ, PYTHONPATH=str(self.root / "none"))
        words = [sys.executable, "-B", "tools/view/egosieve-view", self.root / run, *flags]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertRegex(done.stderr, what)
        self.assertEqual((done.stderr.count("\n"), done.stdout), (1, ""), done.stderr)
        self.assertEqual(sorted(self.root.rglob("*")), before)

    def test_no_rerun(self):
        self.check(1, "No module named 'rerun'; pip install rerun-sdk")

    def test_no_run(self):
        self.check(3, "there is no .*/none/run.json", run="none")

    def test_no_recording_to_write(self):
        self.check(2, "is no file .rrd", f"--out={self.root}/my.mp4")
        self.check(2, "--every=0 is below 1", "--every=0")

    def test_no_map(self):
        (self.root / "run" / "frames.jsonl").write_text(json.dumps(drive.line(0) | {"width_pixels": 0}) + "\n")
        self.check(2, "has no map")

    def test_no_pictures(self):
        self.check(3, "there is no .*/gone; .*--input", f"--input={self.root}/gone")
        self.check(3, "frame 0 of .* is not what was segmented; .*--input", f"--input={self.root}/none")

    def test_other_pictures(self):
        cv2.imwrite(str(self.root / "frames/000000.png"), np.zeros((8, 8), np.uint8))
        self.check(3, "frame 0 of .* is not what was segmented")


if __name__ == "__main__":
    unittest.main()
