#include "tools/segment/method_flag.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tools/cli/checks.h"
#include "vision/segmentation/methods/map_method.h"

namespace egosieve::tools {
namespace {

constexpr char kArcsine[] = "arcsine";
constexpr char kSquaredExponential[] = "squared_exponential";

}  // namespace

void MethodFlag::AddFlag(CLI::App& app) {
  std::vector<std::string> names;
  for (const vision::MethodName& method : vision::MethodNames()) names.push_back(method.name);
  app.add_option("--method", name_,
                 "The method: the Gaussian process (the first two, as --covariance) or a baseline, "
                 "for comparison; baselines write no checkpoints and, except svm, learn nothing")
      ->check(OneOf(names))
      ->type_name(absl::StrJoin(names, "|"));
}

bool MethodFlag::is_rival() const {
  return !name_.empty() && name_ != kArcsine && name_ != kSquaredExponential;
}

void MethodFlag::Apply(vision::OnlineSegmenterOptions& options) const {
  if (name_ == kArcsine) options.learner.covariance = kernels::CovarianceFunction::kArcsine;
  if (name_ == kSquaredExponential)
    options.learner.covariance = kernels::CovarianceFunction::kSquaredExponential;
}

absl::Status MethodFlag::CheckWith(bool resume, bool leaves_maps) const {
  if (!is_rival() || (!resume && !leaves_maps)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--method=", name_, " keeps no checkpoints and makes every map; leave ",
                   resume ? "--resume" : "--every", " out"));
}

}  // namespace egosieve::tools
