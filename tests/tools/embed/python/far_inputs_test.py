"""egosieve.GaussianProcess far from zero: inputs are seconds since 1970, where steps of float32 are 128.

A query that is moved by such a step changes its mean by up to 0.1. Float32 results are within 1e-3: 1e-6 |alpha|_1
for the mean, 2e-6 sqrt(n) / sigma_n and some more for the variance.
"""

import unittest

import numpy as np

import egosieve

TIMES = 1.7e9 + 60.0 * np.arange(100)


def fitted(X, y, scales, **options):
    options = {"noise_stddev": 0.1, "optimize": False, **options}
    return egosieve.GaussianProcess("squared_exponential", scales=scales, **options).fit(X, y)


class FarInputs(unittest.TestCase):
    def test_points_are_predicted_as_in_float64(self):
        y = 2 * np.sin(TIMES / 1000)
        cases = [
            (y, {}),
            (y, {"mean": "constant"}),
            (y, {"approximation": "dtc", "inducing_points": 12}),
            (np.column_stack([y, 2 * np.cos(TIMES / 1000)]), {}),
        ]
        queries = TIMES[:-1, None] + 30
        for targets, options in cases:
            gp = fitted(TIMES[:, None], targets, [600.0], **options)
            expected = gp.predict(queries, return_var=True, float64=True)
            for process in (gp, gp.freeze()):
                found = process.predict(queries, return_var=True)
                for part, of_float64 in zip(found, expected):
                    np.testing.assert_allclose(part, of_float64, atol=1e-3, err_msg=str(options))

    def test_grids_are_predicted_as_in_float64(self):
        places = np.arange(100) % 5 / 4
        gp = fitted(np.column_stack([TIMES, places]), 2 * np.sin(TIMES / 1000) * (1 + places), [600.0, 0.5])
        # The second axis is uneven by less than a step of float32.
        for x in (1.7e9 + 60.0 * np.arange(5), 1.7e9 + np.array([0.0, 45.0, 130.0, 260.0, 300.0])):
            y = np.linspace(0, 1, 4)
            points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
            expected = gp.predict(points, return_var=True, float64=True)
            found = gp.predict_axes(x, y, return_var=True)
            for part, of_float64 in zip(found, expected):
                self.assertEqual(part.dtype, np.float32)
                np.testing.assert_allclose(part.ravel(), of_float64, atol=1e-3)

    def test_narrow_inputs_lose_nothing_in_float32(self):
        X = 13.4 + 0.001 * np.random.default_rng(3).uniform(size=(200, 1))  # steps of float32 are a thousandth of it
        gp = fitted(X, np.sin(8000 * (X[:, 0] - 13.4)), [2e-4])
        expected = gp.predict(X, return_var=True, float64=True)
        found = gp.predict(X, return_var=True)
        self.assertEqual(gp.float64_count_, 0)
        for part, of_float64 in zip(found, expected):
            np.testing.assert_allclose(part, of_float64, atol=2e-4)


if __name__ == "__main__":
    unittest.main()
