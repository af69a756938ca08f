"""egosieve.GaussianProcess beyond marginal predictions: joint covariances, samples, several targets, noise by point,
mean functions, gradients and left-out points, against the textbook's formulas in NumPy."""

import os
import pickle
import unittest

import numpy as np

import egosieve

LENGTH, SIGNAL, NOISE = 0.6, 1.2, 0.3


def data(n=60, seed=0):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, 2))
    return X, np.stack([np.sin(3 * X[:, 0]) + X[:, 1], 40 - 5 * X[:, 1] * X[:, 0]], axis=1), random.uniform(0, 0.3, n)


def covariance(a, b):
    return SIGNAL**2 * np.exp(-0.5 * ((a[:, None] - b[None]) ** 2).sum(-1) / LENGTH**2)


def process(**parameters):
    return egosieve.GaussianProcess(
        "squared_exponential", scales=[LENGTH] * 2, signal_stddev=SIGNAL, noise_stddev=NOISE, optimize=False, **parameters
    )


class Posterior(unittest.TestCase):
    def setUp(self):
        self.X, self.y, self.alpha = data()
        self.queries = data(20, seed=1)[0]
        self.K = covariance(self.X, self.X) + np.diag(NOISE**2 + self.alpha)

    def test_joint_covariance_of_noisy_points(self):
        gp = process(alpha=self.alpha).fit(self.X, self.y[:, 0])
        cross = covariance(self.queries, self.X)
        mean, joint = gp.predict(self.queries, return_cov=True)
        np.testing.assert_allclose(mean, cross @ np.linalg.solve(self.K, self.y[:, 0]), atol=1e-11)
        expected = covariance(self.queries, self.queries) - cross @ np.linalg.solve(self.K, cross.T)
        np.testing.assert_allclose(joint, expected, atol=1e-12)
        of_y = gp.predict(self.queries, return_cov=True, of_observation=True)[1]
        np.testing.assert_allclose(of_y - joint, NOISE**2 * np.eye(20), atol=1e-14)
        wide, variance = gp.predict(self.queries, return_var=True, float64=True)
        np.testing.assert_allclose(wide, mean, atol=1e-13)
        np.testing.assert_allclose(variance, np.diag(joint), atol=1e-13)
        np.testing.assert_array_equal(gp.alpha_train_, self.alpha)
        gp.remove([3, 5])
        np.testing.assert_array_equal(gp.alpha_train_, np.delete(self.alpha, [3, 5]))
        gp.partial_fit(self.X[:1], self.y[:1, 0]).partial_fit(self.X[:1], self.y[:1, 0], alpha=0.5)
        np.testing.assert_array_equal(gp.alpha_train_[-2:], [0.0, 0.5])

    def test_paths_are_functions_about_the_mean(self):
        gp = process(alpha=self.alpha, normalize_y=True).fit(self.X, self.y)
        paths = gp.sample_y(self.queries, 2000, random_state=4, method="paths", frequencies=32)
        self.assertEqual(paths.shape, (20, 2, 2000))
        backwards = gp.sample_y(self.queries[::-1], 3, random_state=4, method="paths", frequencies=32)
        np.testing.assert_array_equal(paths[::-1, :, :3], backwards)
        # A mean of 2,000 values has their deviation over the root of 2,000; six of these.
        mean, std = gp.predict(self.queries, return_std=True)
        self.assertLess(np.abs((paths.mean(axis=2) - mean) / std).max(), 6 / np.sqrt(2000))
        sparse = process(approximation="fitc", inducing_points=10).fit(self.X, self.y[:, 0])
        self.assertEqual(sparse.sample_y(self.queries, 2, method="paths").shape, (20, 2))
        with self.assertRaisesRegex(NotImplementedError, "no frequencies are known of .arcsine."):
            egosieve.GaussianProcess("arcsine").sample_y(self.queries, method="paths")
        with self.assertRaisesRegex(ValueError, "method = 'path'"):
            gp.sample_y(self.queries, method="path")

    def test_several_targets(self):
        gp = process(normalize_y=True).fit(self.X, self.y)
        self.assertEqual(gp.y_train_.shape, (60, 2))
        np.testing.assert_allclose(gp.y_train_, self.y, rtol=1e-12)
        mean, std = gp.predict(self.queries, return_std=True)
        joint_mean, joint = gp.predict(self.queries, return_cov=True)
        samples = gp.sample_y(self.queries, 3, random_state=4)
        gradient, variance_gradient = gp.predict_gradient(self.queries, return_var=True)
        left_out = gp.leave_one_out()
        self.assertEqual(samples.shape, (20, 2, 3))
        self.assertEqual(joint.shape, (20, 20, 2))
        likelihoods = []
        for c in range(2):
            alone = process(normalize_y=True).fit(self.X, self.y[:, c])
            one_mean, one_std = alone.predict(self.queries, return_std=True)
            size = self.y[:, c].std()
            np.testing.assert_allclose(mean[:, c], one_mean, atol=1e-5 * size)  # float32 results
            np.testing.assert_allclose(std[:, c], one_std, rtol=1e-6)
            one_mean, one_joint = alone.predict(self.queries, return_cov=True)
            np.testing.assert_allclose(joint_mean[:, c], one_mean, atol=1e-11 * size)
            np.testing.assert_allclose(joint[:, :, c], one_joint, atol=1e-12 * size**2)
            np.testing.assert_allclose(gradient[:, c], alone.predict_gradient(self.queries), atol=1e-10 * size)
            for whole, one in zip(left_out, alone.leave_one_out()):
                np.testing.assert_allclose(whole[:, c], one, rtol=1e-9, atol=1e-10)
            likelihoods.append(alone.log_marginal_likelihood())
        self.assertEqual(variance_gradient.shape, (20, 2, 2))
        self.assertAlmostEqual(gp.log_marginal_likelihood(), sum(likelihoods), places=8)
        self.assertGreater(gp.score(self.X, self.y), 0.9)
        self.assertFalse(hasattr(gp, "predict_proba"))
        np.testing.assert_array_equal(gp.freeze().predict(self.queries), mean)
        with self.assertRaisesRegex(ValueError, r"y has shape \(1,\); the model has 2"):
            gp.partial_fit(self.X[:1], self.y[:1, 0])

    def test_axes_are_of_one_target(self):
        gp = process().fit(self.X, self.y)
        for x in (np.linspace(0, 1, 4), np.array([0.0, 0.1, 0.5])):
            for model in (gp, gp.freeze()):
                with self.assertRaisesRegex(RuntimeError, "a grid needs a model of one output; this one has 2"):
                    model.predict_axes(x, np.array([0.0, 1.0]))
        with self.assertRaisesRegex(ValueError, "not fitted"):
            process().predict_axes([0.0, 0.1, 0.5], [0.0])

    def test_normalisation_gives_results_in_the_units_of_y(self):
        y = self.y[:, 1]
        offset, size = y.mean(), y.std()
        gp, plain = process(normalize_y=True).fit(self.X, y), process().fit(self.X, (y - offset) / size)
        mean, joint = gp.predict(self.queries, return_cov=True)
        plain_mean, plain_joint = plain.predict(self.queries, return_cov=True)
        np.testing.assert_allclose(mean, plain_mean * size + offset, rtol=1e-12)
        np.testing.assert_allclose(joint, plain_joint * size**2, rtol=1e-12)
        samples = plain.sample_y(self.queries, 3) * size + offset
        np.testing.assert_allclose(gp.sample_y(self.queries, 3), samples, rtol=1e-12)
        gradients = zip(gp.predict_gradient(self.queries, True), plain.predict_gradient(self.queries, True), (1, 2))
        for ours, expected, power in gradients:
            np.testing.assert_allclose(ours, expected * size**power, rtol=1e-12)
        mean, std, log_density = gp.leave_one_out()
        plain_mean, plain_std, plain_density = plain.leave_one_out()
        np.testing.assert_allclose(mean, plain_mean * size + offset, rtol=1e-12)
        np.testing.assert_allclose(std, plain_std * size, rtol=1e-12)
        # A density of y, not of its normalised values.
        np.testing.assert_allclose(log_density, plain_density - np.log(size), rtol=1e-12)

    def test_samples(self):
        gp = process().fit(self.X, self.y[:, 0])
        samples = gp.sample_y(self.queries[:3], 20000, random_state=1)
        mean, joint = gp.predict(self.queries[:3], return_cov=True)
        # Six deviations of the estimates.
        self.assertTrue((np.abs(samples.mean(axis=1) - mean) < 6 * np.sqrt(np.diag(joint) / 20000)).all())
        bound = 6 * np.sqrt((np.outer(np.diag(joint), np.diag(joint)) + joint**2) / 20000)
        self.assertTrue((np.abs(np.cov(samples) - joint) < bound).all())
        np.testing.assert_array_equal(gp.sample_y(self.queries[:3], 7, random_state=1), samples[:, :7])
        self.assertEqual(gp.sample_y(self.queries[:3], 0).shape, (3, 0))
        self.assertTrue((gp.sample_y(self.queries[:3], 7, random_state=2) != samples[:, :7]).any())
        generator = np.random.default_rng(0)
        a, b = (gp.sample_y(self.queries[:3], 1, random_state=generator) for _ in range(2))
        self.assertTrue((a != b).any())
        prior = process().sample_y(self.queries[:3], 20000)
        np.testing.assert_allclose(np.cov(prior), covariance(self.queries[:3], self.queries[:3]), atol=0.1)
        of_y = gp.sample_y(self.queries[:3], 20000, of_observation=True)
        self.assertTrue((np.abs(np.cov(of_y) - joint - NOISE**2 * np.eye(3)) < 2 * bound).all())

    def test_mean_functions(self):
        for mean, basis in (
            ("constant", np.ones((len(self.X), 1))),
            ("linear", np.hstack([np.ones((len(self.X), 1)), self.X])),
        ):
            gp = process(mean=mean, alpha=self.alpha).fit(self.X, self.y[:, 1])
            weighted = np.linalg.solve(self.K, basis)
            np.testing.assert_allclose(gp.coef_, np.linalg.solve(basis.T @ weighted, weighted.T @ self.y[:, 1]), rtol=1e-9)
        with self.assertRaisesRegex(RuntimeError, "do not determine"):
            process(mean="linear").fit(self.X[:2], self.y[:2, 0]).predict(self.queries)
        with self.assertRaisesRegex(RuntimeError, "do not determine"):
            process(mean="constant").sample_y(self.queries)

    def test_gradients_and_likelihoods_are_finite_differences(self):
        gp = process(mean="linear").fit(self.X, self.y[:, 0])
        gradient, variance_gradient = gp.predict_gradient(self.queries, return_var=True)
        for d in range(2):
            step = 1e-5 * np.eye(2)[d]
            ahead = gp.predict(self.queries + step, return_var=True, float64=True)
            behind = gp.predict(self.queries - step, return_var=True, float64=True)
            np.testing.assert_allclose(gradient[:, d], (ahead[0] - behind[0]) / 2e-5, atol=1e-6)
            np.testing.assert_allclose(variance_gradient[:, d], (ahead[1] - behind[1]) / 2e-5, atol=1e-6)
        theta = np.log([LENGTH, LENGTH, SIGNAL, NOISE])
        value, slope = gp.log_marginal_likelihood(eval_gradient=True)
        self.assertAlmostEqual(value, gp.log_marginal_likelihood(), places=9)
        self.assertAlmostEqual(value, gp.log_marginal_likelihood(theta), places=9)
        for t in range(4):
            step = 1e-5 * np.eye(4)[t]
            difference = gp.log_marginal_likelihood(theta + step) - gp.log_marginal_likelihood(theta - step)
            self.assertAlmostEqual(slope[t], difference / 2e-5, delta=1e-5 * abs(value))

    def test_files_and_copies_hold_everything(self):
        gp = process(alpha=self.alpha, mean="linear", normalize_y=True).fit(self.X, self.y)
        path = os.path.join(os.getcwd(), "joint.npz")
        gp.save(path)
        expected = gp.predict(self.queries, return_cov=True)
        for twin in (egosieve.GaussianProcess.load(path), pickle.loads(pickle.dumps(gp))):
            found = twin.predict(self.queries, return_cov=True)
            np.testing.assert_array_equal(found[0], expected[0])
            np.testing.assert_array_equal(found[1], expected[1])
            np.testing.assert_array_equal(twin.alpha_train_, self.alpha)
            self.assertEqual(twin.mean, "linear")

    def test_many_features_and_any_covariance(self):
        random = np.random.default_rng(2)
        X = random.uniform(-1, 1, (50, 100))
        y = X[:, 0] + np.sin(X[:, 1])
        gp = egosieve.GaussianProcess("isotropic(matern52) + isotropic(linear)", noise_stddev=0.2).fit(X, y)
        self.assertEqual(gp.hyperparameters_["kernel"], "isotropic(matern52) + isotropic(linear)")
        self.assertEqual(len(gp.hyperparameters_["scales"]), 3)
        self.assertGreater(gp.score(X, y), 0.9)

    def test_bad_arguments(self):
        gp = process().fit(self.X, self.y[:, 0])
        cases = [
            (ValueError, "alpha must be a scalar or an array with same number", lambda: process(alpha=[0.1]).fit(self.X, self.y)),
            (ValueError, "alpha holds -1", lambda: process(alpha=-1).fit(self.X, self.y)),
            (ValueError, "mean = 'cubic'", lambda: process(mean="cubic").fit(self.X, self.y)),
            (RuntimeError, "At most one of return_std or return_cov", lambda: gp.predict(self.X, True, True)),
            (RuntimeError, "return_cov needs the model", lambda: gp.freeze().predict(self.X, return_cov=True)),
            (ValueError, "precision = 'half'", lambda: gp.freeze().predict(self.X, precision="half")),
            (ValueError, "n_samples = -1", lambda: gp.sample_y(self.X, -1)),
            (ValueError, "theta has 4 values", lambda: gp.log_marginal_likelihood([0.0])),
            (ValueError, "X has 1 features", lambda: gp.sample_y(self.X[:, :1])),
            (ValueError, "X has 1 features", lambda: gp.predict_gradient(self.X[:, :1])),
            (ValueError, "kernel: 7 has no counterpart", lambda: egosieve.GaussianProcess(7).fit(self.X, self.y)),
        ]
        for kind, words, call in cases:
            with self.subTest(words):
                with self.assertRaisesRegex(kind, words):
                    call()


if __name__ == "__main__":
    unittest.main()
