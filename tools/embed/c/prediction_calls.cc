#include <memory>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/box_means.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/last_error.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/c/options.h"
#include "tools/embed/c/prediction.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {
namespace {

// Calls `body` with the posterior of the model's current state.
template <typename Body>
egosieve_status WithCurrentPosterior(const char* function, egosieve_gp* gp, Body&& body) {
  return WithModel(function, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const DevicePosterior posterior, model.Posterior());
    return body(posterior);
  });
}

absl::Status DescribePixels(const LearningModel& model, const egosieve_image* image,
                            const egosieve_const_array* places, const egosieve_array* out) {
  std::vector<uint8_t> storage;
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::ImageView view, ViewImage("image", image, storage));
  EGOSIEVE_ASSIGN_OR_RETURN(const InputArray points, InputArray::Matrix("places", places));
  if (points.columns() != 2) {
    return absl::InvalidArgumentError(
        absl::StrFormat("places: %d columns; a place is (x, y)", points.columns()));
  }
  EGOSIEVE_RETURN_IF_ERROR(points.CheckFinite<double>());
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer("out", out));
  constexpr int64_t kDimension = kernels::kBoxMeanColumns;
  EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray output,
                            OutputArray::Create("out", *out, points.rows(), kDimension));
  if (!output.wanted()) return absl::InvalidArgumentError("out.data is null");
  const std::vector<double> at = points.Values();
  std::vector<float> descriptors(points.rows() * kDimension);
  const absl::Status status = kernels::BoxMeansAt(
      *model.context(), view, {at.data(), points.rows(), 2}, {},
      kernels::MatrixView<float>(descriptors.data(), points.rows(), kDimension));
  if (!status.ok()) {
    return absl::Status(status.code(), absl::StrFormat("places: %s", status.message()));
  }
  output.Write(0, output.size(), descriptors.data());
  return absl::OkStatus();
}

}  // namespace
extern "C" {

void egosieve_prediction_init(egosieve_prediction* prediction) {
  if (prediction == nullptr) return;
  *prediction = egosieve_prediction{};
  prediction->struct_size = sizeof *prediction;
}

egosieve_status egosieve_gp_predict(egosieve_gp* gp, const egosieve_const_array* x,
                                    egosieve_prediction* prediction) {
  return WithCurrentPosterior(__func__, gp, [&](const DevicePosterior& posterior) {
    return PredictPoints(posterior, x, prediction);
  });
}

egosieve_status egosieve_gp_predict_grid(egosieve_gp* gp, const egosieve_grid* grid,
                                         egosieve_prediction* prediction) {
  return WithCurrentPosterior(__func__, gp, [&](const DevicePosterior& posterior) {
    return PredictGrid(posterior, grid, prediction);
  });
}

egosieve_status egosieve_gp_predict_image(egosieve_gp* gp, const egosieve_image* image,
                                          int32_t stride, egosieve_prediction* prediction) {
  return WithCurrentPosterior(__func__, gp, [&](const DevicePosterior& posterior) {
    return PredictImage(posterior, image, stride, prediction);
  });
}

egosieve_status egosieve_gp_describe_pixels(egosieve_gp* gp, const egosieve_image* image,
                                            const egosieve_const_array* places,
                                            const egosieve_array* out) {
  return WithModel(__func__, gp,
                   [&](LearningModel& model) { return DescribePixels(model, image, places, out); });
}

egosieve_status egosieve_gp_posterior(egosieve_gp* gp, egosieve_posterior** posterior) {
  return WithCurrentPosterior(__func__, gp, [&](const DevicePosterior& current) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("posterior", posterior));
    EGOSIEVE_ASSIGN_OR_RETURN(
        *posterior, AllPosteriors().Insert(std::make_shared<const DevicePosterior>(current)));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_posterior_predict(egosieve_posterior* posterior,
                                           const egosieve_const_array* x,
                                           egosieve_prediction* prediction) {
  return WithPosterior(__func__, posterior, [&](const DevicePosterior& found) {
    return PredictPoints(found, x, prediction);
  });
}

egosieve_status egosieve_posterior_predict_grid(egosieve_posterior* posterior,
                                                const egosieve_grid* grid,
                                                egosieve_prediction* prediction) {
  return WithPosterior(__func__, posterior, [&](const DevicePosterior& found) {
    return PredictGrid(found, grid, prediction);
  });
}

egosieve_status egosieve_posterior_predict_image(egosieve_posterior* posterior,
                                                 const egosieve_image* image, int32_t stride,
                                                 egosieve_prediction* prediction) {
  return WithPosterior(__func__, posterior, [&](const DevicePosterior& found) {
    return PredictImage(found, image, stride, prediction);
  });
}

egosieve_status egosieve_posterior_free(egosieve_posterior* posterior) {
  if (posterior == nullptr) return EGOSIEVE_OK;
  return Guard(__func__, [&] { return AllPosteriors().Erase("posterior", posterior); });
}

}  // extern "C"

}  // namespace egosieve::embed
