"""Sparse models of egosieve.GaussianProcess: all calls take them; their formulas are tested of gp/model."""

import pickle
import unittest

import egosieve
import numpy as np

LENGTH, NOISE = 0.7, 0.2


def data(n=200, seed=0):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, 2))
    return X, np.sin(3 * X[:, 0]) * X[:, 1] + random.normal(0, NOISE, n)


def sparse(approximation, m, **options):
    return egosieve.GaussianProcess("squared_exponential", scales=[LENGTH] * 2, noise_stddev=NOISE,
                                    approximation=approximation, inducing_points=m, optimize=False, **options)  # fmt: skip


class Sparse(unittest.TestCase):
    def test_predictions_agree(self):
        X, y = data()
        queries = data(30, seed=1)[0]
        for approximation in ("dtc", "fitc"):
            gp = sparse(approximation, 15).fit(X, y)
            self.assertEqual(gp.hyperparameters_["inducing_count"], 15)
            mean, variance = gp.predict(queries, return_var=True, float64=True)
            joint_mean, joint = gp.predict(queries, return_cov=True)
            on_device = gp.predict(queries, return_var=True)
            np.testing.assert_allclose(joint_mean, mean, atol=1e-10)
            np.testing.assert_allclose(np.diag(joint), variance, atol=1e-10)
            np.testing.assert_allclose(on_device[0], mean, atol=1e-4)
            np.testing.assert_allclose(on_device[1], variance, atol=1e-4)
            # Of a model whose covariance is Q + Lambda: mean and variance of Q's process plus what Q misses.
            samples = gp.sample_y(queries[:3], n_samples=20000)
            np.testing.assert_allclose(np.cov(samples), joint[:3, :3], atol=0.02 * joint[:3, :3].max() + 1e-3)

    def test_gradient_of_the_bound(self):
        X, y = data()
        gp = sparse("dtc", 20).fit(X, y)
        theta = np.log([LENGTH, LENGTH, 1.0, NOISE])
        value, gradient = gp.log_marginal_likelihood(theta, eval_gradient=True)
        self.assertAlmostEqual(value, gp.log_marginal_likelihood(), places=6)
        for t in range(4):
            step = 1e-5 * np.eye(4)[t]
            ahead, behind = gp.log_marginal_likelihood(theta + step), gp.log_marginal_likelihood(theta - step)
            self.assertAlmostEqual(gradient[t], (ahead - behind) / 2e-5, delta=1e-4 * max(1, abs(gradient[t])))

    def test_training_and_updates(self):
        X, y = data(400)
        for approximation in ("dtc", "fitc"):
            gp = egosieve.GaussianProcess("squared_exponential", approximation=approximation, inducing_points=30).fit(X, y)
            self.assertGreater(gp.optimization_["log_likelihood"], gp.optimization_["log_likelihood_at_start"])
            queries = data(100, seed=3)[0]
            truth = np.sin(3 * queries[:, 0]) * queries[:, 1]
            self.assertLess(np.sqrt(np.mean((gp.predict(queries) - truth) ** 2)), 0.5 * NOISE)
            before = gp.predict(queries)
            gp.partial_fit(X[:50] + 2, y[:50]).remove(np.arange(400, 450))
            self.assertEqual(gp.X_train_.shape, (400, 2))
            self.assertLess(np.abs(gp.predict(queries) - before).max(), NOISE)
            mean, std, log_density = gp.leave_one_out()
            self.assertLess(np.sqrt(np.mean((mean - y) ** 2)), 1.5 * NOISE)

    def test_labels_and_files(self):
        X, y = data(150)
        gp = sparse("fitc", 25).fit(X, np.sign(y))
        probabilities = gp.predict_proba(X)
        self.assertGreater(((probabilities[:, 1] > 0.5) == (y > 0)).mean(), 0.8)
        copy = pickle.loads(pickle.dumps(gp))
        self.assertEqual(copy.hyperparameters_["approximation"], "fitc")
        np.testing.assert_array_equal(copy.predict(X), gp.predict(X))
        gp.save("sparse.npz")
        loaded = egosieve.GaussianProcess.load("sparse.npz")
        self.assertEqual((loaded.approximation, loaded.inducing_points), ("fitc", 25))
        np.testing.assert_array_equal(loaded.predict(X), gp.predict(X))

    def test_what_it_does_not_have_is_refused(self):
        X, y = data(20)
        with self.assertRaisesRegex(ValueError, "approximation = 'sor'"):
            sparse("sor", 5).fit(X, y)
        with self.assertRaisesRegex(ValueError, "inducing_points"):
            sparse("dtc", 0).fit(X, y)
        with self.assertRaisesRegex(ValueError, "make a model for each"):
            sparse("dtc", 5).fit(X, np.stack([y, y], axis=1))
        with self.assertRaisesRegex(RuntimeError, "zero mean"):
            sparse("dtc", 5, mean="constant").fit(X, y)


if __name__ == "__main__":
    unittest.main()
