#include "vision/labelling/evidence_labeller.h"

#include <algorithm>
#include <utility>

#include "kernels/base/status_macros.h"
#include "vision/frame/ignored_area.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr int kStride = FrameLabellerOptions::kFlowStridePixels;
constexpr int kSupportRadius = 2;  // nodes
constexpr double kSupportShare = 0.45;

// Whether enough nodes around node n were followed as well.
bool IsSupported(const std::vector<uint8_t>& followed, cv::Size nodes, int n) {
  const int row = n / nodes.width, column = n % nodes.width;
  int count = 0, sum = 0;
  for (int y = std::max(0, row - kSupportRadius);
       y <= std::min(nodes.height - 1, row + kSupportRadius); ++y) {
    for (int x = std::max(0, column - kSupportRadius);
         x <= std::min(nodes.width - 1, column + kSupportRadius); ++x) {
      ++count;
      sum += followed[y * nodes.width + x];
    }
  }
  return sum >= kSupportShare * count;
}

}  // namespace

EvidenceLabeller::EvidenceLabeller(const FrameLabellerOptions& options)
    : ignored_(options.ignored), windscreen_(options.windscreen), grid_(kStride) {}

void EvidenceLabeller::Begin(int64_t frame_index) {
  ++state_.picture;
  state_.frame_indices = {frame_index};
  grid_.EndAll();
  is_textured_.clear();
  accumulator_.Interrupt();
}

void EvidenceLabeller::Advance(const ExtractedFrame& frame, const TrackedGrid& grid) {
  AdvanceGrid(frame.grey.size(), grid);
  ++state_.picture;
  state_.frame_indices.push_back(frame.frame.index);
  if (state_.frame_indices.size() > kTrackHistory) {
    state_.frame_indices.erase(state_.frame_indices.begin());
  }
}

void EvidenceLabeller::AdvanceGrid(cv::Size size, const TrackedGrid& grid) {
  is_textured_.clear();
  if (grid.pairs.empty()) return grid_.EndAll();
  // A tracker without links in the last picture starts in that picture.
  if (grid_.state().frame_index != state_.picture || grid_.tracks().empty()) {
    grid_.EndAll();
    if (grid_.state().frame_index < state_.picture) grid_.Advance(state_.picture, size, {});
  }
  grid_.Advance(state_.picture + 1, size, grid.pairs);
  is_textured_.assign(grid_.tracks().size(), 0);
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    const PointPair& pair = grid.pairs[i];
    is_textured_[NodeAt(pair.x2, pair.y2, grid_.state().nodes.width, kStride)] =
        grid.is_textured[i];
  }
}

std::vector<TrackedPoint> EvidenceLabeller::Points(int gap, const GridLinks& ahead) const {
  const cv::Size nodes = ahead.empty() ? grid_.state().nodes : ahead.nodes;
  const bool has_tracks = static_cast<int>(grid_.tracks().size()) == nodes.area();
  const auto flags = [&](const auto& is_followed) {
    std::vector<uint8_t> followed(nodes.area(), 0);
    for (int n = 0; n < nodes.area(); ++n) followed[n] = is_followed(n) ? 1 : 0;
    return followed;
  };
  const auto reaches = [&](int pictures) {
    return flags([&](int n) { return has_tracks && grid_.tracks()[n].Reaches(pictures); });
  };
  const std::vector<uint8_t> far_behind = reaches(gap);
  const std::vector<uint8_t> near_behind = gap > 1 ? reaches(1) : far_behind;
  const std::vector<uint8_t> far_ahead =
      flags([&](int n) { return !ahead.empty() && std::isfinite(ahead.far[n].x); });
  const std::vector<uint8_t> near_ahead =
      flags([&](int n) { return !ahead.empty() && std::isfinite(ahead.near[n].x); });
  const auto holds = [&](const std::vector<uint8_t>& followed, int n) {
    return followed[n] != 0 && IsSupported(followed, nodes, n);
  };
  std::vector<TrackedPoint> points;
  for (int n = 0; n < nodes.area(); ++n) {
    const bool tracked = far_behind[n] != 0;
    TrackedPoint point;
    const cv::Point2f now = point.evidence.now = PlaceOfNode(n, nodes.width, kStride);
    if (IsIgnored(windscreen_, windscreen_.size(), now.x, now.y)) continue;
    // The longer span if it can be followed, else the shorter one.
    if (holds(far_ahead, n)) {
      point.far_ahead = ahead.far[n];
    } else if (holds(near_ahead, n)) {
      point.near_ahead = ahead.near[n];
    }
    const bool is_ahead = std::isfinite(point.far_ahead.x) || std::isfinite(point.near_ahead.x);
    const bool is_behind = holds(far_behind, n);
    if (tracked && (is_behind || !is_ahead)) {
      point.evidence.before = grid_.tracks()[n].places[gap];
    } else if (holds(near_behind, n)) {
      point.near_behind = grid_.tracks()[n].places[1];
    }
    const bool is_near = std::isfinite(point.near_behind.x);
    if (!is_ahead && !is_near && !tracked) continue;
    point.is_supported = is_ahead || is_behind || is_near;
    if (has_tracks) {
      point.evidence.track_id = grid_.tracks()[n].id;
      point.evidence.parent_id = grid_.tracks()[n].parent_id;
    }
    point.is_textured = near_behind[n] != 0 ? is_textured_[n] != 0 : ahead.is_textured[n] != 0;
    point.evidence.estimates = point.is_textured;
    points.push_back(point);
  }
  return points;
}

std::vector<cv::Point2f> EvidenceLabeller::UnfollowedPlaces(int gap, cv::Size image) const {
  std::vector<cv::Point2f> places;
  const cv::Size nodes = grid_.state().nodes;
  std::vector<uint8_t> reached;
  reached.reserve(grid_.tracks().size());
  for (const Track& track : grid_.tracks()) reached.push_back(track.Reaches(gap) ? 1 : 0);
  for (int n = 0; n < static_cast<int>(reached.size()); ++n) {
    if (reached[n] != 0 && IsSupported(reached, nodes, n)) continue;
    const cv::Point2f place = PlaceOfNode(n, nodes.width, kStride);
    if (!IsIgnored(ignored_, image, place.x, place.y)) places.push_back(place);
  }
  return places;
}

EvidenceResult EvidenceLabeller::Judge(const ExtractedFrame* before, const ExtractedFrame& frame,
                                       int gap, const std::vector<TrackedPoint>& points,
                                       const TwoViewMotion* world, const Pinhole& camera,
                                       std::initializer_list<const View*> views) {
  EvidenceFrame evidence;
  evidence.index = state_.picture;
  evidence.size = frame.grey.size();
  evidence.camera = camera;
  if (world != nullptr) evidence.world = *world;
  for (const View* view : views) {
    if (view->frame == nullptr) continue;
    EvidenceView& other = evidence.views.emplace_back();
    other.motion = view->motion;
    other.grey = view->frame->grey;
    other.pictures = static_cast<int>(view->frame->frame.index - frame.frame.index);
    other.places.reserve(points.size());
    for (const TrackedPoint& point : points) other.places.push_back(point.*view->place);
  }
  evidence.points.reserve(points.size());
  for (const TrackedPoint& point : points) evidence.points.push_back(point.evidence);
  if (before != nullptr || !evidence.views.empty()) evidence.grey = frame.grey;
  if (before != nullptr) {
    evidence.pictures = static_cast<int>(frame.frame.index - before->frame.index);
    evidence.grey_before = before->grey;
    evidence.unfollowed = UnfollowedPlaces(gap, frame.grey.size());
  }
  return accumulator_.Add(evidence);
}

EvidenceLabellerState EvidenceLabeller::state() const {
  EvidenceLabellerState state = state_;
  state.grid = grid_.state();
  state.evidence = accumulator_.state();
  return state;
}

absl::Status EvidenceLabeller::Restore(EvidenceLabellerState state) {
  EGOSIEVE_RETURN_IF_ERROR(grid_.Restore(std::move(state.grid)));
  EGOSIEVE_RETURN_IF_ERROR(accumulator_.Restore(std::move(state.evidence)));
  state_ = EvidenceLabellerState();
  state_.picture = state.picture;
  state_.frame_indices = std::move(state.frame_indices);
  is_textured_.clear();
  return absl::OkStatus();
}

}  // namespace egosieve::vision
