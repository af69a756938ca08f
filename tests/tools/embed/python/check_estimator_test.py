"""scikit-learn's own checks of egosieve.GaussianProcess; the one that does not apply is in its _more_tags."""

import unittest
import warnings

import egosieve
from sklearn.base import clone
from sklearn.exceptions import SkipTestWarning
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import check_estimator


class CheckEstimator(unittest.TestCase):
    def test_every_check_that_applies(self):
        skipped, passed, failed = [], 0, []
        for estimator, check in check_estimator(egosieve.GaussianProcess(), generate_only=True):
            name = getattr(getattr(check, "func", check), "__name__", str(check))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    check(estimator)
                    passed += 1
                except unittest.SkipTest as reason:
                    skipped.append((name, str(reason)))
                except Exception as error:  # all failures in one report
                    failed.append(f"{name}: {type(error).__name__}: {error}")
        print(f"{passed} checks passed, skipped: {skipped}")
        self.assertEqual(failed, [])
        self.assertGreater(passed, 30)
        for name, reason in skipped:
            self.assertTrue(name == "check_dtype_object" or "pandas is not installed" in reason, (name, reason))

    def test_works_in_pipelines_and_searches(self):
        import numpy as np

        X = np.random.default_rng(0).uniform(-1, 1, (90, 2))
        y = X[:, 0] * X[:, 1]
        model = make_pipeline(StandardScaler(), clone(egosieve.GaussianProcess(noise_stddev=0.05)))
        self.assertGreater(cross_val_score(model, X, y, cv=3).min(), 0.9)


if __name__ == "__main__":
    warnings.simplefilter("ignore", SkipTestWarning)
    unittest.main()
