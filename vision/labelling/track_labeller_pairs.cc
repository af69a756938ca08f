// The steps of track_labeller.h after extraction: labels from tracks and the pictures ahead.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/frame/ignored_area.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/pinhole.h"
#include "vision/image/inside.h"
#include "vision/labelling/among_movers.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/label_outcome.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/labelling/lines_along_travel.h"
#include "vision/labelling/outlook.h"
#include "vision/labelling/stopwatch.h"
#include "vision/labelling/track_labeller.h"
#include "vision/trajectory/camera_step.h"
#include "vision/trajectory/ground_bound.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

// Fills in the places of a labelled frame and their probabilities from evidence along tracks
// (vision/evidence/fusion.h). Nodes of the flow grid in options.ignored are labelled static. Counted
// as discarded are places outside of the picture, places without a probability, those that tell
// nothing among movers (among_movers.h), and those in `fixed` that seem to move: of three
// explanations, static, moving and fixed to the vehicle, the last one has no label of its own.
// evidence: one per point.
void LabelByEvidence(const ExtractedFrame& frame, const PatternPlaces& fixed,
                     const std::vector<TrackedPoint>& points, MotionModelKind kind,
                     const EvidenceResult& evidence, const FrameLabellerOptions& options,
                     LabelledFrame& result) {
  // A distance to a line checks one direction of two: a single place may pass by chance.
  const bool needs_support = kind == MotionModelKind::kFundamental;
  const auto add = [&](cv::Point2f now, cv::Point2f before, double probability, EvidenceTerm by) {
    result.positions.insert(result.positions.end(), {now.x, now.y});
    const bool paired = std::isfinite(before.x) && kind != MotionModelKind::kNone;
    const cv::Point2f other = paired ? before : now;
    result.other_positions.insert(result.other_positions.end(), {other.x, other.y});
    result.probability.push_back(probability);
    result.decided_by.push_back(by);
  };
  const auto is_judged = [&](size_t i) {
    const cv::Point2f now = points[i].evidence.now;
    return evidence.points[i].judged && (!needs_support || points[i].is_supported) &&
           !(evidence.points[i].probability > 0.5 && fixed.Contain(now)) &&
           IsInside(now.x, now.y, frame.grey.size());
  };
  std::vector<cv::Point2f> moving;
  for (size_t i = 0; i < points.size(); ++i) {
    const bool moves = is_judged(i) && evidence.points[i].probability > 0.5;
    if (moves) moving.push_back(points[i].evidence.now);
  }
  constexpr int kStride = FrameLabellerOptions::kFlowStridePixels;
  const AmongMovers among_movers(moving, frame.grey.size(), kStride);
  for (size_t i = 0; i < points.size(); ++i) {
    const PointEvidence& point = evidence.points[i];
    const cv::Point2f now = points[i].evidence.now;
    if (!is_judged(i) ||
        (!Tells(point.probability, evidence.mover_share) && among_movers.Has(now))) {
      ++result.discarded_count;
      continue;
    }
    add(now, points[i].evidence.before, point.probability, point.decided_by);
  }
  for (const GuidedPlace& place : evidence.standing) {
    add(place.now, place.before, evidence.standing_probability, EvidenceTerm::kEpipolar);
  }
  for (int y = kStride / 2; y < frame.grey.rows && !options.ignored.empty(); y += kStride) {
    for (int x = kStride / 2; x < frame.grey.cols; x += kStride) {
      if (!IsIgnored(options.ignored, frame.grey.size(), x, y)) continue;
      const cv::Point2f place(static_cast<float>(x), static_cast<float>(y));
      add(place, place, 0.0, EvidenceTerm::kEpipolar);
    }
  }
  result.outcome = LabelOutcome::kLabelled;
}

double SecondsBetween(const ExtractedFrame& a, const ExtractedFrame& b) {
  return std::abs(a.frame.time_seconds - b.frame.time_seconds);
}

PairCounts CountsOf(const TrackedGrid& grid, cv::Size size) {
  PairCounts counts(size);
  counts.features = static_cast<int64_t>(grid.textured.size());
  counts.matches = grid.AgreeingCount();
  counts.labelled = static_cast<int64_t>(grid.pairs.size());
  for (size_t i = 0; i < grid.textured.size(); ++i) {
    counts.scene.AddFlow(grid.textured[i], grid.agrees[i] != 0);
  }
  return counts;
}

constexpr int kNoGap = 1 << 20;  // longer than any track
// Pictures beside the frame for the speed of the ground. What is taken for the fixed pattern, their
// mean, also holds reflections, which change within half a second.
constexpr int kGroundPictures = 5;

}  // namespace

Pinhole TrackLabeller::Camera(cv::Size size) const {
  return Pinhole::Of(size, focal_ratio() * std::max(size.width, size.height));
}

CameraStep TrackLabeller::StepOf(const ExtractedFrame& before, const ExtractedFrame& frame, int gap,
                                 const Sight& sight,
                                 const std::vector<TrackedPoint>& points) const {
  const auto& [behind, world, outlook] = sight;
  if (gap > 1 && behind.frame == nullptr) return {};
  const Eigen::Matrix3d rotation =
      gap > 1 ? Eigen::Matrix3d(behind.motion.rotation.transpose()) : world.rotation;
  const bool is_far = outlook.far.frame != nullptr;
  const View& ahead = outlook.longest();
  StepViews step;
  step.behind = &world;
  step.pictures_behind = gap;
  if (ahead.frame != nullptr) {
    step.ahead = &ahead.motion;
    const int64_t index = frame.frame.index;
    const double steps = static_cast<double>(ahead.frame->frame.index - index) /
                         static_cast<double>(index - before.frame.index);
    step.pictures_ahead = std::max(1, static_cast<int>(std::lround(steps)));
  }
  for (const TrackedPoint& point : points) {
    const cv::Point2f there = is_far ? point.far_ahead : point.near_ahead;
    const cv::Point2f now = point.evidence.now, then = point.evidence.before;
    if (!point.is_textured || !point.evidence.HasBefore() || !std::isfinite(there.x)) continue;
    step.places.push_back({{then.x, then.y, now.x, now.y}, {now.x, now.y, there.x, there.y}});
  }
  return MeasureStep(rotation, step, Camera(frame.grey.size()));
}

void TrackLabeller::AddEarlier(const ExtractedFrame& frame,
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

void TrackLabeller::ObserveGround(const ExtractedFrame& before, const ExtractedFrame& frame,
                                  const TwoViewMotion* back, const View& far, const Pictures& ahead,
                                  GroundObservation observation) {
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
  observation.pictures = LikelihoodOfSpeeds(view);
  ground_.Advance(seconds, observation);
}

void TrackLabeller::MarkUnbounded(const ExtractedFrame& frame, const TwoViewMotion& back,
                                  const Outlook& outlook, std::vector<TrackedPoint>& points) {
  const PatternPlaces& fixed = pair_motions_.FixedIn(frame);
  if (!fixed.empty()) {
    for (TrackedPoint& point : points) {
      point.evidence.is_unbounded = fixed.Contain(point.evidence.now);
    }
  }
  const TravelPrior& prior = travel();
  if (!prior.IsOfVehicle()) return;
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

void TrackLabeller::BoundGround(double seconds, TwoViewMotion& motion) const {
  if (!travel().IsOfVehicle()) return;
  const double heights = ground_.Low() * seconds;
  motion.ground_slope = SlopeOfBound(heights);
  // Where the pair's own places agree with the speed, they know better how the ground lies.
  const double difference = std::abs(std::log(motion.ground_heights / heights));
  if (!(difference < 2.0 * kGroundError)) motion.ground_heights = heights;
}

absl::Status TrackLabeller::LabelFromAhead(const ExtractedFrame& frame, const Pictures& ahead,
                                           LabelledFrame& result) {
  const Pinhole camera = Camera(frame.grey.size());
  Stopwatch watch;
  EGOSIEVE_ASSIGN_OR_RETURN(Outlook outlook, LookAhead(frame, ahead, camera, {}, pair_motions_));
  result.milliseconds.geometry += watch.LapMilliseconds();
  if (outlook.empty()) return absl::OkStatus();
  if (evidence_.last_frame_index() != frame.frame.index) evidence_.Begin(frame.frame.index);
  std::vector<TrackedPoint> points = evidence_.Points(kNoGap, outlook.links);
  for (View* view : {&outlook.near, &outlook.far}) {
    if (view->frame != nullptr) BoundGround(SecondsBetween(frame, *view->frame), view->motion);
  }
  MarkUnbounded(frame, TwoViewMotion(), outlook, points);
  const EvidenceResult evidence =
      evidence_.Judge(nullptr, frame, 1, points, nullptr, camera, {&outlook.far, &outlook.near});
  movers_.Remember(points, evidence, frame.grey.size());
  const View& view = outlook.longest();
  result.first_index = frame.frame.index;
  result.second_index = view.frame->frame.index;
  RecordMotion(view.motion, camera, 0, result);
  result.reason.clear();
  LabelByEvidence(frame, pair_motions_.FixedIn(frame), points, MotionModelKind::kNone, evidence,
                  options_, result);
  result.static_share = view.motion.static_share;
  result.milliseconds.labelling += watch.LapMilliseconds();
  return absl::OkStatus();
}

bool TrackLabeller::MotionOfTracks(const std::vector<TrackedPoint>& points,
                                   const ExtractedFrame& frame, const MovedNodes& moved,
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
  Stopwatch watch;
  const Pinhole camera = Camera(frame.grey.size());
  if (!world.found) {
    world = EstimateOnDrive(geometry, camera, MotionOptionsOf(travel()), moved_before);
  }
  const bool is_trusted =
      RecordMotion(world, camera, static_cast<int64_t>(geometry.size()), result);
  result.milliseconds.geometry += watch.LapMilliseconds();
  return is_trusted;
}

absl::StatusOr<TrackLabeller::Sight> TrackLabeller::SightOf(const ExtractedFrame& before,
                                                            const ExtractedFrame& frame,
                                                            const Pictures& ahead,
                                                            absl::Span<const float> moved, int gap,
                                                            StageMilliseconds& milliseconds) {
  const Pinhole camera = Camera(frame.grey.size());
  Sight sight;
  Stopwatch watch;
  EGOSIEVE_ASSIGN_OR_RETURN(sight.outlook, LookAhead(frame, ahead, camera, moved, pair_motions_));
  // The motion that was estimated when looking ahead from the frame before.
  EGOSIEVE_ASSIGN_OR_RETURN(const TwoViewMotion step,
                            pair_motions_.Between(before, frame, camera, movers_.nodes()));
  if (gap == 1) {
    sight.world = step;
  } else if (IsTrusted(step)) {
    sight.behind = {&before, Inverse(step), &TrackedPoint::near_behind};
  }
  milliseconds.geometry += watch.LapMilliseconds();
  return sight;
}

void TrackLabeller::UseGround(const ExtractedFrame& before, const ExtractedFrame* first,
                              const ExtractedFrame& frame, const Pictures& ahead, int gap,
                              Sight& sight, std::vector<TrackedPoint>& points) {
  auto& [behind, world, outlook] = sight;
  const TwoViewMotion to_before = gap > 1 ? behind.motion : Inverse(world);
  const bool is_known = gap > 1 ? behind.frame != nullptr : world.found;
  std::vector<std::pair<double, TwoViewMotion*>> motions;  // with their times, seconds
  if (first != nullptr) motions.emplace_back(SecondsBetween(frame, *first), &world);
  for (View* view : {&behind, &outlook.near, &outlook.far}) {
    if (view->frame == nullptr) continue;
    motions.emplace_back(SecondsBetween(frame, *view->frame), &view->motion);
  }
  // By the longest pairs that show it.
  GroundObservation observation;
  double longest = 0.0, longest_with_ground = 0.0;
  for (const auto& [seconds, motion] : motions) {
    if (motion->found && seconds > longest) {
      longest = seconds;
      observation.scene_parallax = std::max(motion->mean_parallax, motion->noise) / seconds;
    }
    if (motion->ground_heights > 0.0 && seconds > longest_with_ground) {
      longest_with_ground = seconds;
      observation.speed = motion->ground_heights / seconds;
    }
  }
  ObserveGround(before, frame, is_known ? &to_before : nullptr, outlook.far, ahead, observation);
  for (const auto& [seconds, motion] : motions) BoundGround(seconds, *motion);
  MarkUnbounded(frame, Inverse(world), outlook, points);
}

absl::Status TrackLabeller::LabelTracks(const ExtractedFrame& before, const ExtractedFrame& frame,
                                        const Pictures& ahead, LabelledFrame& result) {
  auto grid = std::make_shared<const TrackedGrid>();  // empty if too small for flow
  if (IsLargeEnoughForFlow(frame.grey.size())) {
    Stopwatch watch;
    EGOSIEVE_RETURN_IF_ERROR(pair_motions_.flows().Between(before, frame).status());
    result.milliseconds.features = watch.LapMilliseconds();
    EGOSIEVE_ASSIGN_OR_RETURN(grid,
                              pair_motions_.flows().Grid(before, frame, /*anchor_second=*/true));
    result.milliseconds.matching = watch.LapMilliseconds();
  }
  if (!IsEnough(CountsOf(*grid, frame.grey.size()), result)) {
    evidence_.Begin(frame.frame.index);
    movers_.Forget();
    ground_ = GroundSpeed();
    return absl::OkStatus();
  }
  evidence_.Advance(frame, *grid);
  const MovedNodes moved = movers_.CarriedBy(grid->pairs, frame.grey.size());
  const int gap = Gap(evidence_.PicturesBefore());
  if (evidence_.PicturesBefore() < gap) {
    SetNoPair(gap, result);
    return absl::OkStatus();
  }
  result.first_index = evidence_.FrameIndexBefore(gap);
  result.second_index = frame.frame.index;
  EGOSIEVE_ASSIGN_OR_RETURN(Sight sight,
                            SightOf(before, frame, ahead, moved, gap, result.milliseconds));
  auto& [behind, world, outlook] = sight;
  std::vector<TrackedPoint> points = evidence_.Points(gap, outlook.links);
  const bool is_trusted = MotionOfTracks(points, frame, moved, world, result);
  if (options_.frame_gap == 0 && is_trusted) {
    ObserveParallax(result.parallax_pixels, gap, FrameLabellerOptions::kLongestAutoGap, gap_);
  }
  if (is_trusted) LearnTravel(world, frame.frame.time_seconds);
  Stopwatch watch;
  const MotionModelKind kind = is_trusted ? result.motion_model : MotionModelKind::kNone;
  const Pinhole camera = Camera(frame.grey.size());
  const ExtractedFrame* first = InHistory(result.first_index);
  UseGround(before, first, frame, ahead, gap, sight, points);
  const EvidenceResult evidence =
      evidence_.Judge(first, frame, gap, points, is_trusted ? &world : nullptr, camera,
                      {&outlook.far, &outlook.near, &behind});
  movers_.Remember(points, evidence, frame.grey.size());
  if (is_trusted) result.step = StepOf(before, frame, gap, sight, points);
  ground_.SetOnward(result.step.onward);
  if (is_trusted) {
    result.noise_pixels = world.noise_pixels;
    if (!IsFocalKnown()) result.doubt = DoubtOfTurn(world, camera, frame.grey.size());
  }
  if (is_trusted || !outlook.empty()) {
    result.reason.clear();
    LabelByEvidence(frame, pair_motions_.FixedIn(frame), points, kind, evidence, options_, result);
  }
  if (const View& view = outlook.longest(); view.frame != nullptr || world.found) {
    result.static_share = (view.frame != nullptr ? view.motion : world).static_share;
  }
  result.milliseconds.labelling = watch.LapMilliseconds();
  return absl::OkStatus();
}

}  // namespace egosieve::vision
