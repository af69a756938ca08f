// The extension behind egosieve.GaussianProcess: handles of the C interface as Python objects.
// Arguments are checked for what they mean by egosieve/gaussian_process.py and the library itself.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "egosieve/gaussian_process.h"
#include "egosieve/joint_posterior.h"
#include "tools/embed/python/array_arguments.h"

namespace egosieve::python {
namespace {

constexpr const char* kMeans[] = {"zero", "constant", "linear"};

egosieve_mean MeanOf(const std::string& name) {
  for (int i = 0; i < 3; ++i) {
    if (name == kMeans[i]) return i;
  }
  throw py::value_error("mean = '" + name + "'; it must be 'zero', 'constant' or 'linear'");
}

// The three results of a prediction, numpy arrays or None.
egosieve_prediction PredictionOf(const py::object& mean, const py::object& variance,
                                 const py::object& probability, bool of_observation) {
  egosieve_prediction prediction;
  egosieve_prediction_init(&prediction);
  prediction.mean = Output("mean", mean);
  prediction.variance = Output("variance", variance);
  prediction.probability = Output("probability", probability);
  prediction.of_observation = of_observation;
  return prediction;
}

// Predictions are the same for a model and its posterior, but for the names of the calls.
struct ModelCalls {
  using Handle = egosieve_gp;
  static constexpr auto kPoints = egosieve_gp_predict;
  static constexpr auto kGrid = egosieve_gp_predict_grid;
  static constexpr auto kImage = egosieve_gp_predict_image;
  static constexpr auto kFree = egosieve_gp_free;
};
struct PosteriorCalls {
  using Handle = egosieve_posterior;
  static constexpr auto kPoints = egosieve_posterior_predict;
  static constexpr auto kGrid = egosieve_posterior_predict_grid;
  static constexpr auto kImage = egosieve_posterior_predict_image;
  static constexpr auto kFree = egosieve_posterior_free;
};

template <typename Calls>
class Predictor {
 public:
  explicit Predictor(typename Calls::Handle* handle) : handle_(handle) {}
  Predictor(const Predictor&) = delete;
  Predictor& operator=(const Predictor&) = delete;
  ~Predictor() { Calls::kFree(handle_); }

  int64_t Predict(const py::array& x, const py::object& mean, const py::object& variance,
                  const py::object& probability, bool of_observation) const {
    const egosieve_const_array points = Input("x", x);
    egosieve_prediction prediction = PredictionOf(mean, variance, probability, of_observation);
    CheckUnlocked([&] { return Calls::kPoints(handle_, &points, &prediction); });
    return prediction.clamped_variances;
  }
  int64_t PredictGrid(double x0, double y0, double dx, double dy, int64_t rows, int64_t columns,
                      const py::object& mean, const py::object& variance,
                      const py::object& probability, bool of_observation) const {
    const egosieve_grid grid = {x0, y0, dx, dy, rows, columns};
    egosieve_prediction prediction = PredictionOf(mean, variance, probability, of_observation);
    CheckUnlocked([&] { return Calls::kGrid(handle_, &grid, &prediction); });
    return prediction.clamped_variances;
  }
  int64_t PredictImage(py::array image, int stride, const std::string& order,
                       const py::object& mean, const py::object& variance,
                       const py::object& probability, bool of_observation) const {
    const egosieve_image view = ImageOf("image", image, order);
    egosieve_prediction prediction = PredictionOf(mean, variance, probability, of_observation);
    CheckUnlocked([&] { return Calls::kImage(handle_, &view, stride, &prediction); });
    return prediction.clamped_variances;
  }

 protected:
  typename Calls::Handle* handle_;
};

using Posterior = Predictor<PosteriorCalls>;

class Model : public Predictor<ModelCalls> {
 public:
  using Predictor::Predictor;

  static std::unique_ptr<Model> Create(const std::string& kernel, int dimension,
                                       const std::optional<std::vector<double>>& scales,
                                       double signal_stddev, double noise_stddev,
                                       const std::string& mean,
                                       const std::optional<std::string>& device) {
    egosieve_gp_options options;
    egosieve_gp_options_init(&options);
    options.covariance = EGOSIEVE_NAMED_COVARIANCE;
    options.covariance_text = kernel.c_str();
    options.mean = MeanOf(mean);
    options.dimension = dimension;
    options.scales = scales ? scales->data() : nullptr;
    options.scale_count = scales ? static_cast<int64_t>(scales->size()) : 0;
    options.signal_stddev = signal_stddev;
    options.noise_stddev = noise_stddev;
    options.device = device ? device->c_str() : nullptr;
    egosieve_gp* handle = nullptr;
    egosieve_status status;
    {
      py::gil_scoped_release unlocked;
      status = egosieve_gp_create(&options, &handle);
    }
    if (status == EGOSIEVE_NOT_FOUND) throw py::value_error(egosieve_last_error());
    Check(status);
    return std::make_unique<Model>(handle);
  }
  static std::unique_ptr<Model> Load(const std::string& path,
                                     const std::optional<std::string>& device) {
    egosieve_gp* handle = nullptr;
    const char* name = device ? device->c_str() : nullptr;
    CheckUnlocked([&] { return egosieve_gp_load(path.c_str(), name, &handle); });
    return std::make_unique<Model>(handle);
  }
  static std::unique_ptr<Model> Deserialize(const py::bytes& bytes,
                                            const std::optional<std::string>& device) {
    const std::string copy = bytes;
    egosieve_gp* handle = nullptr;
    const char* name = device ? device->c_str() : nullptr;
    CheckUnlocked([&] {
      return egosieve_gp_deserialize(copy.data(), static_cast<int64_t>(copy.size()), name, &handle);
    });
    return std::make_unique<Model>(handle);
  }

  // noise_variances: a NumPy array or None.
  void Condition(const py::array& x, const py::array& y, const py::object& noise_variances) {
    const egosieve_const_array inputs = Input("x", x), targets = Input("y", y);
    if (noise_variances.is_none()) {
      CheckUnlocked([&] { return egosieve_gp_condition(handle_, &inputs, &targets); });
      return;
    }
    const egosieve_const_array variances =
        Input("alpha", py::reinterpret_borrow<py::array>(noise_variances));
    CheckUnlocked(
        [&] { return egosieve_gp_condition_noisy(handle_, &inputs, &targets, &variances); });
  }
  void Remove(const std::vector<int64_t>& rows) {
    CheckUnlocked([&] {
      return egosieve_gp_remove(handle_, rows.data(), static_cast<int64_t>(rows.size()));
    });
  }
  py::dict Optimize(int64_t subset_size, int annealing_evaluations, int gradient_steps,
                    double tolerance, uint64_t seed) {
    egosieve_optimize_options options;
    egosieve_optimize_options_init(&options);
    options.subset_size = subset_size;
    options.annealing_evaluations = annealing_evaluations;
    options.gradient_steps = gradient_steps;
    options.tolerance = tolerance;
    options.seed = seed;
    egosieve_optimize_result result;
    egosieve_optimize_result_init(&result);
    CheckUnlocked([&] { return egosieve_gp_optimize(handle_, &options, &result); });
    py::dict account;
    account["log_likelihood_at_start"] = result.log_likelihood_at_start;
    account["log_likelihood"] = result.log_likelihood;
    account["evaluations"] = result.evaluations;
    account["points"] = result.points;
    account["converged"] = result.converged != 0;
    return account;
  }
  void Calibrate() {
    CheckUnlocked([&] { return egosieve_gp_calibrate(handle_); });
  }
  double LogMarginalLikelihood() const {
    double value = 0.0;
    CheckUnlocked([&] { return egosieve_gp_log_marginal_likelihood(handle_, &value); });
    return value;
  }
  py::dict Describe() const {
    egosieve_gp_info info;
    egosieve_gp_info_init(&info);
    CheckUnlocked([&] { return egosieve_gp_describe(handle_, &info); });
    py::dict account;
    account["size"] = info.size;
    account["dimension"] = info.dimension;
    account["kernel"] =
        py::str(Bytes([&](void* bytes, int64_t capacity, int64_t* size) {
                  return egosieve_gp_covariance_text(handle_, bytes, capacity, size);
                }).attr("decode")());
    std::vector<double> scales(info.scale_count);
    CheckUnlocked([&] { return egosieve_gp_scales(handle_, scales.data(), info.scale_count); });
    account["scales"] = scales;
    account["mean"] = kMeans[info.mean];
    account["outputs"] = info.outputs;
    account["coefficients"] = info.coefficients;
    account["signal_stddev"] = info.signal_stddev;
    account["noise_stddev"] = info.noise_stddev;
    account["jitter"] = info.jitter;
    account["squash"] = py::make_tuple(info.squash_a, info.squash_b);
    account["has_labels"] = info.has_labels != 0;
    return account;
  }
  void Points(const py::object& x, const py::object& y) const {
    const egosieve_array inputs = Output("x", x), targets = Output("y", y);
    CheckUnlocked([&] { return egosieve_gp_points(handle_, &inputs, &targets); });
  }
  void NoiseVariances(const py::object& v) const {
    const egosieve_array variances = Output("v", v);
    CheckUnlocked([&] { return egosieve_gp_noise_variances(handle_, &variances); });
  }
  int64_t PredictInFloat64(const py::array& x, const py::object& mean, const py::object& variance,
                           bool of_observation) const {
    const egosieve_const_array points = Input("x", x);
    egosieve_prediction prediction = PredictionOf(mean, variance, py::none(), of_observation);
    prediction.in_float64 = 1;
    CheckUnlocked([&] { return egosieve_gp_predict(handle_, &points, &prediction); });
    return prediction.clamped_variances;
  }
  void PredictJoint(const py::array& x, const py::object& mean, const py::object& covariance,
                    bool of_observation) const {
    const egosieve_const_array points = Input("x", x);
    const egosieve_array means = Output("mean", mean), joint = Output("covariance", covariance);
    CheckUnlocked([&] {
      return egosieve_gp_predict_joint(handle_, &points, of_observation, &means, &joint);
    });
  }
  double Sample(const py::array& x, uint64_t seed, const py::object& samples,
                bool of_observation) const {
    const egosieve_const_array points = Input("x", x);
    const egosieve_array out = Output("samples", samples);
    double jitter = 0.0;
    CheckUnlocked(
        [&] { return egosieve_gp_sample(handle_, &points, seed, of_observation, &out, &jitter); });
    return jitter;
  }
  void Gradients(const py::array& x, const py::object& mean, const py::object& variance) const {
    const egosieve_const_array points = Input("x", x);
    const egosieve_array of_mean = Output("mean", mean), of_variance = Output("variance", variance);
    CheckUnlocked([&] { return egosieve_gp_gradients(handle_, &points, &of_mean, &of_variance); });
  }
  void LeaveOneOut(const py::object& mean, const py::object& variance,
                   const py::object& log_density) const {
    const egosieve_array means = Output("mean", mean), variances = Output("variance", variance),
                         densities = Output("log_density", log_density);
    CheckUnlocked(
        [&] { return egosieve_gp_leave_one_out(handle_, &means, &variances, &densities); });
  }
  void MeanCoefficients(const py::object& coefficients) const {
    const egosieve_array out = Output("coefficients", coefficients);
    CheckUnlocked([&] { return egosieve_gp_mean_coefficients(handle_, &out); });
  }
  py::tuple LikelihoodAt(const std::vector<double>& theta, bool with_gradient) const {
    double value = 0.0;
    std::vector<double> gradient(with_gradient ? theta.size() : 0);
    CheckUnlocked([&] {
      return egosieve_gp_likelihood_at(handle_, theta.data(), static_cast<int64_t>(theta.size()),
                                       &value, with_gradient ? gradient.data() : nullptr);
    });
    return py::make_tuple(value, gradient);
  }
  void DescribePixels(py::array image, const std::string& order, const py::array& places,
                      const py::object& out) const {
    const egosieve_image view = ImageOf("image", image, order);
    const egosieve_const_array points = Input("places", places);
    const egosieve_array output = Output("out", out);
    CheckUnlocked([&] { return egosieve_gp_describe_pixels(handle_, &view, &points, &output); });
  }
  std::unique_ptr<Posterior> MakePosterior() const {
    egosieve_posterior* posterior = nullptr;
    CheckUnlocked([&] { return egosieve_gp_posterior(handle_, &posterior); });
    return std::make_unique<Posterior>(posterior);
  }

  void SetAnnotation(const std::string& bytes) {
    Check(egosieve_gp_set_annotation(handle_, bytes.data(), static_cast<int64_t>(bytes.size())));
  }
  py::bytes Annotation() const {
    return Bytes([&](void* bytes, int64_t capacity, int64_t* size) {
      return egosieve_gp_annotation(handle_, bytes, capacity, size);
    });
  }
  void Save(const std::string& path) {
    CheckUnlocked([&] { return egosieve_gp_save(handle_, path.c_str()); });
  }
  py::bytes Serialize() {
    return Bytes([&](void* bytes, int64_t capacity, int64_t* size) {
      return egosieve_gp_serialize(handle_, bytes, capacity, size);
    });
  }

 private:
  // What `call` gives, again where another thread has made it more since the size was asked.
  template <typename Call>
  static py::bytes Bytes(Call&& call) {
    int64_t size = 0;
    std::string bytes;
    CheckUnlocked([&] {
      egosieve_status status = call(nullptr, 0, &size);
      while (status == EGOSIEVE_OK) {
        bytes.resize(size);
        status = call(bytes.data(), static_cast<int64_t>(bytes.size()), &size);
        if (status == EGOSIEVE_OK) break;
        const egosieve_status asked = call(nullptr, 0, &size);
        if (asked != EGOSIEVE_OK || size <= static_cast<int64_t>(bytes.size())) return status;
        status = asked;
      }
      return status;
    });
    bytes.resize(size);
    return py::bytes(bytes);
  }
};

std::vector<std::string> Devices() {
  int32_t count = 0;
  Check(egosieve_device_count(&count));
  std::vector<std::string> names;
  for (int32_t i = 0; i < count; ++i) {
    char name[256];
    Check(egosieve_device_name(i, name, sizeof name));
    names.emplace_back(name);
  }
  return names;
}

template <typename Class, typename Binding>
void BindPredictions(Binding& binding) {
  const py::object none = py::none();
  binding
      .def("predict", &Class::Predict, py::arg("x"), py::arg("mean") = none,
           py::arg("variance") = none, py::arg("probability") = none,
           py::arg("of_observation") = false)
      .def("predict_grid", &Class::PredictGrid, py::arg("x0"), py::arg("y0"), py::arg("dx"),
           py::arg("dy"), py::arg("rows"), py::arg("columns"), py::arg("mean") = none,
           py::arg("variance") = none, py::arg("probability") = none,
           py::arg("of_observation") = false)
      .def("predict_image", &Class::PredictImage, py::arg("image"), py::arg("stride"),
           py::arg("order"), py::arg("mean") = none, py::arg("variance") = none,
           py::arg("probability") = none, py::arg("of_observation") = false);
}

}  // namespace

PYBIND11_MODULE(_gaussian_process, module) {
  module.doc() = "Handles of egosieve's C interface; use egosieve.GaussianProcess.";
  module.def("version", &egosieve_version);
  module.def("devices", &Devices);
  py::class_<Posterior> posterior(module, "Posterior");
  BindPredictions<Posterior>(posterior);
  py::class_<Model> model(module, "Model");
  BindPredictions<Model>(model);
  model
      .def(py::init(&Model::Create), py::arg("kernel"), py::arg("dimension"), py::arg("scales"),
           py::arg("signal_stddev"), py::arg("noise_stddev"), py::arg("mean"), py::arg("device"))
      .def_static("load", &Model::Load, py::arg("path"), py::arg("device"))
      .def_static("deserialize", &Model::Deserialize, py::arg("bytes"), py::arg("device"))
      .def("condition", &Model::Condition, py::arg("x"), py::arg("y"), py::arg("noise_variances"))
      .def("remove", &Model::Remove, py::arg("rows"))
      .def("optimize", &Model::Optimize, py::arg("subset_size"), py::arg("annealing_evaluations"),
           py::arg("gradient_steps"), py::arg("tolerance"), py::arg("seed"))
      .def("calibrate", &Model::Calibrate)
      .def("log_marginal_likelihood", &Model::LogMarginalLikelihood)
      .def("describe", &Model::Describe)
      .def("points", &Model::Points, py::arg("x"), py::arg("y"))
      .def("noise_variances", &Model::NoiseVariances, py::arg("v"))
      .def("predict_in_float64", &Model::PredictInFloat64, py::arg("x"), py::arg("mean"),
           py::arg("variance"), py::arg("of_observation"))
      .def("predict_joint", &Model::PredictJoint, py::arg("x"), py::arg("mean"),
           py::arg("covariance"), py::arg("of_observation"))
      .def("sample", &Model::Sample, py::arg("x"), py::arg("seed"), py::arg("samples"),
           py::arg("of_observation"))
      .def("gradients", &Model::Gradients, py::arg("x"), py::arg("mean"), py::arg("variance"))
      .def("leave_one_out", &Model::LeaveOneOut, py::arg("mean"), py::arg("variance"),
           py::arg("log_density"))
      .def("mean_coefficients", &Model::MeanCoefficients, py::arg("coefficients"))
      .def("likelihood_at", &Model::LikelihoodAt, py::arg("theta"), py::arg("with_gradient"))
      .def("describe_pixels", &Model::DescribePixels, py::arg("image"), py::arg("order"),
           py::arg("places"), py::arg("out"))
      .def("posterior", &Model::MakePosterior)
      .def("set_annotation", &Model::SetAnnotation, py::arg("bytes"))
      .def("annotation", &Model::Annotation)
      .def("save", &Model::Save, py::arg("path"))
      .def("serialize", &Model::Serialize);
}

}  // namespace egosieve::python
