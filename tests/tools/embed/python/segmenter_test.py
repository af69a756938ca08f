"""egosieve.Segmenter on a square that crosses a still background."""

import os
import unittest

import numpy as np

import egosieve

WIDTH, HEIGHT = 160, 120


def frames(count):
    random = np.random.default_rng(3)
    background = np.kron(random.integers(0, 128, (HEIGHT // 4, WIDTH // 4, 3)), np.ones((4, 4, 1))).astype(np.uint8)
    square = np.kron(random.integers(128, 256, (10, 10, 3)), np.ones((4, 4, 1))).astype(np.uint8)
    for t in range(count):
        frame = background.copy()
        frame[40:80, 30 + 6 * t : 70 + 6 * t] = square
        yield frame


class SegmenterTest(unittest.TestCase):
    def test_maps_and_going_on_from_a_file(self):
        segmenter = egosieve.Segmenter(budget=300)
        *first, last = frames(4)
        for t, frame in enumerate(first):
            found = segmenter.process(frame)
            self.assertEqual(found.report.frame, t)
            self.assertEqual(found.report.learnt, t > 0)
        path = os.path.join(os.getcwd(), "segmenter.npz")
        segmenter.save(path)
        loaded = egosieve.Segmenter.load(path)
        found, again = segmenter.process(last, 0.3), loaded.process(last, 0.3)
        self.assertEqual(found.probability.shape, segmenter.grid_size(WIDTH, HEIGHT))
        for name in ("probability", "mean", "deviation"):
            np.testing.assert_array_equal(getattr(found, name), getattr(again, name))
        self.assertGreater(found.probability[12, 13], 0.5)
        self.assertLess(found.probability[0, -1], 0.5)
        self.assertEqual(segmenter.process(last, full=True).probability.shape, (HEIGHT, WIDTH))
        self.assertGreater(segmenter.learn(last).model_size, 50)

    def test_layouts_of_frames_do_not_matter(self):
        segmenters = [egosieve.Segmenter(budget=300) for _ in range(4)]
        for frame in frames(2):
            wide = np.zeros((HEIGHT, WIDTH + 5, 3), np.uint8)
            wide[:, :WIDTH] = frame
            expected = segmenters[0].process(frame).probability
            for segmenter, picture, order in zip(
                segmenters[1:],
                (wide[:, :WIDTH], np.asfortranarray(frame), frame[..., ::-1]),
                ("bgr", "bgr", "rgb"),
            ):
                np.testing.assert_array_equal(segmenter.process(picture, order=order).probability, expected)

    def test_errors_name_the_argument(self):
        segmenter = egosieve.Segmenter()
        picture = np.zeros((20, 30, 3), np.uint8)
        cases = [
            (TypeError, "frame has dtype float64", lambda: segmenter.process(picture.astype(float))),
            (TypeError, "frame has dtype object", lambda: segmenter.process(picture.astype(object))),
            (ValueError, "frame has shape", lambda: segmenter.process(picture[0, 0])),
            (ValueError, "frame must be height x width", lambda: segmenter.process(picture[..., :2])),
            (ValueError, "time_seconds = nan", lambda: segmenter.process(picture, float("nan"))),
            (ValueError, "order = 'gbr'", lambda: segmenter.process(picture, order="gbr")),
            (ValueError, "profile = 'slow'", lambda: egosieve.Segmenter("slow")),
            (ValueError, "options.stride = 0", lambda: egosieve.Segmenter(stride=0)),
            (FileNotFoundError, "nowhere", lambda: egosieve.Segmenter.load("/nowhere")),
        ]
        for kind, words, call in cases:
            with self.subTest(words):
                with self.assertRaisesRegex(kind, words):
                    call()


if __name__ == "__main__":
    unittest.main()
