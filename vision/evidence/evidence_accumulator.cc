#include "vision/evidence/evidence_accumulator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/for_each_point.h"
#include "vision/evidence/negative_depth.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/residual_scale.h"
#include "vision/evidence/road_evidence.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

constexpr size_t kFewestResiduals = 20;
constexpr double kPoseExplains = 1.1;  // greatest scale of the pose's distances over the given F's

bool IsKnown(cv::Point2f p) { return std::isfinite(p.x) && std::isfinite(p.y); }

PointPair PairOf(const EvidencePoint& point) {
  return {point.before.x, point.before.y, point.now.x, point.now.y};
}

PointTriple TripleOf(const EvidencePoint& point) {
  return {{point.earlier.x, point.earlier.y},
          {point.before.x, point.before.y},
          {point.now.x, point.now.y}};
}

// Where the point would be in frame t if it stood still: the nearest place that the model allows.
cv::Point2f StandingPlace(MotionModelKind kind, const Eigen::Matrix3d& matrix,
                          const PointPair& pair) {
  const Eigen::Vector3d moved = matrix * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  if (kind == MotionModelKind::kHomography) {
    return {static_cast<float>(moved(0) / moved(2)), static_cast<float>(moved(1) / moved(2))};
  }
  if (kind != MotionModelKind::kFundamental) {
    return {static_cast<float>(pair.x1), static_cast<float>(pair.y1)};
  }
  const double square = moved.head<2>().squaredNorm();
  const double distance = moved.dot(Eigen::Vector3d(pair.x2, pair.y2, 1.0)) / square;
  return {static_cast<float>(pair.x2 - distance * moved(0)),
          static_cast<float>(pair.y2 - distance * moved(1))};
}

cv::Point2f Back(cv::Point2f place, double pixels, const Eigen::Vector2d& direction) {
  return {static_cast<float>(place.x - pixels * direction(0)),
          static_cast<float>(place.y - pixels * direction(1))};
}

// Nothing without both pictures.
std::optional<PhotometricSupport> PicturesOf(const EvidenceFrame& frame) {
  if (frame.grey.empty() || frame.grey_before.empty()) return std::nullopt;
  std::vector<cv::Point2f> befores, nows;
  for (const EvidencePoint& point : frame.points) {
    if (!point.estimates || !IsKnown(point.now) || !IsKnown(point.before)) continue;
    befores.push_back(point.before);
    nows.push_back(point.now);
  }
  return PhotometricSupport(frame.grey_before, frame.grey, befores, nows,
                            frame.world ? frame.world->LineDeviationPixels() : 0.0);
}

CalibratedPair PairOf(const EvidenceFrame& frame, const EvidenceView& view) {
  CalibratedPair pair;
  pair.motion = view.motion;
  pair.pictures = view.pictures;
  std::vector<cv::Point2f> nows, theres;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const cv::Point2f now = frame.points[i].now, there = view.places[i];
    pair.places.push_back({now.x, now.y, there.x, there.y});
    if (!frame.points[i].estimates || !IsKnown(there)) continue;
    nows.push_back(now);
    theres.push_back(there);
  }
  if (!frame.grey.empty() && !view.grey.empty()) {
    pair.support.emplace(frame.grey, view.grey, nows, theres, view.motion.LineDeviationPixels());
  }
  return pair;
}

absl::Status CheckFrame(const EvidenceFrame& frame, int64_t last_index) {
  if (frame.index < 0 || frame.index <= last_index) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, " after frame ", last_index, "; indices must grow"));
  }
  if (frame.gap < 1) {
    return absl::InvalidArgumentError(absl::StrCat("gap is ", frame.gap, "; it must be positive"));
  }
  if (frame.size.width < 1 || frame.size.height < 1) {
    return absl::InvalidArgumentError(absl::StrCat("image size is ", frame.size.width, " x ",
                                                   frame.size.height, "; it must be positive"));
  }
  for (const cv::Mat& grey : {frame.grey, frame.grey_before}) {
    if (!grey.empty() && (grey.type() != CV_8UC1 || grey.size() != frame.size)) {
      return absl::InvalidArgumentError("the image must be 8-bit grey and of the size given");
    }
  }
  return absl::OkStatus();
}

// The points' indices by increasing track id, those without an id left out.
absl::StatusOr<std::vector<int64_t>> ByTrack(const std::vector<EvidencePoint>& points) {
  std::vector<int64_t> order;
  order.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].track_id >= 0) order.push_back(i);
  }
  const auto id = [&](int64_t i) { return points[i].track_id; };
  std::sort(order.begin(), order.end(), [&](int64_t a, int64_t b) { return id(a) < id(b); });
  for (size_t k = 1; k < order.size(); ++k) {
    if (id(order[k]) == id(order[k - 1])) {
      return absl::InvalidArgumentError(
          absl::StrCat("track ", id(order[k]), " is given for two points"));
    }
  }
  return order;
}

// The greatest part of the sum in the sum's own direction.
EvidenceTerm Decisive(const std::array<double, kEvidenceTerms>& sums, bool dynamic) {
  const auto chosen = dynamic ? std::max_element(sums.begin(), sums.end())
                              : std::min_element(sums.begin(), sums.end());
  return static_cast<EvidenceTerm>(chosen - sums.begin());
}

}  // namespace

// Steps 1 and 2 of a frame.
struct EvidenceAccumulator::Motion {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::vector<PointPair> pairs;  // of the points that take part
  Pinhole camera;
  RelativePose pose;
  ThreeViewMotion three_views;
  bool pose_line = false;
  double noise_pixels = 0.0;
};

EvidencePoint PointOfTrack(const Track& track, int gap) {
  EvidencePoint point;
  point.track_id = track.id;
  point.parent_id = track.parent_id;
  point.now = track.places[0];
  if (track.Reaches(gap)) point.before = track.places[gap];
  if (track.Reaches(2 * gap)) point.earlier = track.places[2 * gap];
  return point;
}

absl::StatusOr<EvidenceAccumulator> EvidenceAccumulator::Create(const EvidenceOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return EvidenceAccumulator(options);
}

EvidenceAccumulator::Motion EvidenceAccumulator::MotionOf(const EvidenceFrame& frame,
                                                          EvidenceState& next) const {
  Motion motion;
  motion.kind = frame.motion_matrix.allFinite() ? frame.motion_model : MotionModelKind::kNone;
  motion.matrix = frame.motion_matrix;
  motion.camera = frame.world || !frame.views.empty()
                      ? frame.camera
                      : Pinhole::Of(frame.size, options_.focal_pixels);
  if (motion.kind == MotionModelKind::kNone) return motion;

  std::vector<PointPair>& pairs = motion.pairs;
  std::vector<PointTriple> triples;
  for (const EvidencePoint& point : frame.points) {
    if (!point.estimates || !IsKnown(point.now) || !IsKnown(point.before)) continue;
    pairs.push_back(PairOf(point));
    if (IsKnown(point.earlier)) triples.push_back(TripleOf(point));
  }
  const auto scale = [&](const Eigen::Matrix3d& matrix) {
    const std::vector<double> residuals =
        Residuals(motion.kind, matrix, pairs, EpipolarDistance::kSampson);
    const int dimensions = motion.kind == MotionModelKind::kFundamental ? 1 : 2;
    return residuals.size() < kFewestResiduals
               ? 0.0
               : ResidualScale(residuals, dimensions, options_.noise_floor_pixels);
  };
  double noise = scale(motion.matrix);
  if (motion.kind == MotionModelKind::kFundamental) {
    if (frame.world) {
      motion.pose = PoseOf(*frame.world);
      motion.pose_line = motion.pose.found();
    } else {
      motion.pose = EstimateRelativePose(pairs, motion.matrix, motion.camera, options_.pose);
      const Eigen::Matrix3d of_pose = FundamentalOfPose(motion.pose, motion.camera);
      const double pose_noise = scale(of_pose);
      motion.pose_line = motion.pose.found() && pose_noise <= kPoseExplains * noise;
      if (motion.pose_line) {
        motion.matrix = of_pose;
        noise = pose_noise;
      }
    }
    const auto past = std::find_if(next.poses.begin(), next.poses.end(), [&](const auto& pose) {
      return pose.index == frame.index - frame.gap && pose.gap == frame.gap;
    });
    if (options_.three_view && past != next.poses.end()) {
      motion.three_views =
          FitThreeViews(triples, past->pose, motion.pose, motion.camera, options_.three_views);
    }
  }
  if (!(noise > 0.0)) {
    motion.kind = MotionModelKind::kNone;
    return motion;
  }
  const double memory = next.has_noise ? options_.noise_memory : 0.0;
  next.log_noise = memory * next.log_noise + (1.0 - memory) * std::log(noise);
  next.has_noise = true;
  // A frame that is noisier than the drive (a jolt, blur) is judged by its own noise.
  motion.noise_pixels = std::max(noise, std::exp(next.log_noise));
  return motion;
}

void EvidenceAccumulator::MeasureCalibrated(const EvidenceFrame& frame,
                                            const PhotometricSupport* pictures, bool has_motion,
                                            EvidenceResult& result) const {
  const bool has_world = frame.world && has_motion;
  std::vector<CalibratedPair> pairs;
  if (has_world) {
    CalibratedPair& pair = pairs.emplace_back();
    pair.motion = *frame.world;
    pair.pictures = frame.pictures;
    for (const EvidencePoint& point : frame.points) pair.places.push_back(PairOf(point));
    if (pictures != nullptr) pair.support = *pictures;
  }
  for (const EvidenceView& view : frame.views) pairs.push_back(PairOf(frame, view));
  const auto ratios = CalibratedLogRatios(pairs, frame.camera);
  for (size_t k = 0; k < pairs.size(); ++k) {
    for (size_t i = 0; i < frame.points.size(); ++i) {
      if (!ratios[k][i]) continue;
      PointEvidence& point = result.points[i];
      if (k == 0 && has_world) {
        point.log_ratio[static_cast<int>(EvidenceTerm::kEpipolar)] = *ratios[k][i];
        point.present[static_cast<int>(EvidenceTerm::kEpipolar)] = true;
      } else {
        point.views_log_ratio = point.views_log_ratio.value_or(0.0) + *ratios[k][i];
      }
    }
  }
}

void EvidenceAccumulator::Measure(const EvidenceFrame& frame, const Motion& motion,
                                  const PhotometricSupport* pictures,
                                  EvidenceResult& result) const {
  if (options_.epipolar) {
    MeasureCalibrated(frame, pictures, motion.kind != MotionModelKind::kNone, result);
  }
  if (motion.kind == MotionModelKind::kNone) return;
  const auto measure = [&](size_t i) {
    const EvidencePoint& point = frame.points[i];
    if (!IsKnown(point.now) || !IsKnown(point.before)) return;
    const PointPair pair = PairOf(point);
    const auto set = [&](EvidenceTerm term, double ratio) {
      result.points[i].log_ratio[static_cast<int>(term)] = ratio;
      result.points[i].present[static_cast<int>(term)] = true;
    };
    // `standing`: where the term would have a point that stands still.
    const auto set_supported = [&](EvidenceTerm term, double ratio, cv::Point2f standing) {
      if (pictures != nullptr && ratio > 0.0) {
        ratio =
            std::min(ratio, pictures->LogRatio(point.before, point.now, standing).value_or(0.0));
      }
      set(term, ratio);
    };
    if (options_.epipolar && !frame.world) {
      const double residual =
          Residuals(motion.kind, motion.matrix, {pair}, EpipolarDistance::kSampson)[0];
      set_supported(EvidenceTerm::kEpipolar, DistanceLogRatio(residual / motion.noise_pixels),
                    StandingPlace(motion.kind, motion.matrix, pair));
    }
    if (options_.negative_depth && !frame.world) {
      const SignedFlow flow = MeasureSignedFlow(motion.camera, motion.pose, pair);
      if (flow.present) {
        set_supported(EvidenceTerm::kNegativeDepth,
                      DepthLogRatio(flow.along_pixels / flow.deviation_pixels),
                      Back(point.now, flow.along_pixels, flow.direction));
      }
    }
    if (options_.three_view && IsKnown(point.earlier)) {
      const ThreeViewResidual residual =
          MeasureThreeViews(motion.three_views, motion.camera, TripleOf(point));
      if (residual.present) {
        set_supported(EvidenceTerm::kThreeView,
                      DistanceLogRatio(residual.along_pixels / residual.deviation_pixels),
                      Back(point.now, residual.along_pixels, residual.direction));
      }
    }
  };
  ForEachPoint(frame.points.size(), measure);
}

RoadPlane EvidenceAccumulator::MeasureRoad(const EvidenceFrame& frame, const Motion& motion,
                                           const PhotometricSupport* pictures, EvidenceState& next,
                                           EvidenceResult& result) const {
  if (!options_.road || !motion.pose.found()) return {};
  RoadView view;
  view.camera = motion.camera;
  view.pose = motion.pose;
  view.size = frame.size;
  view.before = frame.grey_before;
  view.now = frame.grey;
  view.pictures = pictures;
  const auto is_own = [&](cv::Point2f now) { return IsOwnCar(next.own_car, now); };
  std::vector<size_t> owners;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const EvidencePoint& point = frame.points[i];
    if (!IsKnown(point.now) || !IsKnown(point.before) || is_own(point.now)) continue;
    view.pairs.push_back(PairOf(point));
    view.is_textured.push_back(point.estimates);
    owners.push_back(i);
  }
  std::remove_copy_if(frame.unfollowed.begin(), frame.unfollowed.end(),
                      std::back_inserter(view.unfollowed), is_own);
  RoadEvidence evidence =
      egosieve::vision::MeasureRoad(view, next.road, static_cast<uint64_t>(frame.index));
  const RoadPlane& road = evidence.road;
  next.road = {};
  if (!road.found) return road;
  next.road = {true, road.m(0) / road.m(1), -road.m(2) / road.m(1)};
  for (size_t k = 0; k < owners.size(); ++k) {
    PointEvidence& point = result.points[owners[k]];
    point.log_ratio[static_cast<int>(EvidenceTerm::kRoad)] = evidence.log_ratios[k];
    point.present[static_cast<int>(EvidenceTerm::kRoad)] = true;
  }
  result.standing = std::move(evidence.standing);
  return road;
}

void EvidenceAccumulator::Fuse(const EvidenceFrame& frame, EvidenceState& next,
                               EvidenceResult& result) const {
  std::vector<EvidenceState::Memory> sums(frame.points.size());
  std::vector<double> totals(frame.points.size(), 0.0), estimating;
  const double tempering = options_.accumulation ? options_.tempering : 1.0;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    PointEvidence& evidence = result.points[i];
    const int64_t id = frame.points[i].parent_id;
    const auto memory = std::lower_bound(
        next.memories.begin(), next.memories.end(), id,
        [](const EvidenceState::Memory& m, int64_t wanted) { return m.track_id < wanted; });
    const bool remembered =
        options_.accumulation && id >= 0 && memory != next.memories.end() && memory->track_id == id;
    sums[i].track_id = frame.points[i].track_id;
    evidence.judged = remembered;
    std::array<double, kEvidenceTerms> parts{};
    double now = 0.0;
    for (int k = 0; k < kEvidenceTerms; ++k) {
      const auto term = static_cast<EvidenceTerm>(k);
      if (remembered) sums[i].sums[k] = options_.forgetting * memory->sums[k];
      if (evidence.present[k]) {
        evidence.judged = true;
        sums[i].sums[k] += evidence.log_ratio[k];
        now += VisibleLogRatio(term, evidence.log_ratio[k]);
      }
      double sum = sums[i].sums[k];
      if (term == EvidenceTerm::kEpipolar && evidence.views_log_ratio) {
        evidence.judged = true;
        sum += *evidence.views_log_ratio;
      }
      if (sum == 0.0) continue;
      parts[k] = VisibleLogRatio(term, tempering * sum);
      totals[i] += parts[k];
    }
    evidence.decided_by = Decisive(parts, totals[i] > 0);
    evidence.from_memory = remembered && !(now * totals[i] > 0);
    evidence.own_car = options_.own_car && IsKnown(frame.points[i].now) &&
                       IsOwnCar(next.own_car, frame.points[i].now);
    if (evidence.judged && !evidence.own_car && frame.points[i].estimates) {
      estimating.push_back(totals[i]);
    }
  }
  if (!estimating.empty()) {
    next.mover_share =
        options_.noise_memory * next.mover_share +
        (1 - options_.noise_memory) * EstimateMoverShare(estimating, next.mover_share);
  }
  next.memories.clear();
  for (size_t i = 0; i < frame.points.size(); ++i) {
    PointEvidence& evidence = result.points[i];
    if (evidence.own_car) {
      evidence.probability = 0.0;
      continue;
    }
    if (!evidence.judged) continue;
    evidence.probability = ProbabilityOf(totals[i], next.mover_share);
    if (options_.accumulation && sums[i].track_id >= 0) next.memories.push_back(sums[i]);
  }
  std::sort(next.memories.begin(), next.memories.end(),
            [](const auto& a, const auto& b) { return a.track_id < b.track_id; });
}

absl::StatusOr<EvidenceResult> EvidenceAccumulator::Add(const EvidenceFrame& frame) {
  EGOSIEVE_RETURN_IF_ERROR(CheckFrame(frame, state_.last_index));
  EGOSIEVE_RETURN_IF_ERROR(ByTrack(frame.points).status());
  EvidenceState next = state_;
  if (next.size != frame.size) {
    next = {};
    next.size = frame.size;
  }
  next.last_index = frame.index;

  EvidenceResult result;
  result.points.resize(frame.points.size());
  const Motion motion = MotionOf(frame, next);
  const std::optional<PhotometricSupport> pictures = PicturesOf(frame);
  const PhotometricSupport* both = pictures ? &*pictures : nullptr;
  Measure(frame, motion, both, result);
  const RoadPlane road = MeasureRoad(frame, motion, both, next, result);
  result.road = road.found;
  if (options_.own_car && !frame.grey.empty()) {
    const WorldMotion world = {motion.pose.found(), motion.matrix, motion.pose,
                               motion.camera,       road,          motion.pairs};
    const bool known = world.has_line || motion.kind == MotionModelKind::kHomography;
    LearnOwnCar(frame.grey, frame.index, frame.gap, known ? &world : nullptr,
                options_.own_car_options, next.own_car);
  }
  Fuse(frame, next, result);
  std::erase_if(next.poses,
                [&](const auto& pose) { return pose.index <= frame.index - frame.gap; });
  if (motion.pose.found()) next.poses.push_back({frame.index, frame.gap, motion.pose});

  result.pose = motion.pose.outcome;
  result.three_views = motion.three_views.found;
  result.pose_line = motion.pose_line;
  result.noise_pixels = motion.noise_pixels;
  result.mover_share = next.mover_share;
  result.standing_probability = ProbabilityOf(
      VisibleLogRatio(EvidenceTerm::kEpipolar, DistanceLogRatio(0.0)), next.mover_share);
  state_ = std::move(next);
  return result;
}

void EvidenceAccumulator::Interrupt() {
  state_.memories.clear();
  state_.poses.clear();
  state_.road = {};
  state_.own_car.images.clear();
}

absl::Status EvidenceAccumulator::Restore(EvidenceState state) {
  const bool sorted =
      std::is_sorted(state.memories.begin(), state.memories.end(),
                     [](const auto& a, const auto& b) { return a.track_id < b.track_id; });
  const size_t blocks = state.own_car.blocks.area();
  const bool whole = sorted && std::isfinite(state.log_noise) && state.mover_share > 0 &&
                     state.mover_share < 1 && state.own_car.sums.size() == blocks &&
                     state.own_car.is_own.size() == blocks;
  if (!whole) return absl::InvalidArgumentError("the state of the evidence is not whole");
  for (const OwnCarState::HalfImage& image : state.own_car.images) {
    if (image.pixels.size() != static_cast<size_t>(image.size.area())) {
      return absl::InvalidArgumentError("the state of the evidence has a torn image");
    }
  }
  state_ = std::move(state);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
