"""Classification of any labels by Gaussian processes."""

import inspect

import numpy as np

from . import arguments, kernels
from ._library import choice
from .estimator import Classifier
from .gaussian_process import GaussianProcess

# Of a regression.
_LEFT_OUT = ("alpha", "mean", "approximation", "inducing_points", "tolerance", "normalize_y")
_KERNEL = "isotropic(squared_exponential)"


class GaussianProcessClassifier(Classifier):
    """Classes by Gaussian processes, one class against the rest where there are more than two.

    Each class has hyperparameters of its own. Probabilities of several classes are scaled to the sum 1. pickle saves a
    classifier; models_[0].save(path) writes one of its models for C, C++ and GaussianProcess.load.

    Parameters
    ----------
    kernel : str, or a kernel of scikit-learn's
        As in GaussianProcess; the default has one length for all features.
    likelihood : "laplace" or "least_squares"
        "laplace": the probit likelihood with Laplace's approximation (Rasmussen & Williams, section 3.4), as
        scikit-learn has it with the logistic one. "least_squares": regression on the labels -1 and +1, then
        GaussianProcess.predict_proba (section 6.5), with sharper probabilities of many classes and without weights.
    noise_stddev : float
        Of "least_squares", where `optimize` is true its start.
    others
        As in GaussianProcess.

    Attributes
    ----------
    classes_ : array of shape (n_classes,), sorted
    n_features_in_ : int
    models_ : list of GaussianProcess of the latent f, one for two classes, else one per class

    Examples
    --------
    >>> import numpy as np, egosieve
    >>> X = np.random.default_rng(0).normal(size=(100, 2))
    >>> classifier = egosieve.GaussianProcessClassifier().fit(X, np.where(X[:, 0] > 0, "right", "left"))
    >>> classifier.predict([[1.0, 0.0]])
    array(['right'], dtype='<U5')
    """

    def __init__(self, kernel=_KERNEL, **parameters):
        given = inspect.signature(type(self)).bind(kernel, **parameters)
        given.apply_defaults()
        self.__dict__.update(given.arguments)

    def fit(self, X, y, sample_weight=None):
        """Starts anew.

        Parameters
        ----------
        X : array of shape (n_samples, n_features)
        y : n_samples labels of one kind that can be sorted, at least two different
        sample_weight : n_samples weights, optional
            A row of weight 2 counts as two rows, one of weight 0 is left out. At most 1e6.
        """
        names, X = arguments.feature_names(X), arguments.matrix("X", X)
        y, weights = arguments.labels("y", y, len(X)), None
        if sample_weight is not None:
            weights = arguments.variances("sample_weight", sample_weight, len(X))
            if weights is None:
                raise ValueError("every sample_weight is zero: at least two classes need a row")
            used = weights > 0.0
            X, y, weights = X[used], y[used], weights[used]
        classes, members = np.unique(y, return_inverse=True)
        if len(classes) < 2:
            raise ValueError(f"y holds {len(classes)} class, {classes[0]!r}; the classifier needs at least two")
        laplace = choice("likelihood", self.likelihood, ("laplace", "least_squares")) == 0
        if laplace and not isinstance(self.kernel, str) and kernels.has_noise(self.kernel):
            raise ValueError("kernel: a WhiteKernel is noise of the latent function, which likelihood='laplace' has not")
        if weights is not None and not laplace and np.any(weights != 1.0):
            raise ValueError("sample_weight: weights other than 0 and 1 need likelihood='laplace'")
        if laplace:
            X, members, weights = _distinct(X, members, weights)
        parameters = self.get_params(deep=False)
        del parameters["likelihood"]
        self.models_ = []
        for c in [1] if len(classes) == 2 else range(len(classes)):
            model, labels = GaussianProcess(**parameters), np.where(members == c, 1.0, -1.0)
            self.models_.append(model._fit_labels(X, labels, weights) if laplace else model.fit(X, labels))
        self.classes_ = classes
        self._take_features(X.shape[1], names)
        return self

    def predict_proba(self, X):
        """Probabilities of the classes in the order of classes_, of shape (n_queries, n_classes)."""
        if not self._is_fitted():
            raise arguments.not_fitted(self)
        X = arguments.queries(self, X)
        if len(self.models_) == 1:
            return self.models_[0].predict_proba(X)
        of_each = np.stack([model.predict_proba(X)[:, 1] for model in self.models_], axis=1)
        of_each = np.maximum(of_each, np.finfo(of_each.dtype).tiny)
        return of_each / of_each.sum(axis=1, keepdims=True)

    def predict(self, X):
        """The most probable class at each row of X."""
        probabilities = self.predict_proba(X)
        return self.classes_[np.argmax(probabilities, axis=1)]

    @property
    def kernel_(self):
        """The kernel with the hyperparameters found: a list with one per class where there are more than two."""
        if not self._is_fitted():
            raise AttributeError("kernel_: the classifier is not fitted")
        found = [model.kernel_ for model in self.models_]
        return found[0] if len(found) == 1 else found

    @property
    def log_marginal_likelihood_value_(self):
        """Laplace's approximation of log p(y | X), the mean over models_, of the points that the optimisation used."""
        if not self._is_fitted() or self.likelihood != "laplace":
            raise AttributeError("log_marginal_likelihood_value_ is there after a fit with likelihood='laplace'")
        return float(np.mean([model.optimization_["log_likelihood"] for model in self.models_]))

    def _is_fitted(self):
        return hasattr(self, "models_")


def _distinct(X, members, weights):
    """The different rows of one class each, sorted, with the sums of their weights: the order of rows is no matter."""
    rows, places = np.unique(np.column_stack([X, members]), axis=0, return_inverse=True)
    return np.ascontiguousarray(rows[:, :-1]), rows[:, -1], np.bincount(places.ravel(), weights).astype(np.float64)


def _signature():
    parameters = inspect.signature(GaussianProcess.__init__).parameters
    kept = [parameter for name, parameter in parameters.items() if name not in _LEFT_OUT]
    kept[1] = kept[1].replace(default=_KERNEL)
    kept.insert(2, inspect.Parameter("likelihood", inspect.Parameter.KEYWORD_ONLY, default="laplace"))
    return inspect.Signature(kept)


# What scikit-learn reads the parameters' names from.
GaussianProcessClassifier.__init__.__signature__ = _signature()
