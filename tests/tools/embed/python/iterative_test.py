"""Iterative models of egosieve.GaussianProcess against the exact model and what they refuse."""

import pickle
import unittest
import warnings

import egosieve
import numpy as np

KERNEL = "matern52[0:3] * periodic[3]"


def data(n=600, seed=0, targets=2):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, 4))
    y = np.stack([np.sin(3 * X[:, 0]) * X[:, 1], 5 + X[:, 2] + np.cos(5 * X[:, 3])], axis=1) + random.normal(0, 0.2, (n, 2))
    return X, y[:, :targets] if targets > 1 else y[:, 0]


def process(approximation="iterative", kernel=KERNEL, **options):
    options = {"noise_stddev": 0.2, "optimize": False, "inducing_points": 60, "normalize_y": True} | options
    return egosieve.GaussianProcess(kernel, approximation=approximation, **options)


class Iterative(unittest.TestCase):
    def test_means_are_those_of_the_factor(self):
        X, y = data()
        alpha = np.linspace(0.0, 0.1, len(X))
        exact = process("exact", alpha=alpha).fit(X, y)
        gp = process(alpha=alpha, tolerance=1e-11).fit(X, y)
        queries = data(50, seed=1)[0]
        with warnings.catch_warnings():  # that float64 is the rule is nothing to warn of
            warnings.simplefilter("error")
            mean, frozen = gp.predict(queries), gp.freeze().predict(queries)
        np.testing.assert_allclose(mean, exact.predict(queries, precision="float64"), atol=1e-8)
        np.testing.assert_array_equal(frozen, mean)
        np.testing.assert_allclose(gp.predict_gradient(queries), exact.predict_gradient(queries), atol=1e-7)
        np.testing.assert_allclose(gp.predict(queries, precision="float32"), mean, atol=1e-3)
        found = gp.hyperparameters_
        self.assertGreater(found["iterations"], 0)
        self.assertTrue(0 < found["residual"] <= 1e-11, found)

    def test_points_come_and_go(self):
        X, y = data()
        queries = data(50, seed=1)[0]
        gp = process(normalize_y=False).fit(X[:500], y[:500])
        gp.partial_fit(X[500:], y[500:]).remove(np.arange(100))
        self.assertEqual(gp.hyperparameters_["iterations"], -1)
        np.testing.assert_array_equal(gp.predict(queries), process(normalize_y=False).fit(X[100:], y[100:]).predict(queries))

    def test_files_hold_the_weights(self):
        X, y = data(targets=1)
        gp = process(tolerance=1e-9).fit(X, y)
        gp.save("iterative.npz")
        self.assertEqual(np.load("iterative.npz")["alpha"].shape, (600,))
        for copy in (egosieve.GaussianProcess.load("iterative.npz"), pickle.loads(pickle.dumps(gp))):
            np.testing.assert_array_equal(copy.predict(X), gp.predict(X))
            self.assertEqual((copy.approximation, copy.tolerance, copy.inducing_points), ("iterative", 1e-9, 60))
            self.assertEqual(copy.hyperparameters_["iterations"], 0)
            with self.assertRaisesRegex(RuntimeError, "means alone"):
                copy.predict(X, return_std=True)

    def test_subset_is_optimised(self):
        X, y = data(targets=1)
        gp = process(kernel="squared_exponential", optimize=True, subset_size=200).fit(X, y)
        self.assertEqual(gp.optimization_["points"], 200)
        self.assertGreater(gp.score(X, y), 0.8)
        with self.assertRaisesRegex(ValueError, "subset_size = 0"):
            process(optimize=True, subset_size=0).fit(X, y)

    def test_what_does_not_converge_is_no_model(self):
        X, y = data(300, targets=1)
        X[150:] = X[:150]
        gp = process(kernel="squared_exponential", noise_stddev=1e-7, tolerance=1e-12, inducing_points=20, normalize_y=False)
        with self.assertRaisesRegex(RuntimeError, "reached a relative residual of .* iterations"):
            gp.fit(X, y)
        with self.assertRaises(RuntimeError):
            gp.predict(X)

    def test_what_needs_a_factor_is_refused(self):
        X, y = data(50, targets=1)
        gp = process(normalize_y=False).fit(X, np.sign(y))
        calls = [lambda: gp.predict(X, return_std=True), lambda: gp.predict(X, return_cov=True), lambda: gp.sample_y(X),
                 lambda: gp.sample_y(X, method="paths"), lambda: gp.predict_gradient(X, return_var=True), gp.leave_one_out,
                 gp.log_marginal_likelihood, lambda: gp.log_marginal_likelihood(eval_gradient=True)]  # fmt: skip
        for call in calls:
            with self.assertRaisesRegex(RuntimeError, "means alone"):
                call()
        self.assertFalse(hasattr(gp, "predict_proba"))
        with self.assertRaisesRegex(NotImplementedError, "zero mean"):
            process(mean="constant").fit(X, y)
        with self.assertRaisesRegex(ValueError, "tolerance is 2"):
            process(tolerance=2.0).fit(X, y)


if __name__ == "__main__":
    unittest.main()
