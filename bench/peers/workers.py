"""One library's side of peers.py: workers.py NAME POINTS QUERIES, then a task a line on stdin, a JSON answer a line.

    prepare   imports, fits (hyperparameters are given), compares with float64: errors, versions
    predict   mean and variance of f at all queries (at 256 where these alone take over 4 s): seconds a query
    replace   64 new points, the 64 oldest gone, then mean and variance at 256 queries: seconds
    append    64 new points, then mean and variance at 256 queries: seconds; they are dropped again untimed
    joint     mean and joint covariance of f at all queries: seconds
    samples   1,000 samples of f at all queries, the covariance among what is timed: seconds
    finish    memory

The models are one and the same: squared exponential with lengths LENGTH, or the arcsine with weights WEIGHT, sigma_f = 1,
sigma_n = NOISE, on points and labels of a smooth boundary.
"""

import json
import math
import sys
import time

import numpy as np

DIMENSION, UPDATE, FEW, SAMPLES = 6, 64, 256, 1000
SLOW = 4.0  # seconds for FEW queries
LENGTH, WEIGHT, NOISE = 0.8, 1.5, 0.3


def make_data(points, queries):
    """Inputs and targets of the model, of 64 updates, and the queries."""
    random = np.random.default_rng(11)
    X = random.uniform(-1, 1, (points + 64 * UPDATE, DIMENSION))
    y = np.tanh(3 * np.sin(2 * X[:, 0]) * X[:, 1] + X[:, 2]) + random.normal(0, NOISE, len(X))
    return X, y, random.uniform(-1, 1, (queries, DIMENSION))


def covariance_matrix(arcsine, a, b):
    """In float64, by the formulas."""
    if not arcsine:
        squares = (a**2).sum(1)[:, None] + (b**2).sum(1)[None] - 2 * a @ b.T
        return np.exp(-0.5 * np.maximum(squares, 0) / LENGTH**2)
    norms = [1 + 2 * WEIGHT**2 * (1 + (x**2).sum(1)) for x in (a, b)]
    return np.arcsin(2 * WEIGHT**2 * (1 + a @ b.T) / np.sqrt(norms[0][:, None] * norms[1][None]))


def float64_posterior(arcsine, X, y, queries):
    """Mean and joint covariance of f, the measure of all errors."""
    from scipy.linalg import cho_factor, cho_solve, solve_triangular

    factor = cho_factor(covariance_matrix(arcsine, X, X) + NOISE**2 * np.eye(len(X)), lower=True)
    cross = covariance_matrix(arcsine, X, queries)
    half = solve_triangular(factor[0], cross, lower=True)
    return cross.T @ cho_solve(factor, y), covariance_matrix(arcsine, queries, queries) - half.T @ half


class Egosieve:
    """This library, float32 on its device."""

    precision = "float32"
    kernel, arcsine = "squared_exponential", False

    def __init__(self):
        import egosieve

        self.module = egosieve
        self.version = egosieve.__version__

    def fit(self, X, y):
        scales = [WEIGHT] * (DIMENSION + 1) if self.arcsine else [LENGTH] * DIMENSION
        self.gp = self.module.GaussianProcess(self.kernel, scales=scales, noise_stddev=NOISE, optimize=False).fit(X, y)

    def predict(self, queries):
        return self.gp.predict(queries.astype(np.float32), return_var=True)

    def joint(self, queries):
        return self.gp.predict(queries, return_cov=True)

    def samples(self, queries):
        return self.gp.sample_y(queries, SAMPLES)

    def replace(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y).remove(np.arange(UPDATE))
        return self

    def append(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y)
        return self

    def undo_append(self, count):
        self.gp.remove(np.arange(count, count + UPDATE))


class EgosieveArcsine(Egosieve):
    """The same with the neural network covariance."""

    kernel, arcsine = "arcsine", True


class Refitted:
    """Libraries without updates: the model is fitted anew."""

    arcsine = False
    precision = "float64"

    def replace(self, X, y, new_X, new_y):
        self.fit(np.vstack([X[UPDATE:], new_X]), np.concatenate([y[UPDATE:], new_y]))
        return self

    def append(self, X, y, new_X, new_y):
        self.fit(np.vstack([X, new_X]), np.concatenate([y, new_y]))
        return self

    def undo_append(self, count):
        pass


class ScikitLearn(Refitted):
    """GaussianProcessRegressor."""

    def __init__(self):
        import sklearn
        from sklearn.gaussian_process import GaussianProcessRegressor, kernels

        self.version = sklearn.__version__
        self.new = lambda: GaussianProcessRegressor(kernels.RBF(LENGTH), alpha=NOISE**2, optimizer=None)

    def fit(self, X, y):
        self.gp = self.new().fit(X, y)

    def predict(self, queries):
        mean, std = self.gp.predict(queries, return_std=True)
        return mean, std**2

    def joint(self, queries):
        return self.gp.predict(queries, return_cov=True)

    def samples(self, queries):
        return self.gp.sample_y(queries, SAMPLES)


class GPyTorchExact(Refitted):
    """ExactGP in float32, by Cholesky."""

    precision = "float32"
    fast = False

    def __init__(self):
        import gpytorch
        import torch

        torch.set_num_threads(2)
        self.torch, self.gpytorch = torch, gpytorch
        self.version = f"{gpytorch.__version__} (torch {torch.__version__})"

        class Model(gpytorch.models.ExactGP):
            def __init__(self, X, y, likelihood):
                super().__init__(X, y, likelihood)
                self.mean_module = gpytorch.means.ZeroMean()
                self.covar_module = gpytorch.kernels.RBFKernel()
                self.covar_module.lengthscale = LENGTH

            def forward(self, x):
                return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

        self.Model = Model

    def tensor(self, array):
        return self.torch.as_tensor(array, dtype=self.torch.float32)

    def fit(self, X, y):
        likelihood = self.gpytorch.likelihoods.GaussianLikelihood()
        likelihood.noise = NOISE**2
        self.gp = self.Model(self.tensor(X), self.tensor(y), likelihood).eval()
        likelihood.eval()

    def predict(self, queries):
        settings = self.gpytorch.settings
        with self.torch.no_grad(), settings.fast_pred_var(self.fast), settings.max_cholesky_size(10**6):
            posterior = self.gp(self.tensor(queries))
            return posterior.mean.numpy(), posterior.variance.numpy()

    def joint(self, queries):
        with self.torch.no_grad(), self.gpytorch.settings.max_cholesky_size(10**6):
            posterior = self.gp(self.tensor(queries))
            return posterior.mean.numpy(), posterior.covariance_matrix.numpy()

    def samples(self, queries):
        with self.torch.no_grad(), self.gpytorch.settings.max_cholesky_size(10**6):
            return self.gp(self.tensor(queries)).sample(self.torch.Size([SAMPLES])).numpy()


class GPyTorchFast(GPyTorchExact):
    """The same with fast_pred_var (LOVE), and updates by fantasy models where points only arrive."""

    fast = True

    def append(self, X, y, new_X, new_y):
        settings = self.gpytorch.settings
        grown = GPyTorchFast.__new__(GPyTorchFast)
        grown.__dict__.update(self.__dict__)
        with self.torch.no_grad(), settings.fast_pred_var(True), settings.max_cholesky_size(10**6):
            grown.gp = self.gp.get_fantasy_model(self.tensor(new_X), self.tensor(new_y))
        return grown


class GPy(Refitted):
    """GPRegression with the squared exponential."""

    def __init__(self):
        import GPy

        self.module, self.version = GPy, GPy.__version__

    def kernel(self):
        return self.module.kern.RBF(DIMENSION, variance=1.0, lengthscale=LENGTH)

    def fit(self, X, y):
        self.gp = self.module.models.GPRegression(X, y[:, None], self.kernel(), noise_var=NOISE**2)

    def predict(self, queries):
        mean, variance = self.gp.predict_noiseless(queries)
        return mean[:, 0], variance[:, 0]


class GPyMlp(GPy):
    """The same with the MLP kernel: the arcsine covariance with 2/pi in front."""

    arcsine = True

    def kernel(self):
        return self.module.kern.MLP(
            DIMENSION, variance=math.pi / 2, weight_variance=2 * WEIGHT**2, bias_variance=2 * WEIGHT**2
        )


class OpenTurns(Refitted):
    """Gaussian process regression at given hyperparameters."""

    def __init__(self):
        import openturns

        self.ot, self.version = openturns, openturns.__version__

    def fit(self, X, y):
        ot = self.ot
        covariance = ot.SquaredExponential([LENGTH] * DIMENSION, [1.0])
        covariance.setNuggetFactor(NOISE**2)
        X, y = ot.Sample(X), ot.Sample(np.ascontiguousarray(y[:, None]))
        if hasattr(ot, "GaussianProcessFitter"):
            fitter = ot.GaussianProcessFitter(X, y, covariance)
            fitter.setOptimizeParameters(False)
            fitter.setKeepCholeskyFactor(True)
            fitter.run()
            regression = ot.GaussianProcessRegression(fitter.getResult())
            regression.run()
            self.result = regression.getResult()
            self.conditional = ot.GaussianProcessConditionalCovariance(self.result)
        else:
            regression = ot.KrigingAlgorithm(X, y, covariance, ot.Basis(0))
            regression.setOptimizeParameters(False)
            regression.run()
            self.result = self.conditional = regression.getResult()

    def predict(self, queries):
        queries = self.ot.Sample(queries)
        mean = np.asarray(self.conditional.getConditionalMean(queries)).ravel()
        of_observation = np.asarray(self.conditional.getConditionalMarginalVariance(queries)).ravel()
        return mean, of_observation - NOISE**2


LIBRARIES = {
    "egosieve": Egosieve,
    "egosieve arcsine": EgosieveArcsine,
    "scikit-learn": ScikitLearn,
    "GPyTorch exact": GPyTorchExact,
    "GPyTorch fast_pred_var": GPyTorchFast,
    "GPy": GPy,
    "GPy MLP": GPyMlp,
    "OpenTURNS": OpenTurns,
}


def memory_mib(field):
    """VmRSS: now; VmHWM: at most."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith(field))


class Session:
    """The tasks of one worker."""

    def __init__(self, name, points, queries):
        self.name, self.points = name, points
        self.X, self.y, self.queries = make_data(points, queries)
        self.begin = 0
        self.count = min(FEW, queries)  # of the warming call; those that are slow stay there

    def window(self):
        here = slice(self.begin, self.begin + self.points)
        new = slice(here.stop, here.stop + UPDATE)
        return self.X[here], self.y[here], self.X[new], self.y[new]

    def prepare(self):
        self.library = LIBRARIES[self.name]()
        self.after_import = memory_mib("VmRSS")
        start = time.perf_counter()
        self.library.fit(self.X[: self.points], self.y[: self.points])
        mean, variance = self.library.predict(self.queries[:FEW])
        return {
            "version": self.library.version,
            "precision": self.library.precision,
            "first_seconds": time.perf_counter() - start,
            "mean": np.asarray(mean, np.float64).tolist(),
            "variance": np.asarray(variance, np.float64).tolist(),
        }

    def predict(self):
        start = time.perf_counter()
        self.library.predict(self.queries[: self.count])
        seconds = time.perf_counter() - start
        answer = {"seconds": seconds / self.count}  # a query's
        if self.count == FEW and seconds < SLOW:
            self.count = len(self.queries)
        return answer

    def replace(self):
        window = self.window()
        start = time.perf_counter()
        self.library.replace(*window).predict(self.queries[:FEW])
        seconds = time.perf_counter() - start
        self.begin += UPDATE
        return {"seconds": seconds}

    def append(self):
        window = self.window()
        start = time.perf_counter()
        self.library.append(*window).predict(self.queries[:FEW])
        seconds = time.perf_counter() - start
        self.library.undo_append(self.points)
        return {"seconds": seconds}

    def joint(self):
        start = time.perf_counter()
        covariance = self.library.joint(self.queries)[1]
        seconds = time.perf_counter() - start
        self.covariance = np.array(covariance[:FEW, :FEW], np.float64)
        return {"seconds": seconds}

    def samples(self):
        start = time.perf_counter()
        self.library.samples(self.queries)
        return {"seconds": time.perf_counter() - start}

    def finish(self):
        # The measure of errors comes last, so that its memory is not counted.
        account = {"after_import_mib": self.after_import, "peak_mib": memory_mib("VmHWM")}
        mean, covariance = float64_posterior(
            self.library.arcsine, self.X[: self.points], self.y[: self.points], self.queries[:FEW]
        )
        account["mean_error"] = float(np.abs(np.array(self.first["mean"]) - mean).max())
        account["variance_error"] = float(np.abs(np.array(self.first["variance"]) - np.diag(covariance)).max())
        if hasattr(self, "covariance"):
            account["covariance_error"] = float(np.abs(self.covariance - covariance).max())
        return account


def main():
    """Answers until stdin ends."""
    session = Session(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
    answers = sys.stdout
    sys.stdout = sys.stderr  # what libraries print is no answer
    for line in sys.stdin:
        task = line.strip()
        try:
            answer = getattr(session, task)()
        except Exception as error:  # reported, with its kind, to the one who asked
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
        if task == "prepare" and "mean" in answer:
            session.first = {name: answer.pop(name) for name in ("mean", "variance")}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
