"""One library's side of peers.py: workers.py LIBRARY COVARIANCE POINTS DIMENSION QUERIES JOINT_QUERIES, then a task a line on
stdin, a JSON answer a line.

    prepare   imports, fits (hyperparameters are given), compares with float64: errors, versions
    fit       the model from its points until its first prediction, of one query: seconds
    mean      the mean alone at all queries: seconds a query
    predict   mean and variance of f at all queries: seconds a query
    replace   64 new points, the 64 oldest gone, then mean and variance at 256 queries: seconds
    append    64 new points, then mean and variance at 256 queries: seconds; they are dropped again untimed
    joint     mean and joint covariance of f at the first JOINT_QUERIES queries: seconds
    samples   1,000 samples of f there, the covariance among what is timed: seconds
    finish    memory, errors

mean and predict ask 256 queries only where these alone take over 4 s. The models are one and the same: COVARIANCE with
lengths 0.8 sqrt(D / 6), alpha 1, weights 1.5, periods 1.7, sigma_f = 1, sigma_n = NOISE, on points and labels of a smooth
boundary. A library without the covariance says so in `prepare`.
"""

import json
import math
import sys
import time

import numpy as np

UPDATE, FEW, SAMPLES = 64, 256, 1000
SLOW = 4.0  # seconds for FEW queries
LARGEST_CHECKED = 4000  # points; more would take gigabytes in float64
WEIGHT, PERIOD, NOISE = 1.5, 1.7, 0.3


def length_of(dimension):
    """With which neighbours are as much alike in any dimension."""
    return 0.8 * math.sqrt(dimension / 6)


def make_data(points, dimension, queries):
    """Inputs and targets of the model, of 64 updates, and the queries."""
    random = np.random.default_rng(11)
    X = random.uniform(-1, 1, (points + 64 * UPDATE, dimension))
    y = np.tanh(3 * np.sin(2 * X[:, 0]) * X[:, 1] + X[:, -1]) + random.normal(0, NOISE, len(X))
    return X, y, random.uniform(-1, 1, (queries, dimension))


def squared_distances(a, b):
    """Over the squared length."""
    squares = (a**2).sum(1)[:, None] + (b**2).sum(1)[None] - 2 * a @ b.T
    return np.maximum(squares, 0) / length_of(a.shape[1]) ** 2


def arcsine(a, b):
    """The neural network covariance."""
    norms = [1 + 2 * WEIGHT**2 * (1 + (x**2).sum(1)) for x in (a, b)]
    return np.arcsin(2 * WEIGHT**2 * (1 + a @ b.T) / np.sqrt(norms[0][:, None] * norms[1][None]))


def periodic(a, b):
    """Over every input; the length of one."""
    exponent = sum(np.sin(np.pi * (a[:, d, None] - b[None, :, d]) / PERIOD) ** 2 for d in range(a.shape[1]))
    return np.exp(-2 * exponent / length_of(a.shape[1]) ** 2)


def matern(polynomial, factor):
    """Of the distance times `factor`."""

    def covariance(a, b):
        scaled = factor * np.sqrt(squared_distances(a, b))
        return polynomial(scaled) * np.exp(-scaled)

    return covariance


# In float64, by the formulas.
COVARIANCES = {
    "squared_exponential": lambda a, b: np.exp(-0.5 * squared_distances(a, b)),
    "matern12": matern(lambda r: 1, 1),
    "matern32": matern(lambda r: 1 + r, math.sqrt(3)),
    "matern52": matern(lambda r: 1 + r + r**2 / 3, math.sqrt(5)),
    "rational_quadratic": lambda a, b: 1 / (1 + 0.5 * squared_distances(a, b)),
    "periodic": periodic,
    "linear": lambda a, b: a @ b.T,
    "arcsine": arcsine,
}


def float64_posterior(covariance, X, y, queries):
    """Mean and joint covariance of f, the measure of all errors."""
    from scipy.linalg import cho_factor, cho_solve, solve_triangular

    factor = cho_factor(covariance(X, X) + NOISE**2 * np.eye(len(X)), lower=True)
    cross = covariance(X, queries)
    half = solve_triangular(factor[0], cross, lower=True)
    return cross.T @ cho_solve(factor, y), covariance(queries, queries) - half.T @ half


class Absent(Exception):
    """The library does not have the covariance."""


def chosen(kernels, covariance):
    """The entry of a library's kernels."""
    if covariance not in kernels:
        raise Absent(f"has no {covariance}")
    return kernels[covariance]


class Library:
    """What a worker asks. Libraries without updates fit anew."""

    precision = "float64"

    def __init__(self, covariance, dimension):
        self.covariance, self.dimension, self.length = covariance, dimension, length_of(dimension)
        self.load()

    def replace(self, X, y, new_X, new_y):
        self.fit(np.vstack([X[UPDATE:], new_X]), np.concatenate([y[UPDATE:], new_y]))
        return self

    def append(self, X, y, new_X, new_y):
        self.fit(np.vstack([X, new_X]), np.concatenate([y, new_y]))
        return self

    def undo_append(self, count):
        pass


class Egosieve(Library):
    """This library, float32 on its device."""

    precision = "float32"

    def load(self):
        import egosieve

        lengths = [self.length] * self.dimension
        scales = {
            "arcsine": [WEIGHT] * (self.dimension + 1),
            "linear": [1.0] * self.dimension,
            "rational_quadratic": [1.0, *lengths],
            "periodic": lengths + [PERIOD] * self.dimension,
        }.get(self.covariance, lengths)
        self.version = egosieve.__version__
        self.new = lambda: egosieve.GaussianProcess(self.covariance, scales=scales, noise_stddev=NOISE, optimize=False)

    def fit(self, X, y):
        self.gp = self.new().fit(X, y)

    def mean(self, queries):
        return self.gp.predict(queries.astype(np.float32))

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


class ScikitLearn(Library):
    """GaussianProcessRegressor."""

    def load(self):
        import sklearn
        from sklearn.gaussian_process import GaussianProcessRegressor, kernels

        available = {
            "squared_exponential": lambda: kernels.RBF(self.length),
            "matern12": lambda: kernels.Matern(self.length, nu=0.5),
            "matern32": lambda: kernels.Matern(self.length, nu=1.5),
            "matern52": lambda: kernels.Matern(self.length, nu=2.5),
            "rational_quadratic": lambda: kernels.RationalQuadratic(self.length, 1.0),
            "linear": lambda: kernels.DotProduct(0.0),
        }
        kernel = chosen(available, self.covariance)()
        self.version = sklearn.__version__
        self.new = lambda: GaussianProcessRegressor(kernel, alpha=NOISE**2, optimizer=None)

    def fit(self, X, y):
        self.gp = self.new().fit(X, y)

    def mean(self, queries):
        return self.gp.predict(queries)

    def predict(self, queries):
        mean, std = self.gp.predict(queries, return_std=True)
        return mean, std**2

    def joint(self, queries):
        return self.gp.predict(queries, return_cov=True)

    def samples(self, queries):
        return self.gp.sample_y(queries, SAMPLES)


class GPyTorchExact(Library):
    """ExactGP in float32, by Cholesky."""

    precision = "float32"
    fast = False

    def kernel(self):
        kernels = self.gpytorch.kernels
        made = chosen({
            "squared_exponential": kernels.RBFKernel,
            "matern12": lambda: kernels.MaternKernel(nu=0.5),
            "matern32": lambda: kernels.MaternKernel(nu=1.5),
            "matern52": lambda: kernels.MaternKernel(nu=2.5),
            "rational_quadratic": kernels.RQKernel,
            "periodic": kernels.PeriodicKernel,
            "linear": kernels.LinearKernel,
        }, self.covariance)()  # fmt: skip
        if self.covariance == "linear":
            made.variance = 1.0
            return made
        made.lengthscale = self.length
        if self.covariance == "rational_quadratic":
            made.alpha = 1.0
        if self.covariance == "periodic":
            made.lengthscale, made.period_length = self.length**2, PERIOD  # lengthscale has no square there
        return made

    def load(self):
        import gpytorch
        import torch

        torch.set_num_threads(2)
        self.torch, self.gpytorch = torch, gpytorch
        self.version = f"{gpytorch.__version__} (torch {torch.__version__})"
        kernel = self.kernel()

        class Model(gpytorch.models.ExactGP):
            def __init__(self, X, y, likelihood):
                super().__init__(X, y, likelihood)
                self.mean_module = gpytorch.means.ZeroMean()
                self.covar_module = kernel

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

    def posterior(self, queries, read):
        settings = self.gpytorch.settings
        with self.torch.no_grad(), settings.fast_pred_var(self.fast), settings.max_cholesky_size(10**6):
            return read(self.gp(self.tensor(queries)))

    def mean(self, queries):
        with self.gpytorch.settings.skip_posterior_variances(True):
            return self.posterior(queries, lambda f: f.mean.numpy())

    def predict(self, queries):
        return self.posterior(queries, lambda f: (f.mean.numpy(), f.variance.numpy()))

    def joint(self, queries):
        return self.posterior(queries, lambda f: (f.mean.numpy(), f.covariance_matrix.numpy()))

    def samples(self, queries):
        return self.posterior(queries, lambda f: f.sample(self.torch.Size([SAMPLES])).numpy())


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


class GPy(Library):
    """GPRegression; its mean comes with the variance always."""

    def load(self):
        import GPy

        kern, d = GPy.kern, self.dimension
        lengths = {"variance": 1.0, "lengthscale": self.length}
        self.kernel = chosen({
            "squared_exponential": lambda: kern.RBF(d, **lengths),
            "matern12": lambda: kern.Exponential(d, **lengths),
            "matern32": lambda: kern.Matern32(d, **lengths),
            "matern52": lambda: kern.Matern52(d, **lengths),
            "rational_quadratic": lambda: kern.RatQuad(d, power=1.0, **lengths),
            "periodic": lambda: kern.StdPeriodic(d, variance=1.0, period=PERIOD, lengthscale=self.length / 2),
            "linear": lambda: kern.Linear(d, variances=1.0),
            # The arcsine with 2 / pi in front.
            "arcsine": lambda: kern.MLP(d, math.pi / 2, weight_variance=2 * WEIGHT**2, bias_variance=2 * WEIGHT**2),
        }, self.covariance)  # fmt: skip
        self.module, self.version = GPy, GPy.__version__

    def fit(self, X, y):
        self.gp = self.module.models.GPRegression(X, y[:, None], self.kernel(), noise_var=NOISE**2)

    def predict(self, queries):
        mean, variance = self.gp.predict_noiseless(queries)
        return mean[:, 0], variance[:, 0]

    def joint(self, queries):
        mean, covariance = self.gp.predict_noiseless(queries, full_cov=True)
        return mean[:, 0], covariance


class OpenTurns(Library):
    """Gaussian process regression at given hyperparameters; its covariances are those of the observation."""

    def load(self):
        import openturns

        self.ot, self.version = openturns, openturns.__version__
        nu = {"matern12": 0.5, "matern32": 1.5, "matern52": 2.5}.get(self.covariance)
        lengths = [self.length] * self.dimension
        self.kernel = chosen({
            "squared_exponential": lambda: openturns.SquaredExponential(lengths, [1.0]),
            **dict.fromkeys(("matern12", "matern32", "matern52"), lambda: openturns.MaternModel(lengths, [1.0], nu)),
        }, self.covariance)  # fmt: skip

    def fit(self, X, y):
        ot = self.ot
        covariance = self.kernel()
        covariance.setNuggetFactor(NOISE**2)
        fitter = ot.GaussianProcessFitter(ot.Sample(X), ot.Sample(np.ascontiguousarray(y[:, None])), covariance)
        fitter.setOptimizeParameters(False)
        fitter.setKeepCholeskyFactor(True)
        fitter.run()
        regression = ot.GaussianProcessRegression(fitter.getResult())
        regression.run()
        self.conditional = ot.GaussianProcessConditionalCovariance(regression.getResult())

    def mean(self, queries):
        return np.asarray(self.conditional.getConditionalMean(self.ot.Sample(queries))).ravel()

    def predict(self, queries):
        of_observation = self.conditional.getConditionalMarginalVariance(self.ot.Sample(queries))
        return self.mean(queries), np.asarray(of_observation).ravel() - NOISE**2

    def joint(self, queries):
        of_observation = np.array(self.conditional.getConditionalCovariance(self.ot.Sample(queries)))
        return self.mean(queries), of_observation - NOISE**2 * np.eye(len(queries))


LIBRARIES = {
    "egosieve": Egosieve,
    "scikit-learn": ScikitLearn,
    "GPyTorch exact": GPyTorchExact,
    "GPyTorch fast_pred_var": GPyTorchFast,
    "GPy": GPy,
    "OpenTURNS": OpenTurns,
}


def memory_mib(field):
    """VmRSS: now; VmHWM: at most."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith(field))


class Session:
    """The tasks of one worker."""

    def __init__(self, library, covariance, points, dimension, queries, joint_queries):
        self.kind, self.covariance, self.points, self.dimension = library, covariance, points, dimension
        self.X, self.y, self.queries = make_data(points, dimension, queries)
        self.joint_queries = self.queries[:joint_queries]
        self.begin = 0
        few = min(FEW, queries)  # of the warming call; what is slow stays there
        self.counts = {"mean": few, "predict": few}

    def window(self):
        here = slice(self.begin, self.begin + self.points)
        new = slice(here.stop, here.stop + UPDATE)
        return self.X[here], self.y[here], self.X[new], self.y[new]

    def prepare(self):
        self.library = LIBRARIES[self.kind](self.covariance, self.dimension)
        self.after_import = memory_mib("VmRSS")
        start = time.perf_counter()
        self.library.fit(self.X[: self.points], self.y[: self.points])
        self.first = self.library.predict(self.queries[:FEW])
        return {
            "version": self.library.version,
            "precision": self.library.precision,
            "first_seconds": time.perf_counter() - start,
        }

    def fit(self):
        start = time.perf_counter()
        self.library.fit(*self.window()[:2])
        self.library.predict(self.queries[:1])
        return {"seconds": time.perf_counter() - start}

    def of_each(self, task):
        """Seconds a query."""
        if not hasattr(self.library, task):
            return {"error": "not offered alone"}
        count = self.counts[task]
        start = time.perf_counter()
        getattr(self.library, task)(self.queries[:count])
        seconds = time.perf_counter() - start
        if count == FEW and seconds < SLOW:
            self.counts[task] = len(self.queries)
        return {"seconds": seconds / count}

    def mean(self):
        return self.of_each("mean")

    def predict(self):
        return self.of_each("predict")

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
        covariance = self.library.joint(self.joint_queries)[1]
        seconds = time.perf_counter() - start
        self.own_covariance = np.array(covariance[:FEW, :FEW], np.float64)
        return {"seconds": seconds}

    def samples(self):
        start = time.perf_counter()
        self.library.samples(self.joint_queries)
        return {"seconds": time.perf_counter() - start}

    def finish(self):
        # The measure of errors comes last, so that its memory is not counted.
        account = {"after_import_mib": self.after_import, "peak_mib": memory_mib("VmHWM")}
        if self.points > LARGEST_CHECKED:
            return account
        mean, covariance = float64_posterior(
            COVARIANCES[self.covariance], self.X[: self.points], self.y[: self.points], self.queries[:FEW]
        )
        account["mean_error"] = float(np.abs(self.first[0] - mean).max())
        account["variance_error"] = float(np.abs(self.first[1] - np.diag(covariance)).max())
        if hasattr(self, "own_covariance"):
            account["covariance_error"] = float(np.abs(self.own_covariance - covariance).max())
        return account


def main():
    """Answers until stdin ends."""
    library, covariance, *sizes = sys.argv[1:]
    session = Session(library, covariance, *map(int, sizes))
    answers = sys.stdout
    sys.stdout = sys.stderr  # what libraries print is no answer
    for line in sys.stdin:
        task = line.strip()
        try:
            answer = getattr(session, task)()
        except Exception as error:  # reported, with its kind, to the one who asked
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
