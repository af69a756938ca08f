"""What scikit-learn and its users ask of any regressor."""

import inspect

import numpy as np

from . import arguments


class Estimator:
    """Parameters of the constructor by name, score and tags; `_is_fitted` tells whether fit was called."""

    _estimator_type = "regressor"

    def get_params(self, deep=True):
        """The parameters of the constructor by name."""
        return {name: getattr(self, name) for name in self._parameter_names()}

    def set_params(self, **params):
        """Sets parameters of the constructor; they hold from the next fit on."""
        names = self._parameter_names()
        for name in params:
            if name not in names:
                raise ValueError(f"Invalid parameter '{name}' for {type(self).__name__}. Valid parameters are: {names}.")
        for name, value in params.items():
            setattr(self, name, value)
        return self

    def score(self, X, y):
        """Coefficient of determination, 1 - sum (y - mean)^2 / sum (y - average y)^2, the mean over targets."""
        mean = self.predict(X)
        y = arguments.targets("y", y, len(mean))
        residual = np.atleast_1d(((y - mean) ** 2).sum(axis=0, dtype=np.float64))
        total = np.atleast_1d(((y - y.mean(axis=0, dtype=np.float64)) ** 2).sum(axis=0, dtype=np.float64))
        explained = 1.0 - residual / np.where(total > 0.0, total, 1.0)
        return float(np.where(total > 0.0, explained, residual == 0.0).mean())

    def __sklearn_is_fitted__(self):
        return self._is_fitted()

    def __repr__(self):
        defaults = {name: p.default for name, p in inspect.signature(type(self)).parameters.items()}
        changed = [f"{name}={value!r}" for name, value in self.get_params().items() if value is not defaults[name]]
        return f"{type(self).__name__}({', '.join(changed)})"

    def _more_tags(self):
        """What scikit-learn's check_estimator should know."""
        return {
            "requires_y": True,
            "multioutput": True,
            "preserves_dtype": [np.float64, np.float32],
        }

    def __sklearn_tags__(self):
        """The same for scikit-learn 1.6 and later."""
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, multi_output=True),
            transformer_tags=None,
            classifier_tags=None,
            regressor_tags=RegressorTags(),
            input_tags=InputTags(),
        )

    @classmethod
    def _parameter_names(cls):
        return sorted(name for name in inspect.signature(cls).parameters)
