#include "tools/run_folder/baselines.h"

#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr double kLeastFollowed = 0.7;
// A cut now and then does not make a run sparse.
constexpr double kSparseShare = 0.1;

}  // namespace

Baselines::Baselines(const RunDescription& description) {
  const auto features = description.flags.find("features");
  by_flow_ = features != description.flags.end() &&
             (features->second == "auto" || features->second == "flow");
}

void Baselines::Add(const FrameLine& line) {
  if (!by_flow_ || line.features == 0) return;
  ++pairs_;
  far_apart_ +=
      static_cast<double>(line.matches) < kLeastFollowed * static_cast<double>(line.features);
}

std::string Baselines::Describe() const {
  if (far_apart_ == 0 ||
      static_cast<double>(far_apart_) < kSparseShare * static_cast<double>(pairs_)) {
    return "";
  }
  return absl::StrCat(far_apart_, " of ", pairs_,
                      " pairs of pictures lie too far apart to be followed well, and movers are "
                      "missed there; segment all pictures, or the video that they were taken "
                      "from: egosieve masks PICTURES --from_video=FILE");
}

}  // namespace egosieve::tools
