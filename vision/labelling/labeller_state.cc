#include "vision/labelling/labeller_state.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace egosieve::vision {
namespace {

constexpr uint64_t kMagic = 0x3231'6c62'616c'6765;  // "egalbl12"

// Walk() is used for both directions: with a Writer it appends the state to bytes, with a Reader it
// sets the state from bytes.
class Writer {
 public:
  template <typename Number>
  void Plain(const Number& value) {
    static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  void Flag(const bool& value) { Plain(static_cast<uint8_t>(value ? 1 : 0)); }
  template <typename Number>
  void Block(const Number* values, size_t count) {
    if (count > 0) bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(Number));
  }
  template <typename Item>
  bool Count(const std::vector<Item>& items, size_t /*bytes_each*/) {
    Plain(static_cast<uint64_t>(items.size()));
    return true;
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(absl::string_view bytes) : rest_(bytes) {}
  template <typename Number>
  void Plain(Number& value) {
    static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
    Block(&value, 1);
  }
  void Flag(bool& value) {
    uint8_t byte = 0;
    Plain(byte);
    ok_ = ok_ && byte <= 1;
    value = byte == 1;
  }
  template <typename Number>
  void Block(Number* values, size_t count) {
    if (!ok_ || rest_.size() / sizeof(Number) < count) {
      ok_ = false;
      return;
    }
    if (count == 0) return;
    std::memcpy(values, rest_.data(), count * sizeof(Number));
    rest_.remove_prefix(count * sizeof(Number));
  }
  // Resizes `items`, but never beyond the number that the remaining bytes can hold.
  template <typename Item>
  bool Count(std::vector<Item>& items, size_t bytes_each) {
    uint64_t count = 0;
    Plain(count);
    ok_ = ok_ && count <= rest_.size() / bytes_each;
    items.resize(ok_ ? count : 0);
    return ok_;
  }
  bool IsWhole() const { return ok_ && rest_.empty(); }

 private:
  absl::string_view rest_;
  bool ok_ = true;
};

// In the functions below the state is const for a Writer.
template <typename Archive, typename Points>
void WalkPlaces(Archive& archive, Points& places) {
  static_assert(sizeof(cv::Point2f) == 2 * sizeof(float));
  archive.Block(&places[0].x, 2 * places.size());
}

template <typename Archive, typename Tracks>
void WalkTracks(Archive& archive, Tracks& tracks) {
  if (!archive.Count(tracks, 3 * sizeof(int64_t) + sizeof(Track::places))) return;
  for (auto& track : tracks) {
    archive.Plain(track.id);
    archive.Plain(track.parent_id);
    archive.Plain(track.length);
    WalkPlaces(archive, track.places);
  }
}

template <typename Archive, typename State>
void WalkGrid(Archive& archive, State& grid) {
  archive.Plain(grid.frame_index);
  archive.Plain(grid.next_id);
  archive.Plain(grid.nodes.width);
  archive.Plain(grid.nodes.height);
  WalkTracks(archive, grid.tracks);
}

template <typename Archive, typename Motion>
void WalkTwoViews(Archive& archive, Motion& motion) {
  archive.Flag(motion.found);
  archive.Block(motion.rotation.data(), 9);
  archive.Block(motion.translation.data(), 3);
  for (auto* number : {&motion.mean_parallax, &motion.noise, &motion.static_share,
                       &motion.moving_scale, &motion.log_likelihood, &motion.noise_pixels,
                       &motion.parallax_pixels, &motion.ground_slope, &motion.ground_heights}) {
    archive.Plain(*number);
  }
  archive.Flag(motion.scatters);
  bool has_travel = motion.travel.has_value();
  archive.Flag(has_travel);
  Eigen::Vector3d travel = motion.travel.value_or(Eigen::Vector3d::Zero());
  archive.Block(travel.data(), 3);
  if constexpr (!std::is_const_v<Motion>) {
    if (has_travel) motion.travel = travel;
  }
}

template <typename Archive, typename State>
void WalkEvidence(Archive& archive, State& evidence) {
  archive.Plain(evidence.last_index);
  archive.Plain(evidence.size.width);
  archive.Plain(evidence.size.height);
  if (!archive.Count(evidence.memories, sizeof(int64_t) + kEvidenceTerms * sizeof(double))) return;
  for (auto& memory : evidence.memories) {
    archive.Plain(memory.track_id);
    archive.Block(memory.sums.data(), memory.sums.size());
  }
  archive.Plain(evidence.mover_share);
}

template <typename Archive, typename Tracks>
void WalkKept(Archive& archive, Tracks& kept) {
  archive.Plain(kept.pictures);
  if (!archive.Count(kept.tracks, sizeof(uint64_t))) return;
  for (auto& track : kept.tracks) {
    if (!archive.Count(track, sizeof(cv::Point2f))) return;
    if (!track.empty()) WalkPlaces(archive, track);
  }
}

template <typename Archive, typename State>
void WalkFocal(Archive& archive, State& focal) {
  archive.Plain(focal.learnt.focal_ratio);
  archive.Plain(focal.learnt.log_focal_deviation);
  archive.Block(focal.learnt.travel.direction.data(), 3);
  archive.Plain(focal.learnt.travel.concentration);
  archive.Plain(focal.learnt.travel.share);
  if (!archive.Count(focal.directions, 3 * sizeof(double))) return;
  for (auto& direction : focal.directions) archive.Block(direction.data(), 3);
  archive.Plain(focal.first_seconds);
  archive.Plain(focal.next_seconds);
  archive.Plain(focal.size.width);
  archive.Plain(focal.size.height);
  archive.Plain(focal.last_index);
  archive.Plain(focal.pictures);
  archive.Plain(focal.window_start);
  archive.Plain(focal.next_start);
  archive.Flag(focal.has_ended);
  if (!archive.Count(focal.windows, sizeof(int32_t) + sizeof(uint64_t))) return;
  for (auto& window : focal.windows) WalkKept(archive, window);
  archive.Plain(focal.start_seconds);
  WalkKept(archive, focal.under_way);
}

template <typename Archive, typename State>
void Walk(Archive& archive, State& state) {
  archive.Plain(state.gap.gap);
  archive.Flag(state.gap.has_parallax);
  archive.Plain(state.gap.log_parallax);
  archive.Block(state.ground.probabilities.data(), state.ground.probabilities.size());
  archive.Plain(state.ground.seconds);
  archive.Plain(state.ground.onward);
  if (!archive.Count(state.moved, sizeof(float))) return;
  archive.Block(state.moved.data(), state.moved.size());
  if (!archive.Count(state.motions, 2 * sizeof(int64_t) + 24 * sizeof(double))) return;
  for (auto& pair : state.motions) {
    archive.Plain(pair.first);
    archive.Plain(pair.second);
    WalkTwoViews(archive, pair.motion);
  }
  archive.Plain(state.evidence.picture);
  if (!archive.Count(state.evidence.frame_indices, sizeof(int64_t))) return;
  archive.Block(state.evidence.frame_indices.data(), state.evidence.frame_indices.size());
  WalkGrid(archive, state.evidence.grid);
  WalkEvidence(archive, state.evidence.evidence);
  bool has_focal = state.focal.has_value();
  archive.Flag(has_focal);
  if constexpr (!std::is_const_v<State>) {
    if (has_focal) state.focal.emplace();
  }
  if (state.focal) WalkFocal(archive, *state.focal);
}

// least, most: pictures of a window, if it has any. Its tracks have at least `least` positions.
bool IsSensible(const KeptTracks& kept, size_t least, int most) {
  const auto is_finite = [](cv::Point2f at) { return std::isfinite(at.x) && std::isfinite(at.y); };
  if (kept.pictures == 0) return kept.tracks.empty();
  return kept.pictures >= static_cast<int>(least) && kept.pictures <= most &&
         kept.tracks.size() <= size_t{CornerTracker::kMostCorners} &&
         std::all_of(kept.tracks.begin(), kept.tracks.end(), [&](const CornerTrack& track) {
           return track.size() >= least && static_cast<int>(track.size()) <= kept.pictures &&
                  std::all_of(track.begin(), track.end(), is_finite);
         });
}

bool IsSensible(const FocalLearnerState& focal) {
  const auto is_count = [](int64_t n) { return n >= 0 && n < (int64_t{1} << 60); };
  return focal.learnt.focal_ratio >= 0.0 && std::isfinite(focal.learnt.focal_ratio) &&
         std::abs(focal.learnt.travel.direction.norm() - 1.0) < 1e-6 &&
         focal.learnt.travel.concentration > 0.0 && focal.learnt.travel.share >= 0.0 &&
         focal.learnt.travel.share < 1.0 && std::isfinite(focal.learnt.travel.concentration) &&
         focal.learnt.log_focal_deviation >= 0.0 &&
         std::isfinite(focal.learnt.log_focal_deviation) && is_count(focal.pictures) &&
         is_count(focal.window_start) && is_count(focal.next_start) &&
         std::all_of(
             focal.directions.begin(), focal.directions.end(),
             [](const auto& direction) { return std::abs(direction.norm() - 1.0) < 1e-6; }) &&
         focal.windows.size() < size_t{kMostWindows} &&
         std::all_of(focal.windows.begin(), focal.windows.end(),
                     [](const KeptTracks& kept) { return IsSensible(kept, 3, kKeptPictures); }) &&
         IsSensible(focal.under_way, 1, kLongestWindow);
}

bool IsSensible(const LabellerState& state) {
  const auto& indices = state.evidence.frame_indices;
  return std::isfinite(state.gap.log_parallax) && state.gap.gap >= 1 && state.gap.gap <= 100 &&
         indices.size() <= kTrackHistory && std::is_sorted(indices.begin(), indices.end()) &&
         (!state.focal || IsSensible(*state.focal));
}

}  // namespace

std::string ToBytes(const LabellerState& state) {
  Writer writer;
  writer.Plain(kMagic);
  Walk(writer, state);
  return writer.Take();
}

absl::StatusOr<LabellerState> FromBytes(absl::string_view bytes) {
  Reader reader(bytes);
  uint64_t magic = 0;
  LabellerState state;
  reader.Plain(magic);
  if (magic == kMagic) Walk(reader, state);
  if (magic != kMagic || !reader.IsWhole() || !IsSensible(state)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the labeller's state (", bytes.size(), " bytes) is not one of this version"));
  }
  return state;
}

}  // namespace egosieve::vision
