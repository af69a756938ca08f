#include "vision/tracking/feature_tracker.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/matching/descriptor_search.h"

namespace egosieve::vision {
namespace {

// For each feature of the current frame its match in the frame before, or -1.
absl::StatusOr<std::vector<int32_t>> Predecessors(const std::vector<Match>& matches, int64_t before,
                                                  int64_t now) {
  std::vector<int32_t> predecessors(now, -1);
  std::vector<bool> taken(before, false);
  for (const Match& match : matches) {
    if (match.first < 0 || match.first >= before || match.second < 0 || match.second >= now) {
      return absl::InvalidArgumentError(
          absl::StrCat("match of feature ", match.first, " with ", match.second,
                       " is out of range; the frames have ", before, " and ", now, " features"));
    }
    if (taken[match.first] || predecessors[match.second] >= 0) {
      return absl::InvalidArgumentError(absl::StrCat("feature ", match.first, " or ", match.second,
                                                     " is matched twice; matches must be mutual"));
    }
    taken[match.first] = true;
    predecessors[match.second] = match.first;
  }
  return predecessors;
}

SiftDescriptor Descriptor(const FeatureSet& features, int64_t i) {
  SiftDescriptor descriptor;
  std::copy_n(features.descriptor(i), kSiftDescriptorBytes, descriptor.begin());
  return descriptor;
}

}  // namespace

absl::Status FeatureTrackerOptions::Validate() const {
  return kernels::CheckOptions({
      {"max_descriptor_distance", max_descriptor_distance,
       kernels::IsPositive(max_descriptor_distance), "be positive"},
      {"reference_frames", reference_frames, reference_frames >= 1, "be positive"},
      {"frame_step", frame_step, frame_step >= 1, "be positive"},
  });
}

absl::StatusOr<FeatureTracker> FeatureTracker::Create(const FeatureTrackerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return FeatureTracker(options);
}

absl::Status FeatureTracker::Advance(int64_t frame_index, const FeatureSet& features,
                                     const std::vector<Match>& matches) {
  if (frame_index < 0 || frame_index <= state_.frame_index) {
    return absl::InvalidArgumentError(absl::StrCat("frame ", frame_index, " after frame ",
                                                   state_.frame_index, "; indices must grow"));
  }
  if (static_cast<int64_t>(features.descriptors.size()) != features.size() * kSiftDescriptorBytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        features.descriptors.size(), " descriptor bytes for ", features.size(), " features"));
  }
  const bool follows =
      !state_.tracks.empty() && frame_index == state_.frame_index + options_.frame_step;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int32_t> predecessors,
                            Predecessors(follows ? matches : std::vector<Match>(),
                                         state_.tracks.size(), features.size()));

  FeatureTrackerState next;
  next.frame_index = frame_index;
  next.next_id = state_.next_id;
  next.tracks.reserve(features.size());
  next.references.reserve(features.size());
  next.reference_ages.reserve(features.size());
  const double limit = options_.max_descriptor_distance * options_.max_descriptor_distance;
  for (int64_t i = 0; i < features.size(); ++i) {
    const int32_t before = predecessors[i];
    const bool continues = before >= 0 && SquaredDistance(state_.references[before].data(),
                                                          features.descriptor(i)) <= limit;
    if (!continues) {
      Track born;
      born.id = next.next_id++;
      born.length = 1;
      born.places[0] = features.positions[i];
      next.tracks.push_back(born);
      next.references.push_back(Descriptor(features, i));
      next.reference_ages.push_back(0);
      continue;
    }
    next.tracks.push_back(state_.tracks[before].Continued(features.positions[i]));
    const int32_t age = state_.reference_ages[before] + 1;
    const bool renew = age >= options_.reference_frames;
    next.references.push_back(renew ? Descriptor(features, i) : state_.references[before]);
    next.reference_ages.push_back(renew ? 0 : age);
  }
  state_ = std::move(next);
  return absl::OkStatus();
}

void FeatureTracker::EndAll() {
  state_.tracks.clear();
  state_.references.clear();
  state_.reference_ages.clear();
}

absl::Status FeatureTracker::Restore(FeatureTrackerState state) {
  if (state.references.size() != state.tracks.size() ||
      state.reference_ages.size() != state.tracks.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "tracker state has ", state.tracks.size(), " tracks, ", state.references.size(),
        " references and ", state.reference_ages.size(), " ages; they must be as many"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckTracks("tracker state", state.tracks, state.next_id));
  state_ = std::move(state);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
