#include "kernels/covariance/covariance_function.h"

#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "kernels/covariance/covariance_expression.h"

namespace egosieve::kernels {
namespace {

// All names and compositions requested so far; they are never removed.
struct Known {
  std::mutex mutex;
  CovarianceNames named, composed;
};

Known& AllKnown() {
  static Known& known = *new Known;
  return known;
}

}  // namespace

ScaleGroup LengthScales() {
  return {true, ScaleGroup::Unit::kInput, 0.5, std::log(0.02), std::log(20.0)};
}

CovarianceDescription::CovarianceDescription(std::vector<ScaleGroup> groups)
    : groups_(std::move(groups)) {
  for (const ScaleGroup& group : groups_) {
    if (group.per_input && group.columns.empty()) {
      ++per_input_;
    } else {
      fixed_ += group.ScaleCount(0);
    }
  }
}

int64_t CovarianceDescription::DimensionOf(int64_t scale_count) const {
  if (per_input_ == 0 || (scale_count - fixed_) % per_input_ != 0) return 0;
  return (scale_count - fixed_) / per_input_;
}

std::string WithSuffix(std::string_view text, const DeviceCodeRequest& request) {
  return absl::StrReplaceAll(absl::string_view(text.data(), text.size()),
                             {{"@", request.suffix}, {"$D", absl::StrCat(request.dimension)}});
}

CovarianceRegistration::CovarianceRegistration(
    const char* name, std::unique_ptr<const CovarianceDescription> function) {
  AllKnown().named.emplace(name, std::move(function));
}

absl::StatusOr<CovarianceFunction> CovarianceFunction::Parse(std::string_view text) {
  Known& known = AllKnown();
  const std::lock_guard lock(known.mutex);
  absl::StatusOr<NamedDescription> parsed = ParseCovariance(text, known.named);
  if (!parsed.ok()) return parsed.status();
  if (const auto named = known.named.find(parsed->text); named != known.named.end()) {
    return CovarianceFunction(named->first.c_str());
  }
  const auto [place, added] =
      known.composed.emplace(std::move(parsed->text), std::move(parsed->description));
  return CovarianceFunction(place->first.c_str());
}

std::vector<std::string> CovarianceFunction::Names() {
  std::vector<std::string> names;
  for (const auto& [name, description] : AllKnown().named) names.push_back(name);
  return names;
}

const CovarianceDescription& CovarianceFunction::description() const {
  Known& known = AllKnown();
  const std::lock_guard lock(known.mutex);
  if (const auto named = known.named.find(text()); named != known.named.end()) {
    return *named->second;
  }
  return *known.composed.find(text())->second;
}

}  // namespace egosieve::kernels
