#include "vision/labelling/pair_builder.h"

#include <algorithm>
#include <utility>

#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/ignored_area.h"
#include "vision/labelling/stopwatch.h"
#include "vision/matching/neighbour_agreement.h"

namespace egosieve::vision {
namespace {

// Least share of the features that agree with their neighbours if the predicted windows are right.
constexpr double kWindowsSuffice = 0.05;

// Flow between the two frames, and its reliability.
struct GridFlow {
  FlowPair fields;     // empty if the frames are too small
  double share = 0.0;  // share of the grid's textured points whose flow passes its checks

  bool Suffices() const { return share >= kFlowSuffices; }
};

double Share(int64_t part, int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<int64_t>(whole, 1));
}

// Predicts the places in the second frame of features of the first.
struct Prediction {
  const GridFlow& flow;
  const MotionField& motion;
  int pictures;
};

struct CheckedMatches {
  std::vector<Match> matches;
  std::vector<PointPair> places;  // one per match
  std::vector<uint8_t> agrees;    // with its neighbours
  int64_t agreeing_count = 0;
};

CheckedMatches Check(std::vector<Match> matches, const FeatureSet& a, const FeatureSet& b) {
  CheckedMatches checked;
  for (const Match& match : matches) {
    const cv::Point2f p = a.positions[match.first], q = b.positions[match.second];
    checked.places.push_back({p.x, p.y, q.x, q.y});
  }
  checked.matches = std::move(matches);
  checked.agrees = AgreesWithNeighbours(checked.places, {});
  checked.agreeing_count = std::count(checked.agrees.begin(), checked.agrees.end(), 1);
  return checked;
}

absl::StatusOr<CheckedMatches> FindMatches(const FeatureSet& a, const FeatureSet& b,
                                           const Prediction& prediction, bool windowed,
                                           const MatchOptions& options) {
  std::vector<cv::Point2f> places;
  if (windowed && prediction.flow.Suffices()) {
    for (const cv::Point2f& p : a.positions) {
      places.push_back(p + SampleField(prediction.flow.fields.forward, p));
    }
  } else if (windowed && !prediction.motion.empty()) {
    places = PredictPlaces(prediction.motion, a.positions, prediction.pictures);
  }
  if (!places.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<Match> matches, MatchFeaturesNear(a, b, places, options));
    CheckedMatches checked = Check(std::move(matches), a, b);
    if (Share(checked.agreeing_count, std::min(a.size(), b.size())) >= kWindowsSuffice) {
      return checked;
    }
  }
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<Match> matches, MatchFeatures(a, b, options));
  return Check(std::move(matches), a, b);
}

absl::Status AddFeatureMatches(const ExtractedFrame& first, const ExtractedFrame& second,
                               const Prediction& prediction, const FrameLabellerOptions& options,
                               Stopwatch& watch, FramePairs& pairs) {
  if (!first.features().ok()) return first.features().status();
  if (!second.features().ok()) return second.features().status();
  pairs.features_milliseconds += std::max(watch.LapMilliseconds(), second.features_milliseconds());
  const FeatureSet& a = *first.features();
  const FeatureSet& b = *second.features();
  MatchOptions matching;
  matching.ratio = options.match_ratio;
  matching.threads = options.threads;
  EGOSIEVE_ASSIGN_OR_RETURN(const CheckedMatches found,
                            FindMatches(a, b, prediction, options.windowed_search, matching));
  for (size_t i = 0; i < found.matches.size(); ++i) {
    if (options.drop_lone_matches && found.agrees[i] == 0) continue;
    if (IsIgnored(options.ignored, second.grey.size(), found.places[i].x2, found.places[i].y2)) {
      continue;
    }
    pairs.labelled.push_back(found.places[i]);
    pairs.geometry.push_back(found.places[i]);
    pairs.matches.push_back(found.matches[i]);
  }
  pairs.feature_count += b.size();
  pairs.match_count += static_cast<int64_t>(found.matches.size());
  std::vector<uint8_t> agrees(b.size(), 0);
  for (size_t i = 0; i < found.matches.size(); ++i) {
    agrees[found.matches[i].second] = found.agrees[i];
  }
  for (int64_t i = 0; i < b.size(); ++i) pairs.scene.AddFeature(b.positions[i], agrees[i] != 0);
  pairs.matching_milliseconds += watch.LapMilliseconds();
  return absl::OkStatus();
}

// Tracked grid points count as features, and the time for flow as time for features.
absl::StatusOr<GridFlow> AddFlowGrid(const ExtractedFrame& first, const ExtractedFrame& second,
                                     const FrameLabellerOptions& options, FlowCache& flows,
                                     Stopwatch& watch, FramePairs& pairs) {
  GridFlow flow;
  if (!IsLargeEnoughForFlow(second.grey.size())) return flow;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const FlowPair> fields,
                            flows.Between(first, second));
  flow.fields = *fields;
  pairs.features_milliseconds += watch.LapMilliseconds();
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::shared_ptr<const TrackedGrid> grid,
      flows.Grid(first, second, options.labelled_side == LabelledSide::kCurrentFrame));
  const TrackedGrid& tracked = *grid;
  pairs.labelled.insert(pairs.labelled.end(), tracked.pairs.begin(), tracked.pairs.end());
  for (size_t i = 0; i < tracked.pairs.size(); ++i) {
    if (tracked.is_textured[i] != 0) pairs.geometry.push_back(tracked.pairs[i]);
  }
  pairs.links = tracked.pairs;
  pairs.link_is_textured = tracked.is_textured;
  pairs.feature_count += tracked.textured_count;
  pairs.match_count += tracked.agreeing_count;
  for (size_t i = 0; i < tracked.textured.size(); ++i) {
    pairs.scene.AddFlow(tracked.textured[i], tracked.agrees[i] != 0);
  }
  pairs.matching_milliseconds += watch.LapMilliseconds();
  flow.share = Share(tracked.agreeing_count, tracked.textured_count);
  return flow;
}

}  // namespace

FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options) {
  FlowGridOptions grid;
  grid.stride_pixels = options.flow_stride_pixels;
  grid.quality = options.flow_quality;
  grid.searches_lost = options.searches_lost;
  grid.ignored = options.ignored;
  return grid;
}

absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      const MotionField& motion, int pictures,
                                      const FrameLabellerOptions& options, FlowCache& flows) {
  FramePairs pairs;
  pairs.scene = SceneAgreement(second.grey.size());
  Stopwatch watch;
  GridFlow flow;
  if (options.features != FeatureSource::kSiftCorners) {
    EGOSIEVE_ASSIGN_OR_RETURN(flow, AddFlowGrid(first, second, options, flows, watch, pairs));
  }
  const bool wants_features = options.features == FeatureSource::kSiftCorners ||
                              options.features == FeatureSource::kBoth ||
                              (options.features == FeatureSource::kAuto && !flow.Suffices());
  if (wants_features) {
    EGOSIEVE_RETURN_IF_ERROR(
        AddFeatureMatches(first, second, {flow, motion, pictures}, options, watch, pairs));
  }
  return pairs;
}

}  // namespace egosieve::vision
