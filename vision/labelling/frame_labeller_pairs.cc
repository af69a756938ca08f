// The steps of frame_labeller.h after extraction: labels from a pair of frames, or from tracks and
// the pictures ahead.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/sampling.h"
#include "vision/labelling/frame_labeller_implementation.h"
#include "vision/labelling/frame_step.h"
#include "vision/labelling/lines_along_travel.h"
#include "vision/labelling/place_labels.h"
#include "vision/labelling/stopwatch.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr uint64_t kGeometryStep = 1;
constexpr int kNoGap = 1 << 20;        // longer than any track
constexpr double kLeastOfSpeed = 0.5;  // of the slope expected from the speed of the ground
// Pictures beside the frame for the speed of the ground. What is taken for the fixed pattern, their
// mean, also holds reflections, which change within half a second.
constexpr int kGroundPictures = 5;

cv::Matx33d ToMatx(const Eigen::Matrix3d& m) {
  cv::Matx33d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result(i, j) = m(i, j);
  }
  return result;
}

void RecordMotion(const MotionModel& model, LabelledFrame& result) {
  result.motion_model = model.kind;
  result.motion_matrix = ToMatx(model.matrix);
  result.rejected_model = model.rejected_kind;
  result.rejected_matrix = ToMatx(model.rejected_matrix);
  result.motion_trusted = model.trusted;
  result.parallax_pixels = model.parallax_pixels;
  result.inlier_count = model.inlier_count;
  if (!model.trusted) SetOutcome(LabelOutcome::kUntrustedMotion, model.reason, result);
}

}  // namespace

bool FrameLabeller::Implementation::IsEnough(const FramePairs& pairs, LabelledFrame& result) const {
  result.feature_count = pairs.feature_count;
  result.match_count = static_cast<int64_t>(pairs.labelled.size());
  result.times.features_milliseconds = pairs.features_milliseconds;
  result.times.matching_milliseconds = pairs.matching_milliseconds;
  if (result.feature_count < options_.minimum_matches) {
    SetOutcome(LabelOutcome::kTooFewFeatures,
               absl::StrCat("only ", result.feature_count, " features: no texture"), result);
    return false;
  }
  const bool enough = pairs.match_count >= options_.minimum_matches;
  if (enough && pairs.scene.IsOneScene()) return true;
  const SceneAgreement::Areas areas = pairs.scene.CountAreas();
  SetOutcome(LabelOutcome::kTooFewMatches,
             enough ? absl::StrFormat("another scene: %d of %d areas agree with the frame before",
                                      areas.holding, areas.judged)
                    : absl::StrFormat("only %d of %d features have a match", pairs.match_count,
                                      pairs.feature_count),
             result);
  return false;
}

absl::StatusOr<MotionModel> FrameLabeller::Implementation::FindMotion(
    const std::vector<PointPair>& pairs, int64_t frame_index, LabelledFrame& result) const {
  Stopwatch watch;
  MotionModelOptions motion;
  motion.choice = options_.motion_model;
  motion.seed = MixSeed(options_.seed, static_cast<uint64_t>(frame_index), kGeometryStep);
  EGOSIEVE_ASSIGN_OR_RETURN(MotionModel model, EstimateMotionModel(pairs, motion));
  result.times.geometry_milliseconds += watch.LapMilliseconds();
  RecordMotion(model, result);
  return model;
}

Pinhole FrameLabeller::Implementation::Camera(cv::Size size) const {
  return Pinhole::Of(size, focal_ratio() * std::max(size.width, size.height));
}

void FrameLabeller::Implementation::ObserveGap(const MotionModel& model, int gap) {
  if (options_.frame_gap > 0 || !model.trusted) return;
  ObserveParallax(model.parallax_pixels, gap, FrameLabellerOptions::kLongestAutoGap,
                  IsCalibrated() ? kCalibratedGap : kSelectedModelGap, gap_);
}

void FrameLabeller::Implementation::KeepMotion(const FramePairs& pairs, int pictures, cv::Size size,
                                               bool trusted) {
  const bool is_used = options_.windowed_search && options_.features != FeatureSource::kFlow;
  motion_ = is_used && trusted ? MakeMotionField(pairs.geometry, pictures, size) : MotionField();
}

void FrameLabeller::Implementation::AddEarlier(const ExtractedFrame& frame,
                                               std::vector<GroundPicture>& pictures) const {
  Eigen::Matrix3d rotation = pictures.back().rotation;
  for (size_t k = history_.size() - 1; k > 0; --k) {
    if (static_cast<int>(pictures.size()) > kGroundPictures) return;
    const ExtractedFrame &earlier = *history_[k - 1], &later = *history_[k];
    const TwoViewMotion* motion = pair_motions_.Find(earlier.frame.index, later.frame.index);
    if (motion == nullptr || !motion->found || earlier.grey.size() != frame.grey.size()) return;
    rotation = motion->rotation.transpose() * rotation;
    pictures.push_back(
        {earlier.grey, earlier.frame.time_seconds - frame.frame.time_seconds, rotation});
  }
}

void FrameLabeller::Implementation::ObserveGround(const ExtractedFrame& before,
                                                  const ExtractedFrame& frame,
                                                  const TwoViewMotion* back, const View& far,
                                                  const Pictures& ahead) {
  const double seconds = frame.frame.time_seconds - before.frame.time_seconds;
  if (!travel().IsOfVehicle() || !(seconds > 0.0)) return;
  GroundSearchView view;
  view.direction = travel().direction;
  view.camera = Camera(frame.grey.size());
  view.ignored = options_.ignored;
  view.pictures.push_back({frame.grey});
  if (far.frame != nullptr) {
    const double whole = far.frame->frame.time_seconds - frame.frame.time_seconds;
    for (const auto& picture : ahead) {
      if (static_cast<int>(view.pictures.size()) > kGroundPictures) break;
      const double later = picture->frame.time_seconds - frame.frame.time_seconds;
      view.pictures.push_back(
          {picture->grey, later, PartOfRotation(far.motion.rotation, later / whole)});
      if (picture.get() == far.frame) break;
    }
  }
  if (back != nullptr) {
    view.pictures.push_back({before.grey, -seconds, back->rotation});
    AddEarlier(frame, view.pictures);
  }
  ground_.Advance(seconds, LikelihoodOfSpeeds(view));
}

void FrameLabeller::Implementation::MarkUnbounded(const ExtractedFrame& frame,
                                                  const TwoViewMotion& back, const Outlook& outlook,
                                                  std::vector<TrackedPoint>& points) {
  const PatternPlaces& fixed = pair_motions_.FixedIn(frame);
  if (!fixed.empty()) {
    for (TrackedPoint& point : points) {
      point.evidence.is_unbounded = fixed.Contain(point.evidence.now);
    }
  }
  const TravelPrior& prior = travel();
  if (!prior.IsOfVehicle() || !MovesForwardOrBack(prior.direction)) return;
  const Pinhole camera = Camera(frame.grey.size());
  const LinesAlongTravel lines(frame.grey, camera, prior.direction);
  // By the longest pair that follows the point.
  const auto is_no_nearer = [&](const TrackedPoint& point) {
    const std::pair<const TwoViewMotion*, cv::Point2f> views[] = {
        {&outlook.far.motion, point.far_ahead},
        {&outlook.near.motion, point.near_ahead},
        {&back, point.evidence.before}};
    for (const auto& [motion, place] : views) {
      if (!motion->found || !std::isfinite(place.x)) continue;
      return SeemsNoNearerThanGround(*motion, camera, point.evidence.now, place);
    }
    return false;
  };
  for (TrackedPoint& point : points) {
    if (lines.Contain(point.evidence.now) && is_no_nearer(point)) {
      point.evidence.is_unbounded = true;
    }
  }
}

void FrameLabeller::Implementation::BoundGround(const ExtractedFrame& a, const ExtractedFrame& b,
                                                TwoViewMotion& motion) const {
  const double seconds = std::abs(b.frame.time_seconds - a.frame.time_seconds);
  const double heights = ground_.Low() * seconds, slope = SlopeOfHeights(heights);
  // A slope far below the expected one belongs to something else, such as traffic on the road.
  if (slope > 0.0 && (slope < motion.ground_slope || motion.ground_slope < kLeastOfSpeed * slope)) {
    motion.ground_slope = slope;
    motion.ground_heights = heights;
  }
}

absl::Status FrameLabeller::Implementation::LabelPair(const ExtractedFrame& first,
                                                      const ExtractedFrame& second,
                                                      LabelledFrame& result) {
  result.first_index = first.frame.index;
  result.second_index = second.frame.index;
  const int gap = Gap(static_cast<int>(history_.size()));
  EGOSIEVE_ASSIGN_OR_RETURN(const FramePairs pairs, BuildPairs(first, second, motion_, gap,
                                                               options_, pair_motions_.flows()));
  motion_ = MotionField();
  if (!IsEnough(pairs, result)) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const MotionModel model,
                            FindMotion(pairs.geometry, second.frame.index, result));
  ObserveGap(model, gap);
  KeepMotion(pairs, gap, second.grey.size(), model.trusted);
  if (!model.trusted) return absl::OkStatus();
  Stopwatch watch;
  const bool on_first = options_.labelled_side == LabelledSide::kFirstFrame;
  LabelByDistance(on_first ? first : second, pairs.labelled, model, options_, mixture_, result);
  result.times.labelling_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::StatusOr<Outlook> FrameLabeller::Implementation::OutlookOf(const ExtractedFrame& frame,
                                                                 const Pictures& ahead,
                                                                 absl::Span<const float> moved,
                                                                 LabellingTimes& times) {
  if (!FollowsCalibrated()) return Outlook();
  Stopwatch watch;
  const double flow_before = pair_motions_.flow_milliseconds();
  EGOSIEVE_ASSIGN_OR_RETURN(
      Outlook outlook, LookAhead(frame, ahead, Camera(frame.grey.size()), moved, pair_motions_));
  const double flow = pair_motions_.flow_milliseconds() - flow_before;
  times.features_milliseconds += flow;
  times.geometry_milliseconds += watch.LapMilliseconds() - flow;
  return outlook;
}

absl::Status FrameLabeller::Implementation::LabelFromAhead(const ExtractedFrame& frame,
                                                           const Pictures& ahead,
                                                           LabelledFrame& result) {
  EGOSIEVE_ASSIGN_OR_RETURN(const Outlook outlook, OutlookOf(frame, ahead, {}, result.times));
  if (outlook.empty()) return absl::OkStatus();
  Stopwatch watch;
  if (evidence_.last_frame_index() != frame.frame.index) evidence_.Begin(frame.frame.index);
  std::vector<TrackedPoint> points = evidence_.Points(kNoGap, outlook.links);
  if (outlook.knows_ground()) MarkUnbounded(frame, TwoViewMotion(), outlook, points);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const EvidenceResult evidence,
      evidence_.Judge(nullptr, frame, 1, MotionModel(), points, nullptr, Camera(frame.grey.size()),
                      {{outlook.far.frame, &outlook.far.motion, &TrackedPoint::far_ahead},
                       {outlook.near.frame, &outlook.near.motion, &TrackedPoint::near_ahead}}));
  movers_.Remember(points, evidence, frame.grey.size());
  const View& view = outlook.longest();
  result.first_index = frame.frame.index;
  result.second_index = view.frame->frame.index;
  RecordMotion(ModelOf(view.motion, Camera(frame.grey.size()), 0), result);
  result.reason.clear();
  LabelByEvidence(frame, points, MotionModel(), evidence, options_, result);
  result.static_share = view.motion.static_share;
  result.times.labelling_milliseconds += watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::StatusOr<MotionModel> FrameLabeller::Implementation::MotionOfTracks(
    const std::vector<TrackedPoint>& points, const ExtractedFrame& frame, const MovedNodes& moved,
    TwoViewMotion& world, LabelledFrame& result) {
  std::vector<PointPair> geometry;
  std::vector<float> moved_before;
  const PatternPlaces& fixed = pair_motions_.FixedIn(frame);
  for (const TrackedPoint& point : points) {
    const cv::Point2f a = point.evidence.before, b = point.evidence.now;
    if (point.is_textured && point.evidence.HasBefore() && !fixed.Contain(b)) {
      geometry.push_back({a.x, a.y, b.x, b.y});
      moved_before.push_back(movers_.At(moved, b, frame.grey.size()));
    }
  }
  if (!IsCalibrated()) return FindMotion(geometry, frame.frame.index, result);
  Stopwatch watch;
  const Pinhole camera = Camera(frame.grey.size());
  if (!world.found) {
    world =
        EstimateTwoViewMotion(geometry, camera, MotionOptionsOf(options_, travel()), moved_before);
    if (travel().IsOfVehicle()) FindGround(geometry, camera, world);
  }
  MotionModel model = ModelOf(world, camera, static_cast<int64_t>(geometry.size()));
  RecordMotion(model, result);
  result.times.geometry_milliseconds += watch.LapMilliseconds();
  return model;
}

absl::StatusOr<FrameLabeller::Implementation::Sight> FrameLabeller::Implementation::SightOf(
    const ExtractedFrame& before, const ExtractedFrame& frame, const Pictures& ahead,
    const FramePairs& pairs, absl::Span<const float> moved, int gap, LabellingTimes& times) {
  const Pinhole camera = Camera(frame.grey.size());
  Sight sight;
  EGOSIEVE_ASSIGN_OR_RETURN(sight.outlook, OutlookOf(frame, ahead, moved, times));
  if (gap > 1 && FollowsCalibrated()) {
    EGOSIEVE_ASSIGN_OR_RETURN(sight.behind,
                              LookBack(before, frame, camera, movers_.nodes(), pair_motions_));
  } else if (FollowsCalibrated() && pairs.matches.empty()) {
    // The motion that was estimated when looking ahead from the frame before.
    EGOSIEVE_ASSIGN_OR_RETURN(sight.world,
                              pair_motions_.Between(before, frame, camera, movers_.nodes()));
  }
  return sight;
}

void FrameLabeller::Implementation::UseGround(const ExtractedFrame& before,
                                              const ExtractedFrame* first,
                                              const ExtractedFrame& frame, const Pictures& ahead,
                                              int gap, Sight& sight,
                                              std::vector<TrackedPoint>& points) {
  auto& [behind, world, outlook] = sight;
  const TwoViewMotion to_before = gap > 1 ? behind.motion : Inverse(world);
  const bool is_known = gap > 1 ? behind.frame != nullptr : world.found;
  ObserveGround(before, frame, is_known ? &to_before : nullptr, outlook.far, ahead);
  if (first != nullptr) BoundGround(*first, frame, world);
  for (View* view : {&behind, &outlook.near, &outlook.far}) {
    if (view->frame != nullptr) BoundGround(frame, *view->frame, view->motion);
  }
  if (world.ground_slope > 0.0 || behind.motion.ground_slope > 0.0 || outlook.knows_ground()) {
    MarkUnbounded(frame, Inverse(world), outlook, points);
  }
}

absl::Status FrameLabeller::Implementation::LabelTracks(const ExtractedFrame& before,
                                                        const ExtractedFrame& frame,
                                                        const Pictures& ahead,
                                                        LabelledFrame& result) {
  EGOSIEVE_ASSIGN_OR_RETURN(const FramePairs pairs,
                            BuildPairs(before, frame, motion_, 1, options_, pair_motions_.flows()));
  motion_ = MotionField();
  if (!IsEnough(pairs, result)) {
    evidence_.Begin(frame.frame.index);
    movers_.Forget();
    ground_ = GroundSpeed();
    return absl::OkStatus();
  }
  EGOSIEVE_RETURN_IF_ERROR(evidence_.Advance(before, frame, pairs));
  const MovedNodes moved = movers_.CarriedBy(pairs.links, frame.grey.size());
  const int gap = Gap(evidence_.PicturesBefore());
  if (evidence_.PicturesBefore() < gap) {
    SetOutcome(LabelOutcome::kNoPair, absl::StrCat("fewer than ", gap, " frames before this one"),
               result);
    return absl::OkStatus();
  }
  result.first_index = evidence_.FrameIndexBefore(gap);
  result.second_index = frame.frame.index;
  EGOSIEVE_ASSIGN_OR_RETURN(Sight sight,
                            SightOf(before, frame, ahead, pairs, moved, gap, result.times));
  auto& [behind, world, outlook] = sight;
  std::vector<TrackedPoint> points = evidence_.Points(gap, outlook.links);
  EGOSIEVE_ASSIGN_OR_RETURN(MotionModel model, MotionOfTracks(points, frame, moved, world, result));
  ObserveGap(model, gap);
  KeepMotion(pairs, 1, frame.grey.size(), model.trusted);
  Stopwatch watch;
  if (!model.trusted) model.kind = MotionModelKind::kNone;
  const Pinhole camera = Camera(frame.grey.size());
  const ExtractedFrame* first = InHistory(result.first_index);
  if (IsCalibrated()) UseGround(before, first, frame, ahead, gap, sight, points);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const EvidenceResult evidence,
      evidence_.Judge(first, frame, gap, model, points, world.found ? &world : nullptr, camera,
                      {{outlook.far.frame, &outlook.far.motion, &TrackedPoint::far_ahead},
                       {outlook.near.frame, &outlook.near.motion, &TrackedPoint::near_ahead},
                       {behind.frame, &behind.motion, &TrackedPoint::near_behind}}));
  movers_.Remember(points, evidence, frame.grey.size());
  result.own_vehicle = OwnVehicleAreas(evidence_.own_vehicle(), frame.grey.size());
  if (IsCalibrated()) {
    const TwoViewMotion* motion = model.trusted ? &world : nullptr;
    result.step = StepOf({before.frame.index, frame.frame.index, gap, motion, &behind, &outlook},
                         points, camera);
  }
  if (model.trusted || !outlook.empty()) {
    result.reason.clear();
    LabelByEvidence(frame, points, model, evidence, options_, result);
  }
  if (const View& view = outlook.longest(); view.frame != nullptr || world.found) {
    result.static_share = (view.frame != nullptr ? view.motion : world).static_share;
  }
  result.times.labelling_milliseconds = watch.LapMilliseconds();
  return absl::OkStatus();
}

}  // namespace egosieve::vision
