"""egosieve.GaussianProcess beside scikit-learn's GaussianProcessRegressor, given the same kernels."""

import unittest

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct, ExpSineSquared, Matern, RationalQuadratic, WhiteKernel

import egosieve

NOISE = 0.09
KERNELS = [
    ConstantKernel(1.7) * RBF([0.5, 0.8]),
    RBF(0.7) + ConstantKernel(0.4) * Matern(0.5, nu=1.5),
    Matern([0.6, 0.9], nu=0.5) * ConstantKernel(2.0),
    (Matern(0.6, nu=2.5) + DotProduct(0.8)) * RationalQuadratic(0.9, 1.4),
    DotProduct(1.2) * DotProduct(0.3) + 0.5 * RBF(0.4),
    2.0 * (3.0 * RBF(0.4) + 0.5 * (Matern(0.7) + 0.2 * RBF(1.0))),
]


def data(seed, n):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, 2))
    return X, np.sin(3 * X[:, 0]) + X[:, 1], random.uniform(0.01, 0.1, n)


class SameKernels(unittest.TestCase):
    def test_posteriors_are_the_same(self):
        X, y, alpha = data(0, 70)
        queries = data(1, 30)[0]
        for kernel in KERNELS:
            for columns in (1, 2):
                targets = y if columns == 1 else np.stack([y, 5 + y**2], axis=1)
                theirs = GaussianProcessRegressor(kernel, alpha=NOISE + alpha, optimizer=None).fit(X, targets)
                ours = egosieve.GaussianProcess(
                    kernel, noise_stddev=np.sqrt(NOISE), alpha=alpha, optimize=False
                ).fit(X, targets)  # fmt: skip
                with self.subTest(kernel=str(kernel), columns=columns):
                    mean, joint = ours.predict(queries, return_cov=True)
                    expected_mean, expected_joint = theirs.predict(queries, return_cov=True)
                    if columns == 2 and expected_joint.ndim == 2:  # an older scikit-learn
                        expected_joint = expected_joint[:, :, None]
                    # Two solutions in float64: n eps cond(K), for a least eigenvalue of 0.09.
                    np.testing.assert_allclose(mean, expected_mean, atol=1e-9)
                    np.testing.assert_allclose(joint, np.broadcast_to(expected_joint, joint.shape), atol=1e-9)
                    self.assertAlmostEqual(
                        ours.log_marginal_likelihood(), theirs.log_marginal_likelihood_value_, delta=1e-8 * len(X)
                    )
                    self.assertEqual(
                        ours.sample_y(queries, 4).shape, theirs.sample_y(queries, 4).shape
                    )  # fmt: skip

    def test_normalisation(self):
        X, y, alpha = data(0, 70)
        queries = data(1, 30)[0]
        y = 300 + 20 * y
        kernel = Matern(0.6, nu=2.5)
        theirs = GaussianProcessRegressor(kernel, alpha=NOISE + alpha, optimizer=None, normalize_y=True).fit(X, y)
        ours = egosieve.GaussianProcess(
            kernel, noise_stddev=np.sqrt(NOISE), alpha=alpha, optimize=False, normalize_y=True
        ).fit(X, y)  # fmt: skip
        for mine, yours in zip(ours.predict(queries, return_cov=True), theirs.predict(queries, return_cov=True)):
            np.testing.assert_allclose(mine, yours, rtol=1e-9, atol=1e-8)

    def test_white_noise_and_periods(self):
        X, y, _ = data(0, 70)
        kernel = 1.5 * ExpSineSquared(0.9, 0.7) + WhiteKernel(0.04)
        theirs = GaussianProcessRegressor(kernel, alpha=1e-12, optimizer=None).fit(X[:, :1], y)
        ours = egosieve.GaussianProcess(kernel, optimize=False).fit(X[:, :1], y)
        self.assertAlmostEqual(ours.hyperparameters_["noise_stddev"], 0.2)
        queries = np.linspace(-1, 1, 20)[:, None]
        np.testing.assert_allclose(ours.predict(queries, float64=True), theirs.predict(queries), atol=1e-9)
        # A WhiteKernel is part of scikit-learn's f.
        expected = theirs.predict(queries, return_cov=True)[1]
        np.testing.assert_allclose(ours.predict(queries, return_cov=True, of_observation=True)[1], expected, atol=1e-9)
        with self.assertRaisesRegex(ValueError, "for more than one feature"):
            egosieve.GaussianProcess(kernel).fit(X, y)
        with self.assertRaisesRegex(ValueError, "has no counterpart"):
            egosieve.GaussianProcess(RBF(1.0) ** 2).fit(X, y)
        with self.assertRaisesRegex(ValueError, "3 length scales for 2 features"):
            egosieve.GaussianProcess(RBF([1.0, 1.0, 1.0])).fit(X, y)


if __name__ == "__main__":
    unittest.main()
