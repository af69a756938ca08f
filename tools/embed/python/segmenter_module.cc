// The extension behind egosieve.Segmenter; see gaussian_process_module.cc.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>

#include "egosieve/segmenter.h"
#include "tools/embed/python/array_arguments.h"

namespace egosieve::python {
namespace {

class Session {
 public:
  explicit Session(egosieve_segmenter* handle) : handle_(handle) {}
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() { egosieve_segmenter_free(handle_); }

  static std::unique_ptr<Session> Create(const std::string& profile, int stride, int64_t budget,
                                         uint64_t seed, const std::optional<std::string>& device) {
    if (profile != "default" && profile != "paper") {
      throw py::value_error("profile = '" + profile + "'; it must be 'default' or 'paper'");
    }
    egosieve_segmenter_options options;
    egosieve_segmenter_options_init(&options);
    options.profile = profile == "paper" ? EGOSIEVE_PROFILE_PAPER : EGOSIEVE_PROFILE_DEFAULT;
    options.stride = stride;
    options.budget = budget;
    options.seed = seed;
    options.device = device ? device->c_str() : nullptr;
    egosieve_segmenter* handle = nullptr;
    egosieve_status status;
    {
      py::gil_scoped_release unlocked;
      status = egosieve_segmenter_create(&options, &handle);
    }
    if (status == EGOSIEVE_NOT_FOUND) throw py::value_error(egosieve_last_error());
    Check(status);
    return std::make_unique<Session>(handle);
  }
  static std::unique_ptr<Session> Load(const std::string& path,
                                       const std::optional<std::string>& device) {
    egosieve_segmenter* handle = nullptr;
    const char* name = device ? device->c_str() : nullptr;
    CheckUnlocked([&] { return egosieve_segmenter_load(path.c_str(), name, &handle); });
    return std::make_unique<Session>(handle);
  }

  py::tuple GridSize(int width, int height) const {
    int64_t rows = 0, columns = 0;
    Check(egosieve_segmenter_grid_size(handle_, width, height, &rows, &columns));
    return py::make_tuple(rows, columns);
  }
  py::dict Process(py::array frame, const std::string& order, double time_seconds,
                   const py::object& probability, const py::object& mean,
                   const py::object& deviation) {
    const egosieve_image image = ImageOf("frame", frame, order);
    egosieve_map map;
    egosieve_map_init(&map);
    map.probability = Output("probability", probability);
    map.mean = Output("mean", mean);
    map.deviation = Output("deviation", deviation);
    const bool wanted = map.probability.data != nullptr || map.mean.data != nullptr ||
                        map.deviation.data != nullptr;
    egosieve_frame_report report;
    egosieve_frame_report_init(&report);
    CheckUnlocked([&] {
      return egosieve_segmenter_process(handle_, &image, time_seconds, wanted ? &map : nullptr,
                                        &report);
    });
    py::dict account;
    account["frame"] = report.frame;
    account["learnt"] = report.learnt != 0;
    account["reason"] = std::string(report.reason);
    account["matches"] = report.matches;
    account["inliers"] = report.inliers;
    account["static_labels"] = report.static_labels;
    account["dynamic_labels"] = report.dynamic_labels;
    account["model_size"] = report.model_size;
    account["dynamic_share"] = report.dynamic_share;
    account["milliseconds"] = report.milliseconds;
    return account;
  }
  void Save(const std::string& path) {
    CheckUnlocked([&] { return egosieve_segmenter_save(handle_, path.c_str()); });
  }

 private:
  egosieve_segmenter* handle_;
};

}  // namespace

PYBIND11_MODULE(_segmenter, module) {
  module.doc() = "Handles of egosieve's C interface; use egosieve.Segmenter.";
  py::class_<Session>(module, "Session")
      .def(py::init(&Session::Create), py::arg("profile"), py::arg("stride"), py::arg("budget"),
           py::arg("seed"), py::arg("device"))
      .def_static("load", &Session::Load, py::arg("path"), py::arg("device"))
      .def("grid_size", &Session::GridSize, py::arg("width"), py::arg("height"))
      .def("process", &Session::Process, py::arg("frame"), py::arg("order"),
           py::arg("time_seconds"), py::arg("probability"), py::arg("mean"), py::arg("deviation"))
      .def("save", &Session::Save, py::arg("path"));
}

}  // namespace egosieve::python
