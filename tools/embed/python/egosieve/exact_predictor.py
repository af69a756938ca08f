"""What a model with its factor gives beyond the predictions of predictor.py, all in float64."""

import numpy as np

from . import arguments
from .predictor import Predictor


class ExactPredictor(Predictor):
    """Samples, gradients, left-out points and likelihoods of a model; `_new_model` gives one of the prior."""

    def covariance(self, X, Z=None, eval_gradient=False, eval_input_gradient=False):
        """The kernel matrix k(X, Z) in float64, without noise, at the hyperparameters found, or before fit those given.

        Parameters
        ----------
        X : array of shape (n, n_features)
        Z : array of shape (m, n_features); None: X
        eval_gradient, eval_input_gradient : bool
            Also return the derivatives.

        Returns
        -------
        K : array of shape (n, m)
        gradient : array of shape (n, m, n_scales + 1), by the logarithms of the scales and of sigma_f
        input_gradient : array of shape (n, m, n_features), by X; 0 at a cusp
        """
        X, Z = arguments.queries(self, X), None if Z is None else arguments.queries(self, Z, "Z")
        core = self._core if self._is_fitted() else self._new_model(X.shape[1])
        pairs, features = (len(X), len(X if Z is None else Z)), X.shape[1]
        scales = len(core.describe()["scales"])
        results = [np.empty(pairs), np.empty((*pairs, scales + 1)) if eval_gradient else None,
                   np.empty((*pairs, features)) if eval_input_gradient else None]  # fmt: skip
        core.call("covariances", X, Z, *(None if one is None else one.reshape(-1, one.shape[-1]) for one in results))
        wanted = tuple(one for one in results if one is not None)
        return wanted if len(wanted) > 1 else wanted[0]

    def enqueue_covariance(self, queue, X, n, K, Z=None, m=0, wait_for=()):
        """The kernel matrix k(X, Z) from and to OpenCL buffers on a command queue, without waiting.

        OpenCL objects are as for `freeze().enqueue` and belong to the model's context: `opencl_context`, or that of
        `freeze().opencl()`. All values are float64; inputs are not checked, NaN gives NaN.

        Parameters
        ----------
        queue : a cl_command_queue
        X : a cl_mem of n x n_features values, or (cl_mem, first element)
        K : a cl_mem for n x m results, or (cl_mem, first element)
        Z : a cl_mem of m x n_features values, or (cl_mem, first element); None: X
        wait_for : cl_events that come first

        Returns
        -------
        event : as of `freeze().enqueue`
        """
        if not self._is_fitted():
            raise arguments.not_fitted(self)
        queue = arguments.address("queue", queue)

        def matrix(name, value, rows):
            memory, first = value if isinstance(value, tuple) else (value, 0)
            return arguments.address(name, memory), first, rows

        x = matrix("X", X, n)
        z = x if Z is None else matrix("Z", Z, m)
        wait = [arguments.address("wait_for", event) for event in wait_for]
        return arguments.event(self._core.enqueue_covariances(x, z, matrix("K", K, n), queue, wait))

    def sample_y(self, X, n_samples=1, random_state=0, of_observation=None, *, method="joint", frequencies=1024):
        """Samples from the joint posterior of f at the rows of X; before fit, from the prior.

        Parameters
        ----------
        X : array of shape (n_queries, n_features)
        n_samples : int
        random_state : int, numpy.random.Generator or RandomState, or None
            The seed. The same gives the same samples, the first ones whatever their number.
        of_observation : bool
            Samples of y: the noise sigma_n^2 is added.
        method : "joint" or "paths"
            "joint" factorises the covariance of all queries: n_queries^3 / 3 flops. "paths" draws functions by Matheron's
            rule and random Fourier features: linear in n_queries, and a seed gives the same function whatever X is. Their
            mean and covariance are the posterior's. For "squared_exponential", the Matern functions, "constant", their
            sums and products.
        frequencies : int
            Of each function, with method="paths"; more make its distribution closer to the normal one.

        Returns
        -------
        samples : float64 array of shape (n_queries, n_samples) or (n_queries, n_targets, n_samples)
        """
        X = arguments.queries(self, X)
        if n_samples < 0:
            raise ValueError(f"n_samples = {n_samples}; it must not be negative")
        if self._is_fitted():
            core, offset, scale = self._core, self._offset, self._scale
        else:
            core, offset, scale = self._new_model(X.shape[1]), 0.0, 1.0
        if method not in ("joint", "paths"):
            raise ValueError(f'method = {method!r}; it must be "joint" or "paths"')
        samples = np.empty((len(X) * np.size(scale), n_samples))
        if n_samples:
            seed, noise = arguments.seed(random_state) % 2**64, self._with_noise(of_observation)
            if method == "joint":
                core.call("sample", X, seed, noise, samples, None)
            else:
                core.call("sample_paths", X, seed, frequencies, noise, samples)
        if np.ndim(scale):
            samples = samples.reshape(len(X), len(scale), n_samples)
            scale, offset = scale[:, None], offset[:, None]
        return samples * scale + offset

    def predict_gradient(self, X, return_var=False):
        """Gradients of mean and variance of f by the features, at the rows of X, in float64.

        Returns
        -------
        gradient : array of shape (n_queries, n_features) or (n_queries, n_targets, n_features), of the mean
        variance_gradient : array of shape (n_queries, n_features), only if return_var; with several targets
            (n_queries, n_targets, n_features)
        """
        core, X, scale = self._fitted(), arguments.queries(self, X), self._scale
        count = X.shape[1]
        mean = np.empty((len(X) * np.size(scale), count))
        variance = np.empty((len(X), count)) if return_var else None
        core.call("gradients", X, mean, variance)
        if np.ndim(scale):
            mean, scale = mean.reshape(len(X), len(scale), count), scale[:, None]
            variance = None if variance is None else variance[:, None, :]
        mean = mean * scale
        return mean if variance is None else (mean, variance * scale**2)

    def leave_one_out(self):
        """Each point's y predicted from all the other points, with the current hyperparameters.

        Returns
        -------
        mean : array of y's shape
        std : array of y's shape, of the observation y
        log_density : array of y's shape, log p(y_i | all others)
        """
        core = self._fitted()
        n = core.describe()["size"]
        mean, variance, log_density = np.empty(self._shape(n)), np.empty(n), np.empty(self._shape(n))
        core.call("leave_one_out", mean, variance, log_density)
        mean, std = self._denormalized(mean, variance, True, False)
        return mean, std, log_density - np.log(self._scale)

    def log_marginal_likelihood(self, theta=None, eval_gradient=False):
        """log p(y | X) of the points in the model; of normalised y where normalize_y is true.

        Parameters
        ----------
        theta : array, optional
            Logarithms of scales, sigma_f and sigma_n to take in place of the model's, which stay.
        eval_gradient : bool
            Also return the gradient by theta.
        """
        core = self._fitted()
        if theta is None and not eval_gradient:
            return core.call("log_marginal_likelihood")
        if theta is None:
            found = core.describe()
            theta = np.log([*found["scales"], found["signal_stddev"], found["noise_stddev"]])
        value, gradient = core.likelihood_at(np.ravel(theta).tolist(), eval_gradient)
        return (value, np.array(gradient)) if eval_gradient else value

    @property
    def log_marginal_likelihood_value_(self):
        """log_marginal_likelihood() of the model as it is now."""
        return self.log_marginal_likelihood()

    def _predict_joint(self, X, of_observation):
        mean, covariance = np.empty(self._shape(len(X))), np.empty((len(X), len(X)))
        self._core.call("predict_joint", X, of_observation, mean, covariance)
        if np.ndim(self._scale):
            covariance = covariance[:, :, None]
        return mean * self._scale + self._offset, covariance * self._scale**2
