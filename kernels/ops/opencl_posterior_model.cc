#include "kernels/ops/opencl_posterior_model.h"

#include <algorithm>

#include "kernels/ops/kernel_options.h"
#include "kernels/runtime/buffer.h"

namespace egosieve::kernels::opencl {
namespace {

std::vector<double> CentreOfModel(const PosteriorModel& model) {
  const int64_t dimension = model.covariance.input_dimension();
  return model.inputs.rows > 0 ? CentreOf(model.inputs) : std::vector<double>(dimension, 0.0);
}

}  // namespace

DeviceModel::DeviceModel(const Context& context, const PosteriorModel& model,
                         const FactorBlocking& blocking)
    : covariance_(model.covariance),
      factor_kind_(model.inputs.rows == 0 ? FactorKind::kNone : model.factor_kind),
      squash_a_(static_cast<float>(model.squash_a)),
      squash_b_(static_cast<float>(model.squash_b)),
      count_(model.inputs.rows),
      preparation_(covariance_, CentreOfModel(model)) {
  const double signal_variance = covariance_.signal_stddev * covariance_.signal_stddev;
  host_.inputs = PrepareRows<double, float>(preparation_, model.inputs);
  const ConstMatrixView<float> points(host_.inputs.data(), count_, preparation_.width());
  code_ = CovarianceCodeFor(covariance_, points);
  DeviceCodeRequest request;
  request.dimension = covariance_.input_dimension();
  request.points = points;
  note_ = covariance_.function.description().DeviceNote(request);
  for (int64_t i = 0; i < count_; ++i) {
    host_.alpha.push_back(static_cast<float>(signal_variance * model.alpha[i]));
  }
  // Buffers must not be empty.
  host_.inputs.resize(std::max<size_t>(host_.inputs.size(), 1));
  host_.alpha.resize(std::max<size_t>(host_.alpha.size(), 1));
  inputs_ = InputBuffer(context, host_.inputs);
  alpha_ = InputBuffer(context, host_.alpha);
  if (factor_kind_ != FactorKind::kNone) {
    host_.factor = PackFactor(factor_kind_, model.factor, blocking);
    factor_ = InputBuffer(context, host_.factor);
  } else {
    factor_ = alpha_;
  }
}

}  // namespace egosieve::kernels::opencl
