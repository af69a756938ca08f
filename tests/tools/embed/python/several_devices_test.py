"""Posteriors of egosieve.GaussianProcess on several devices; that each has its piece is tested of the C interface."""

import unittest

import egosieve
import numpy as np

COUNT = 3000  # a piece for either of two devices


class SeveralDevices(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(3)
        X = random.uniform(-1, 1, (40, 2))
        self.queries = random.uniform(-1, 1, (COUNT, 2)).astype(np.float32)
        self.model = egosieve.GaussianProcess("matern52", optimize=False, device="0")
        self.model.fit(X, np.where(X[:, 0] > X[:, 1], 1.0, -1.0))

    def test_one_device_twice_gives_its_results(self):
        name = egosieve.devices()[0].partition(": ")[2]
        single = self.model.freeze()
        for devices in (["0"], [0, 0], ("0", name)):
            shared = self.model.freeze(devices=devices)
            for found, expected in zip(*(p.predict(self.queries, return_std=True) for p in (shared, single))):
                np.testing.assert_array_equal(found, expected)
            np.testing.assert_array_equal(shared.predict_proba(self.queries), single.predict_proba(self.queries))
            grid = (-1, -1, 0.03, 0.03, 60, 60)
            np.testing.assert_array_equal(shared.predict_grid(*grid), single.predict_grid(*grid))

    def test_refuses_what_is_no_device(self):
        with self.assertRaisesRegex(ValueError, r"devices\[1\]: device \"nowhere\""):
            self.model.freeze(devices=["0", "nowhere"])
        with self.assertRaisesRegex(ValueError, "device_count = 0"):
            self.model.freeze(devices=[])
        with self.assertRaisesRegex(TypeError, "list of names"):
            self.model.freeze(devices="0")
        with self.assertRaisesRegex(RuntimeError, "lies on 2"):
            self.model.freeze(devices=["0", "0"]).opencl()


if __name__ == "__main__":
    unittest.main()
