"""The kernel matrix: values beside scikit-learn's kernels, derivatives beside finite differences, and kernel_."""

import tempfile
import unittest

import numpy as np
from sklearn.base import clone
from sklearn.gaussian_process import kernels as sk

import egosieve

LENGTHS = [0.6, 1.3]
# Our name, scales and sigma_f, and the kernel of scikit-learn's that docs/migration.md puts beside it.
TABLE = [
    ("squared_exponential", LENGTHS, sk.RBF(LENGTHS)),
    ("isotropic(squared_exponential)", [0.7], sk.RBF(0.7)),
    ("matern12", LENGTHS, sk.Matern(LENGTHS, nu=0.5)),
    ("matern32", LENGTHS, sk.Matern(LENGTHS, nu=1.5)),
    ("matern52", LENGTHS, sk.Matern(LENGTHS, nu=2.5)),
    ("isotropic(rational_quadratic)", [0.8, 0.7], sk.RationalQuadratic(length_scale=0.7, alpha=0.8)),
    ("isotropic(linear) + constant", [1.0, 0.4], sk.DotProduct(0.4)),
    ("constant", [], sk.ConstantKernel(1.0)),
    ("white", [], sk.WhiteKernel(1.0)),
    ("squared_exponential[0] * squared_exponential[1]", LENGTHS, sk.RBF(LENGTHS)),
    ("matern52 * isotropic(squared_exponential)", [*LENGTHS, 0.7], sk.Matern(LENGTHS, nu=2.5) * sk.RBF(0.7)),
    ("matern32 + isotropic(squared_exponential)", [*LENGTHS, 0.5, 0.7], sk.Matern(LENGTHS, nu=1.5) + 0.25 * sk.RBF(0.7)),
]
PERIODIC = ("periodic", [0.9, 0.7], sk.ExpSineSquared(0.9, 0.7))


def points(n, seed, features=2):
    return np.random.default_rng(seed).uniform(-1, 1, (n, features))


def prior(name, scales, device=None):
    return egosieve.GaussianProcess(name, scales=scales or None, signal_stddev=1.3, device=device)


class Values(unittest.TestCase):
    def test_are_those_of_scikit_learn(self):
        for name, scales, theirs in [*TABLE, PERIODIC]:
            features = 1 if name == "periodic" else 2
            X, Z = points(40, 0, features), points(30, 1, features)
            for device in (None, "reference"):
                with self.subTest(name=name, device=device):
                    ours = prior(name, scales, device)
                    np.testing.assert_allclose(ours.covariance(X, Z), 1.69 * theirs(X, Z), rtol=0, atol=1e-12)
                    np.testing.assert_allclose(ours.covariance(X), 1.69 * theirs(X), rtol=0, atol=1e-12)

    def test_of_a_fitted_model_are_at_the_values_found(self):
        X = points(50, 0)
        gp = egosieve.GaussianProcess(1.5 * sk.RBF([0.5, 0.9]) + sk.WhiteKernel(0.1)).fit(X, np.sin(3 * X[:, 0]) + X[:, 1])
        self.assertNotAlmostEqual(gp.kernel_.k1.k2.length_scale[0], 0.5, places=2)
        np.testing.assert_allclose(gp.covariance(X), gp.kernel_.k1(X), atol=1e-8)
        self.assertAlmostEqual(gp.kernel_.k2.noise_level, gp.hyperparameters_["noise_stddev"] ** 2, places=9)

    def test_of_shapes_that_do_not_fit_are_refused(self):
        with self.assertRaisesRegex(ValueError, "z: 3 columns"):
            prior("matern52", LENGTHS).covariance(points(4, 0), points(4, 0, 3))


class Derivatives(unittest.TestCase):
    def test_are_those_of_finite_differences(self):
        X, Z, h = points(12, 2), points(9, 3), 1e-3
        for name, scales in [*((name, scales) for name, scales, _ in TABLE), ("arcsine", [0.8, 1.1, 0.7]), ("periodic", [0.9, 1.2, 0.7, 1.4])]:
            if name == "white":
                continue
            _, by_logarithms, by_x = prior(name, scales).covariance(X, Z, eval_gradient=True, eval_input_gradient=True)

            def five_points(values):  # truncation h^4 / 30 times the fifth derivative
                return (values(-2 * h) - 8 * values(-h) + 8 * values(h) - values(2 * h)) / (12 * h)

            for t in range(len(scales) + 1):
                def by_value(step):
                    moved = np.array([*scales, 1.3])
                    moved[t] *= np.exp(step)
                    return egosieve.GaussianProcess(name, scales=moved[:-1] if scales else None, signal_stddev=moved[-1]).covariance(X, Z)

                np.testing.assert_allclose(by_logarithms[..., t], five_points(by_value), atol=1e-7, err_msg=name)
            for d in range(2):
                def by_place(step):
                    return prior(name, scales).covariance(X + step * np.eye(2)[d], Z)

                if name != "matern12":  # whose fifth derivative is not bounded
                    np.testing.assert_allclose(by_x[..., d], five_points(by_place), atol=1e-7, err_msg=name)


class FoundKernels(unittest.TestCase):
    def test_have_the_values_of_the_model(self):
        X = points(60, 4)
        y = np.sin(3 * X[:, 0]) + X[:, 1] + 0.1 * np.random.default_rng(5).normal(size=60)
        for kernel in (
            sk.ConstantKernel(2.0) * sk.RBF([0.5, 0.8]) + sk.WhiteKernel(0.1),
            sk.RBF(0.7) + sk.ConstantKernel(0.4) * sk.Matern(0.5, nu=1.5) + sk.WhiteKernel(0.05),
            sk.ConstantKernel(2.0, "fixed") * sk.RationalQuadratic(0.9, 1.4) + sk.WhiteKernel(0.1) + sk.WhiteKernel(0.2),
        ):
            gp = egosieve.GaussianProcess(kernel).fit(X, y)
            again = egosieve.GaussianProcess(gp.kernel_, optimize=False).fit(X, y)
            for name in ("scales", "signal_stddev", "noise_stddev"):
                np.testing.assert_allclose(again.hyperparameters_[name], gp.hyperparameters_[name], rtol=1e-9)

    def test_keep_their_bounds_where_the_user_gives_none(self):
        X = points(30, 4)
        y = 3.0 * np.sin(3 * X[:, 0])
        for bounds in (None, {}, {"noise_stddev": "fixed"}, {"signal_stddev": (1.0, 2.0)}):
            gp = egosieve.GaussianProcess(sk.RBF(1.0, "fixed"), alpha=0.01, noise_stddev=1e-3, bounds=bounds).fit(X, y)
            with self.subTest(bounds=bounds):
                found = gp.hyperparameters_
                self.assertAlmostEqual(found["scales"][0], 1.0)
                if bounds and "signal_stddev" in bounds:  # no RBF has this amplitude
                    self.assertAlmostEqual(found["signal_stddev"], 2.0)
                    self.assertEqual(gp.kernel_, "isotropic(squared_exponential)")
                else:
                    self.assertAlmostEqual(found["signal_stddev"], 1.0)
                    self.assertEqual(gp.kernel_, sk.RBF(1.0, "fixed"))

    def test_are_told_of_values_that_contradict_them(self):
        X, kernel = points(9, 4), sk.RBF(0.7) + sk.WhiteKernel(0.09)
        for name, value in (("scales", [2.0]), ("scales", [0.7, 0.7]), ("signal_stddev", 5.0), ("noise_stddev", 0.7)):
            with self.assertRaisesRegex(ValueError, f"leave {name} out"):
                egosieve.GaussianProcess(kernel, **{name: value}).fit(X, X[:, 0])
        egosieve.GaussianProcess(kernel, scales=[0.7], noise_stddev=0.3).fit(X, X[:, 0])
        egosieve.GaussianProcess(sk.RBF(0.7), noise_stddev=0.7).fit(X, X[:, 0])

    def test_are_saved_as_they_were_given(self):
        X = points(30, 4)
        kernel = sk.ConstantKernel(2.0, "fixed") * sk.RBF(np.array([0.5, 0.8]), [(0.1, 1.0), (0.2, 2.0)]) + sk.WhiteKernel(0.1)
        gp = egosieve.GaussianProcess(kernel, bounds={"noise_stddev": (0.1, None)}).fit(X, X[:, 0])
        with tempfile.TemporaryDirectory() as folder:
            gp.save(f"{folder}/model.npz")
            loaded = egosieve.GaussianProcess.load(f"{folder}/model.npz")
        self.assertEqual(loaded.get_params(deep=False), gp.get_params(deep=False))
        self.assertEqual(loaded.kernel_, gp.kernel_)
        self.assertEqual(clone(loaded).fit(X, X[:, 0]).hyperparameters_, gp.hyperparameters_)

    def test_have_parameters_by_name(self):
        gp = egosieve.GaussianProcess(1.0 * sk.RBF(1.0))
        self.assertEqual(gp.get_params()["kernel__k2__length_scale"], 1.0)
        self.assertEqual(clone(gp).set_params(kernel__k2__length_scale=0.3).kernel.k2.length_scale, 0.3)
        self.assertEqual(gp.kernel.k2.length_scale, 1.0)


if __name__ == "__main__":
    unittest.main()
