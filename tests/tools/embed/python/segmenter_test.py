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
        for one in (segmenter, loaded):
            self.assertAlmostEqual(one._arguments(last, None)[1], 0.3)
        found, again = segmenter.process(last), loaded.process(last)
        self.assertEqual(found.probability.shape, segmenter.grid_size(WIDTH, HEIGHT))
        for name in ("probability", "mean", "deviation"):
            np.testing.assert_array_equal(getattr(found, name), getattr(again, name))
        self.assertGreater(found.probability[12, 13], 0.5)
        self.assertLess(found.probability[0, -1], 0.5)
        self.assertEqual(segmenter.process(last, full=True).probability.shape, (HEIGHT, WIDTH))
        self.assertGreater(segmenter.learn(last).model_size, 50)

    def test_objects(self):
        segmenter = egosieve.Segmenter(budget=300)
        *_, found = segmenter.process_all(frames(4), full=True)
        square = (slice(42, 78), slice(50, 86))
        self.assertGreater(found.mask[square].mean(), 0.9)
        number = found.objects[60, 68]
        (moving,) = [one for one in found.list_objects() if one.number == number]
        self.assertLess(abs(moving.left + moving.width / 2 - 68), 10)
        self.assertLess(abs(moving.top + moving.height / 2 - 60), 10)
        self.assertEqual(moving.places, (found.objects == number).sum())
        self.assertGreaterEqual(moving.peak, 0.8)

    def test_the_ignored_area_does_not_move(self):
        ignore = np.zeros((HEIGHT, WIDTH), bool)
        ignore[30:90, 20:] = True
        *_, found = egosieve.Segmenter(budget=300, ignore=ignore).process_all(frames(4), full=True)
        self.assertFalse(found.mask[ignore].any())
        self.assertEqual(found.report.dynamic_labels, 0)
        with self.assertRaisesRegex(ValueError, "options.ignore is 160x120"):
            egosieve.Segmenter(ignore=ignore).process(np.zeros((20, 30), np.uint8))

    def test_a_lag_gives_every_frame_its_map_later(self):
        segmenter = egosieve.Segmenter(budget=300, lag=2, focal_ratio=0.8)
        pictures = list(frames(5))
        self.assertIsNone(segmenter.process(pictures[0]))
        self.assertIsNone(segmenter.learn(pictures[1]))
        self.assertEqual(segmenter.process(pictures[2]).report.frame, 0)
        with self.assertRaisesRegex(ValueError, "with a lag all frames have one size"):
            segmenter.process(pictures[0][:100])
        path = os.path.join(os.getcwd(), "lagging.npz")
        segmenter.save(path)
        loaded = egosieve.Segmenter.load(path)
        ends = [[one.process(picture, 0.1 * t) for t, picture in enumerate(pictures[3:], 3)] + list(one.finish())
                for one in (segmenter, loaded)]  # fmt: skip
        for end in ends:
            self.assertEqual([found.report.frame for found in end], [1, 2, 3, 4])
        for found, again in zip(*ends):
            np.testing.assert_array_equal(found.probability, again.probability)
        self.assertEqual(list(segmenter.finish()), [])
        live = list(egosieve.Segmenter(budget=300, focal_ratio=0.8).process_all(pictures))
        self.assertFalse(np.array_equal(live[2].probability, ends[0][1].probability))

    def test_every_frame_of_a_long_lag_is_in_the_file(self):
        (picture,) = frames(1)
        segmenter = egosieve.Segmenter(budget=300, lag=100, focal_ratio=0.8)
        for t in range(60):
            self.assertIsNone(segmenter.learn(np.roll(picture, t, axis=1)[:60, :80]))
        path = os.path.join(os.getcwd(), "long_lag.npz")
        segmenter.save(path)
        loaded = egosieve.Segmenter.load(path)
        found, again = next(segmenter.finish()), next(loaded.finish())
        self.assertEqual(found.report.frame, 0)
        np.testing.assert_array_equal(found.probability, again.probability)

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
            (ValueError, r"frame has shape \(20, 30, 2\); it must be height x width", lambda: segmenter.process(picture[..., :2])),
            (ValueError, "time_seconds = nan", lambda: segmenter.process(picture, float("nan"))),
            (ValueError, "order = 'gbr'", lambda: segmenter.process(picture, order="gbr")),
            (ValueError, "profile = 'slow'", lambda: egosieve.Segmenter("slow")),
            (ValueError, "options.focal_ratio = nan", lambda: egosieve.Segmenter(focal_ratio=float("nan"))),
            (ValueError, "options.lag = -1", lambda: egosieve.Segmenter(lag=-1)),
            (ValueError, "options.ignore has colours", lambda: egosieve.Segmenter(ignore=picture)),
            (ValueError, "options.stride = 0", lambda: egosieve.Segmenter(stride=0)),
            (FileNotFoundError, "nowhere", lambda: egosieve.Segmenter.load("/nowhere")),
        ]
        for kind, words, call in cases:
            with self.subTest(words):
                with self.assertRaisesRegex(kind, words):
                    call()


if __name__ == "__main__":
    unittest.main()
