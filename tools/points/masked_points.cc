#include "tools/points/masked_points.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

struct Votes {
  int64_t seen = 0, masked = 0;

  bool drop() const { return seen > 0 && 2 * masked >= seen; }
};

}  // namespace

absl::StatusOr<MaskedPoints> DropMaskedPoints(
    absl::FunctionRef<absl::StatusOr<cv::Mat1b>(const SparseImage&)> mask, SparseModel& model) {
  const auto cameras = PlacesById(model.cameras);
  const auto points = PlacesById(model.points);
  std::vector<Votes> votes(model.points.size());
  MaskedPoints result;
  result.points = static_cast<int64_t>(model.points.size());
  result.images = static_cast<int64_t>(model.images.size());
  for (const SparseImage& image : model.images) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b pixels, mask(image));
    const SparseCamera& camera = model.cameras[cameras.at(image.camera)];
    if (!pixels.empty() && (static_cast<uint64_t>(pixels.cols) != camera.width ||
                            static_cast<uint64_t>(pixels.rows) != camera.height)) {
      return absl::OutOfRangeError(absl::StrFormat(
          "the mask of %s has %d x %d pixels, its camera %d x %d; give the masks of the pictures "
          "that the model is of",
          image.name, pixels.cols, pixels.rows, camera.width, camera.height));
    }
    result.images_with_mask += !pixels.empty();
    for (const Observation& observation : image.observations) {
      if (observation.point == kNoPoint) continue;
      const auto place = points.find(observation.point);
      if (place == points.end()) {
        return absl::DataLossError(absl::StrCat(image.name, " observes point ", observation.point,
                                                ", which the model lacks; write it again"));
      }
      const double x = std::floor(observation.x), y = std::floor(observation.y);
      if (!(x >= 0.0 && x < pixels.cols && y >= 0.0 && y < pixels.rows)) continue;
      Votes& vote = votes[place->second];
      ++vote.seen;
      vote.masked += pixels(static_cast<int>(y), static_cast<int>(x)) == 0;
    }
  }
  std::vector<SparsePoint> kept;
  for (size_t i = 0; i < votes.size(); ++i) {
    if (!votes[i].drop()) kept.push_back(std::move(model.points[i]));
  }
  result.dropped = result.points - static_cast<int64_t>(kept.size());
  model.points = std::move(kept);
  for (SparseImage& image : model.images) {
    for (Observation& observation : image.observations) {
      const auto place = points.find(observation.point);
      if (place != points.end() && votes[place->second].drop()) observation.point = kNoPoint;
    }
  }
  return result;
}

}  // namespace egosieve::tools
