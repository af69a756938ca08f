"""Arithmetic of egosieve.GaussianProcess: float64 where float32 does not suffice, said once."""

import math
import os
import unittest
import warnings

import numpy as np

import egosieve


def branin(X):
    u, v = 15 * X[:, 0] - 5, 15 * X[:, 1]
    return (v - 5.1 * u**2 / (4 * np.pi**2) + 5 * u / np.pi - 6) ** 2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(u) + 10


def process(kernel="squared_exponential", **options):
    return egosieve.GaussianProcess(kernel, **{"optimize": False, **options})


def hard_cases():
    """Fitted models whose float32 results are wrong by more than the deviation, and queries."""
    random = np.random.default_rng(0)
    line = np.linspace(-1, 1, 50)[:, None]
    plane = random.uniform(size=(100, 2))
    between = random.uniform(-1, 1, (700, 1))
    quiet = {"noise_stddev": 0.007, "signal_stddev": 5.0, "scales": [2.0, 3.0]}
    return {
        "low noise": (process("arcsine", **quiet).fit(line, np.sin(4 * line[:, 0])), between),
        "offset": (process(noise_stddev=0.1, signal_stddev=5e6).fit(line, 5e6 + np.sin(6 * line[:, 0])), between),
        "units": (process(noise_stddev=1.0, signal_stddev=1e4).fit(line, 1e4 * (2 + np.sin(8 * line[:, 0]))), between),
        "branin": (process("matern52", noise_stddev=0.01, signal_stddev=300.0).fit(plane, branin(plane)), np.abs(between) ** [1, 2]),
        "sparse": (
            process(noise_stddev=1e-3, scales=[0.5], approximation="dtc", inducing_points=30).fit(line, np.sin(4 * line[:, 0])),
            between,
        ),
        "several outputs": (
            process(noise_stddev=0.1, mean="constant", signal_stddev=10.0).fit(line, 5e6 + np.column_stack([line, line**2])),
            between,
        ),
    }


@unittest.skipIf(os.environ.get("EGOSIEVE_DEVICE") == "reference", "the reference is in float64")
class Precision(unittest.TestCase):
    def setUp(self):
        warnings.simplefilter("ignore")

    def test_the_default_is_right_where_float32_is_not(self):
        for name, (gp, queries) in hard_cases().items():
            mean, std = gp.predict(queries, return_std=True, precision="float64")
            narrow_mean, narrow_std = gp.predict(queries, return_std=True, precision="float32")
            self.assertEqual(gp.float64_count_, 0)
            wrong = max(np.abs(narrow_mean - mean).max(), np.abs(narrow_std - std).max())
            self.assertGreater(wrong, 0.1 * std.min(), name)
            for predictor in (gp, gp.freeze(), gp.freeze(["cpu", "cpu"])):
                found_mean, found_std = predictor.predict(queries, return_std=True)
                self.assertGreater(predictor.float64_count_, 0, name)
                self.assertEqual(predictor.clamped_variances_, 0, name)
                np.testing.assert_array_less(np.abs(found_mean - mean), 0.02 * std.min(), name)
                np.testing.assert_array_less(np.abs(found_std - std), 0.02 * std, name)
                np.testing.assert_array_equal(predictor.predict(queries), found_mean, name)
                for rows in (slice(0, 1), slice(130, 650)):  # whatever else is asked
                    np.testing.assert_array_equal(predictor.predict(queries[rows], return_std=True)[1], found_std[rows])

    def test_grids_axes_and_probabilities(self):
        X = np.random.default_rng(1).uniform(size=(60, 2))
        gp = process(noise_stddev=1e-3).fit(X, np.where(X[:, 0] > 0.5, 1.0, -1.0))
        axis = np.linspace(0, 1, 9)
        points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
        mean, std = gp.predict(points, return_std=True, precision="float64")
        uneven = np.append(axis[:-1], 1.1)
        for predictor in (gp, gp.freeze()):
            grid = predictor.predict_grid(0, 0, 0.125, 0.125, 9, 9, return_std=True)
            self.assertGreater(predictor.float64_count_, 0)
            axes = predictor.predict_axes(uneven, axis, return_std=True, precision="float64")
            for found in (grid, tuple(part[:, :-1] for part in axes)):
                expected = [part.reshape(9, 9)[:, : found[0].shape[1]] for part in (mean, std)]
                np.testing.assert_array_less(np.abs(found[0] - expected[0]), 0.02 * std.min() + 1e-6)
                np.testing.assert_array_less(np.abs(found[1] - expected[1]), 0.02 * expected[1])
            probability = predictor.predict_proba(points)[:, 1]
            self.assertGreater(predictor.float64_count_, 0)
            a, b = gp.hyperparameters_["squash"]
            of_float64 = [0.5 + 0.5 * math.erf(z) for z in (a * mean + b) / np.sqrt(2 + 2 * (a * std) ** 2)]
            np.testing.assert_allclose(probability, of_float64, atol=1e-6)

    def test_clamped_variances_are_counted(self):
        gp, queries = hard_cases()["low noise"]
        std = gp.predict(queries, return_std=True, precision="float32")[1]
        self.assertGreater(gp.clamped_variances_, 0)
        self.assertEqual(gp.clamped_variances_, (std == 0).sum())

    def test_float32_is_used_where_it_suffices(self):
        X = np.random.default_rng(2).uniform(-1, 1, (300, 4))
        for kernel in ("arcsine", "squared_exponential", "matern52", "linear + constant"):
            gp = process(kernel, noise_stddev=0.3).fit(X, np.sin(2 * X[:, 0]))
            results = gp.predict(X, return_std=True)
            self.assertEqual(gp.float64_count_, 0, kernel)
            for found, expected in zip(results, gp.predict(X, return_std=True, precision="float32")):
                np.testing.assert_array_equal(found, expected)

    def test_the_warning_comes_once_for_each_model(self):
        gp, queries = hard_cases()["offset"]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            gp.predict(queries, float64=True)
            gp.predict(queries, precision="float32")
            self.assertEqual(len(caught), 0)
            gp.predict(queries)
            gp.predict(queries, return_std=True)
            self.assertEqual([str(w.message)[:31] for w in caught], ["float32 does not suffice for th"])
            self.assertEqual(caught[0].filename, __file__)

    def test_the_error_is_told(self):
        gp, queries = hard_cases()["low noise"]
        error = gp.freeze().float32_error()
        std = gp.predict(queries, return_std=True, precision="float64")[1]
        self.assertGreater(error["variance"], 0.02 * error["deviation"] ** 2)
        self.assertLess(error["deviation"], 2 * std.min())


if __name__ == "__main__":
    unittest.main()
