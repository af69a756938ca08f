"""The optimisation of hyperparameters: laws that hold whatever the data's units, and bounds."""

import os
import signal
import threading
import time
import unittest

import numpy as np

import egosieve


def wave(n=60, seed=0):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, 1))
    return X, np.sin(4 * X[:, 0]) + 0.1 * random.normal(size=n)


class Optimization(unittest.TestCase):
    def test_units_of_y_change_nothing_else(self):
        X, y = wave()
        for kernel in ("squared_exponential", "matern52", "arcsine"):
            results = [egosieve.GaussianProcess(kernel).fit(X, unit * y) for unit in (1.0, 1e4, 1e-4)]
            for unit, gp in zip((1.0, 1e4, 1e-4), results):
                with self.subTest(kernel=kernel, unit=unit):
                    expected = results[0].optimization_["log_likelihood"] - len(y) * np.log(unit)
                    self.assertAlmostEqual(gp.optimization_["log_likelihood"], expected, delta=1e-3)
                    self.assertTrue(gp.optimization_["converged"])
                    self.assertLessEqual(gp.optimization_["gradient_norm"], 1e-3)
                    self.assertAlmostEqual(gp.hyperparameters_["signal_stddev"] / unit,
                                           results[0].hyperparameters_["signal_stddev"], delta=1e-2)  # fmt: skip

    def test_the_optimum_is_a_maximum(self):
        X, y = wave()
        gp = egosieve.GaussianProcess("matern52").fit(X, y)
        best = gp.log_marginal_likelihood()
        for factor in (0.97, 1.03):
            for name in ("scales", "signal_stddev", "noise_stddev"):
                moved = {key: gp.hyperparameters_[key] for key in ("scales", "signal_stddev", "noise_stddev")}
                moved[name] = np.multiply(moved[name], factor)
                other = egosieve.GaussianProcess("matern52", optimize=False, **moved).fit(X, y)
                self.assertLess(other.log_marginal_likelihood(), best)

    def test_restarts_are_never_worse_and_find_a_narrow_optimum(self):
        X = np.linspace(0, 1, 80)[:, None]
        y = np.sin(2 * np.pi * 9.0 * X[:, 0]) + 0.1 * np.random.default_rng(0).normal(size=80)
        once = egosieve.GaussianProcess("periodic", scales=[1.0, 0.8]).fit(X, y).optimization_
        often = egosieve.GaussianProcess("periodic", scales=[1.0, 0.8], n_restarts_optimizer=12).fit(X, y).optimization_
        self.assertGreaterEqual(often["log_likelihood"], once["log_likelihood"] - 1e-6)
        self.assertGreater(often["log_likelihood"], 20.0)  # noise alone explains -115, the period 50

    def test_bounds_hold(self):
        X, y = wave()
        bounds = {"scales": "fixed", "signal_stddev": (None, 0.5), "noise_stddev": (0.3, None)}
        gp = egosieve.GaussianProcess("squared_exponential", scales=[0.7], signal_stddev=0.4, noise_stddev=0.35,
                                      bounds=bounds).fit(X, y)  # fmt: skip
        found = gp.hyperparameters_
        self.assertAlmostEqual(found["scales"][0], 0.7, delta=1e-12)
        self.assertAlmostEqual(found["signal_stddev"], 0.5, delta=1e-12)
        self.assertAlmostEqual(found["noise_stddev"], 0.3, delta=1e-9)  # and 1e-10 sigma_f^2
        self.assertEqual(gp.optimization_["on_bound"], {"signal_stddev": "upper", "noise_stddev": "lower"})
        for wrong in ({"scales": [(1, 2), (1, 2)]}, {"noise": (1, 2)}, {"scales": "free"}, {"scales": (2, 1)}):
            with self.assertRaises(ValueError):
                egosieve.GaussianProcess("squared_exponential", bounds=wrong).fit(X, y)

    def test_data_without_noise_are_fitted(self):
        X = np.linspace(0, 1, 20)[:, None]
        gp = egosieve.GaussianProcess("squared_exponential", noise_stddev=1e-8).fit(X, np.sin(6 * X[:, 0]))
        self.assertGreater(gp.optimization_["log_likelihood"], gp.optimization_["log_likelihood_at_start"])
        self.assertNotEqual(gp.hyperparameters_["scales"][0], 0.5)
        deviations = gp.predict(np.linspace(0, 1, 200)[:, None], return_std=True, precision="float64")[1]
        self.assertGreater(deviations.min(), 0.0)

    def test_columns_start_from_their_own_spread(self):
        x = np.random.default_rng(5).uniform(-1, 1, (60, 2)) * [300.0, 0.01]
        y = np.sin(400 * x[:, 1])
        alone = egosieve.GaussianProcess("isotropic(matern52)").fit(x[:, 1:], y)
        of_two = egosieve.GaussianProcess("isotropic(matern52)[1]").fit(x, y)
        np.testing.assert_array_equal(of_two.hyperparameters_["scales"], alone.hyperparameters_["scales"])
        with self.assertRaisesRegex(ValueError, "column 2; there are 2 inputs"):
            egosieve.GaussianProcess("matern52[2]").fit(x, y)

    def test_inducing_inputs_follow_the_scales(self):
        X = 13.4 + 0.001 * np.random.default_rng(0).uniform(size=(400, 1))
        y = np.sin(8000 * (X[:, 0] - 13.4)) + 0.1 * np.random.default_rng(1).normal(size=400)
        for approximation in ("dtc", "fitc"):
            gp = egosieve.GaussianProcess("squared_exponential", approximation=approximation, inducing_points=40)
            self.assertGreater(gp.fit(X, y).score(X, y), 0.9)

    def test_ctrl_c_ends_a_fit(self):
        X = np.random.default_rng(0).uniform(-1, 1, (800, 20))
        y = np.random.default_rng(1).normal(size=800)
        gp = egosieve.GaussianProcess("arcsine", n_restarts_optimizer=1000)

        def interrupt():
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=interrupt).start()  # the fit itself would take an hour
        with self.assertRaises(KeyboardInterrupt):
            gp.fit(X, y)
        self.assertEqual(signal.getsignal(signal.SIGINT), signal.default_int_handler)
        self.assertFalse(hasattr(gp, "optimization_"))


if __name__ == "__main__":
    unittest.main()
