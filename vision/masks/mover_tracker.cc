#include "vision/masks/mover_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "vision/masks/motion_split.h"
#include "vision/masks/regions.h"
#include "vision/masks/stray_pieces.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {
namespace {

constexpr int kNumbers = 65535;
// Flow's forward-backward error is below about 1.2 pixels.
constexpr float kLeastAgreement = 0.5f;
constexpr double kMotionScale = 0.7;  // pixels, of a mover's motion between two frames
constexpr int kMotionStep = 2;        // pixels; every second pixel suffices
// A piece that no mover explains is compared with movers from this many times min_pixels on.
constexpr int kLargeInSpecks = 4;
// Smaller pieces that touch another mover are more often a part of it than movers of their own. In
// units of min_pixels.
constexpr int kFragmentInSpecks = 8;
constexpr int kMostSplits = 3;  // of one mover in one frame
// Movers touch where this share of the pixels around one of them belongs to the other.
constexpr double kContact = 0.2;
constexpr int kTouch = 2, kWorldReach = 12;  // pixels
constexpr double kMovesAsWorldPixels = 1.0;
constexpr size_t kLeastPlaces = 6;
// Shares of a mover's motion by which a new part beside it (kJoins), and a mover to be merged with
// it (kIsOne), may differ. Parts of one mover also differ where it turns or approaches.
constexpr double kJoins = 0.4, kIsOne = 0.05;

// The links from `now` onwards, or else backwards from it, that end within `seconds`.
std::vector<FlowPair> LinksFrom(const std::vector<TrackedFrame>& frames, size_t now,
                                double seconds) {
  std::vector<FlowPair> links;
  const double time = frames[now].time_seconds;
  for (size_t t = now + 1; t < frames.size() && !frames[t].flow.forward.empty(); ++t) {
    if (frames[t].time_seconds - time > seconds * (1.0 + 1e-9)) break;
    links.push_back(frames[t].flow);
  }
  if (!links.empty()) return links;
  for (size_t t = now; t > 0 && !frames[t].flow.forward.empty(); --t) {
    if (time - frames[t - 1].time_seconds > seconds * (1.0 + 1e-9)) break;
    links.push_back({frames[t].flow.backward, frames[t].flow.forward});
  }
  return links;
}

// The pixels of `region` that are nearer to the cells of the smaller part.
cv::Mat1b PixelsOfPart(const MovingCells& cells, const MotionSplit& split,
                       const cv::Mat1b& region) {
  const auto distance_from = [&](const std::vector<int>& of) {
    cv::Mat1b is_elsewhere(region.size(), uint8_t{255});
    for (const int i : of) {
      const cv::Point corner = cells.cells[i] * cells.side;
      is_elsewhere(cv::Rect(corner, cv::Size(cells.side, cells.side))) = 0;
    }
    cv::Mat1f distance;
    cv::distanceTransform(is_elsewhere, distance, cv::DIST_L2, cv::DIST_MASK_5);
    return distance;
  };
  return (distance_from(split.smaller) < distance_from(split.larger)) & (region != 0);
}

// The motion of the region's pixels where flow and its return agree; their number in `count`.
MoverMotion MotionIn(const cv::Mat1b& region, const cv::Mat& flow, const cv::Mat1f& agreement,
                     size_t* count) {
  std::vector<cv::Point2f> places, steps;
  for (int y = 0; y < region.rows; y += kMotionStep) {
    for (int x = 0; x < region.cols; x += kMotionStep) {
      if (region(y, x) == 0 || agreement(y, x) < kLeastAgreement) continue;
      places.emplace_back(static_cast<float>(x), static_cast<float>(y));
      const cv::Vec2f& step = flow.at<cv::Vec2f>(y, x);
      steps.emplace_back(step[0], step[1]);
    }
  }
  *count = places.size();
  return FitMotion(places, steps, kMotionScale);
}

double ColourDistance(absl::Span<const double> a, absl::Span<const double> b) {
  double overlap = 0.0;
  for (size_t i = 0; i < a.size(); ++i) overlap += std::sqrt(a[i] * b[i]);
  return std::sqrt(std::max(0.0, 1.0 - overlap));
}

}  // namespace

struct MoverTracker::Scene {
  double time_seconds = 0.0, step_seconds = 0.0;  // since the frame before
  AssignmentPictures pictures;
  RegionLabels regions;  // of the mask
  MovingCells cells;
  std::vector<FlowPair> links;
};

absl::Status MoverTrackerOptions::Validate() const {
  if (min_pixels >= 1 && lost_seconds >= 0.0 && look_seconds > 0.0 && merge_votes >= 1 &&
      max_distance >= 0.0) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "min_pixels = %d, lost_seconds = %g, look_seconds = %g, merge_votes = %d, max_distance = %g; "
      "min_pixels and merge_votes must be at least 1, look_seconds positive, the others not "
      "negative",
      min_pixels, lost_seconds, look_seconds, merge_votes, max_distance));
}

cv::Mat1w MoverTracker::Add(const std::vector<TrackedFrame>& frames, size_t now,
                            const cv::Mat1b& mask) {
  Scene scene;
  scene.time_seconds = frames[now].time_seconds;
  scene.pictures.now = frames[now].image;
  scene.pictures.mask = mask;
  scene.regions = RegionLabels(mask);
  scene.links = LinksFrom(frames, now, options_.look_seconds);
  scene.cells = FollowCells(mask, scene.links);
  cv::Mat1w numbers = cv::Mat1w::zeros(mask.size());
  if (now > 0 && !frames[now].flow.forward.empty() && last_.size() == mask.size()) {
    scene.step_seconds = scene.time_seconds - frames[now - 1].time_seconds;
    scene.pictures.before = frames[now - 1].image;
    scene.pictures.from_before = frames[now].flow;
    if (now + 1 < frames.size() && !frames[now + 1].flow.forward.empty()) {
      scene.pictures.after = frames[now + 1].image;
      scene.pictures.to_after = frames[now + 1].flow;
    }
    numbers = AssignKnown(scene);
  }
  DropStrays(scene.regions, options_.min_pixels, numbers);
  FillRegions(scene, numbers);
  SplitMovers(scene, numbers);
  MergeMovers(scene, numbers);
  DropFragments(numbers);
  Remember(scene, numbers);
  last_ = numbers;
  return numbers.clone();
}

cv::Mat1w MoverTracker::AssignKnown(const Scene& scene) const {
  const FlowPair& flow = scene.pictures.from_before;
  const cv::Mat1f agreement = FlowAgreement(flow.forward, flow.backward, 1.0);
  std::vector<KnownMover> known;
  for (const auto& [number, count] : CountNumbers(last_, last_ != 0)) {
    const Mover& mover = movers_.at(number);
    size_t places = 0;
    MoverMotion motion = MotionIn(last_ == number, flow.forward, agreement, &places);
    if (places < kLeastPlaces) {
      motion = MoverMotion{mover.centre, mover.speed * scene.step_seconds, cv::Matx22d::zeros()};
    }
    known.push_back({number, motion, &mover.colours});
  }
  return AssignPixels(scene.pictures, last_, known);
}

// The mover among `among` whose motion is nearest to that of a piece, and their MotionDistance;
// nothing where too little is known of the motions.
std::optional<std::pair<double, uint16_t>> MoverTracker::NearestMotion(
    const Scene& scene, const cv::Mat1b& piece, const std::map<uint16_t, int>& among,
    const cv::Mat1w& numbers) {
  const CellsByNumber cells = CellsOf(scene.cells, numbers);
  const std::vector<int> own = CellsIn(scene.cells, piece);
  std::optional<std::pair<double, uint16_t>> nearest;
  for (const auto& [number, count] : among) {
    const auto others = cells.find(number);
    if (others == cells.end()) continue;
    const std::optional<double> distance = MotionDistance(scene.cells, own, others->second, kJoins);
    if (distance && (!nearest || *distance < nearest->first)) nearest = {*distance, number};
  }
  return nearest;
}

void MoverTracker::FillRegions(const Scene& scene, cv::Mat1w& numbers) {
  std::vector<Piece> unknown;
  for (const Piece& region : PiecesOf(scene.pictures.mask)) {
    const std::map<uint16_t, int> known = CountNumbers(numbers, region.pixels);
    if (known.empty()) {
      if (region.area >= options_.min_pixels) unknown.push_back(region);
      continue;
    }
    cv::Mat1b rest = region.pixels.clone();
    for (const Piece& piece : PiecesOf(region.pixels & (numbers == 0))) {
      if (piece.area < kLargeInSpecks * options_.min_pixels) break;
      const auto nearest = NearestMotion(scene, piece.pixels, known, numbers);
      if (!nearest) continue;
      if (nearest->first < 1.0) {
        numbers.setTo(nearest->second, piece.pixels);
      } else {
        unknown.push_back(piece);
        rest.setTo(0, piece.pixels);
      }
    }
    FillNearest(rest, numbers);
  }
  for (const Piece& piece : unknown) {
    numbers.setTo(NumberFor(Describe(scene, piece.pixels), numbers), piece.pixels);
  }
}

uint16_t MoverTracker::NumberFor(const Mover& seen, const cv::Mat1w& numbers) {
  const std::map<uint16_t, int> taken = CountNumbers(numbers, numbers != 0);
  uint16_t best = 0;
  double best_distance = options_.max_distance;
  for (const auto& [number, mover] : movers_) {
    const double lost = seen.last_seconds - mover.last_seconds;
    if (taken.count(number) > 0 || lost > options_.lost_seconds) continue;
    const double ratio = seen.pixels / mover.pixels;
    const double side = std::sqrt(std::max(seen.pixels, mover.pixels));
    const cv::Point2d expected = mover.centre + mover.speed * lost;
    const double reach = side + 0.5 * cv::norm(mover.speed) * lost;
    if (ratio < 0.33 || ratio > 3.0 || cv::norm(seen.centre - expected) > reach) continue;
    const double distance = ColourDistance(seen.colours, mover.colours);
    if (distance < best_distance) {
      best = number;
      best_distance = distance;
    }
  }
  return best != 0 ? best : NewNumber();
}

void MoverTracker::SplitMovers(const Scene& scene, cv::Mat1w& numbers) {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    for (int i = 0; i < kMostSplits; ++i) {
      const cv::Mat1b region = numbers == number;
      const auto split = SplitByMotion(scene.cells, CellsIn(scene.cells, region));
      if (!split) break;
      const cv::Mat1b part = PixelsOfPart(scene.cells, *split, region);
      if (cv::countNonZero(part) == 0) break;
      numbers.setTo(MovesAsWorld(scene, part) ? 0 : NumberOfPart(scene, part, number, numbers),
                    part);
    }
  }
}

bool MoverTracker::MovesAsWorld(const Scene& scene, const cv::Mat1b& part) {
  const FlowPair& flow = scene.links.front();  // not empty, since a part was found by them
  const cv::Mat1f agreement = FlowAgreement(flow.forward, flow.backward, 1.0);
  cv::Mat1b around = RingAround(part, kWorldReach), moving;
  cv::dilate(scene.pictures.mask, moving, cv::Mat::ones(2 * kTouch + 1, 2 * kTouch + 1, CV_8U));
  around.setTo(0, moving);
  size_t of_part = 0, of_world = 0;
  const MoverMotion own = MotionIn(part, flow.forward, agreement, &of_part);
  const MoverMotion world = MotionIn(around, flow.forward, agreement, &of_world);
  return std::min(of_part, of_world) >= kLeastPlaces &&
         cv::norm(own.shift - world.At(own.centre)) < kMovesAsWorldPixels;
}

uint16_t MoverTracker::NumberOfPart(const Scene& scene, const cv::Mat1b& part, uint16_t whole,
                                    const cv::Mat1w& numbers) {
  const Mover seen = Describe(scene, part);
  std::map<uint16_t, int> touched = CountNumbers(numbers, RingAround(part, kTouch));
  for (auto entry = touched.begin(); entry != touched.end();) {
    const auto mover = movers_.find(entry->first);
    const bool may_be_it =
        entry->first != whole && mover != movers_.end() &&
        ColourDistance(seen.colours, mover->second.colours) < options_.max_distance;
    entry = may_be_it ? std::next(entry) : touched.erase(entry);
  }
  const auto nearest = NearestMotion(scene, part, touched, numbers);
  return nearest && nearest->first < 1.0 ? nearest->second : NumberFor(seen, numbers);
}

void MoverTracker::RememberApart(const Scene& scene, const cv::Mat1w& numbers) {
  std::map<uint16_t, Piece> largest;
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    if (count < kFragmentInSpecks * options_.min_pixels) continue;
    largest.emplace(number, PiecesOf(numbers == number).front());
  }
  for (const auto& [a, piece_a] : largest) {
    for (const auto& [b, piece_b] : largest) {
      if (a < b && scene.regions.LieApart(piece_a, piece_b)) apart_.insert({a, b});
    }
  }
}

void MoverTracker::MergeMovers(const Scene& scene, cv::Mat1w& numbers) {
  RememberApart(scene, numbers);
  std::vector<std::pair<int, uint16_t>> by_size;
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    by_size.emplace_back(count, number);
  }
  std::sort(by_size.begin(), by_size.end());
  for (const auto& [count, number] : by_size) {
    if (count < options_.min_pixels) continue;
    const uint16_t partner = PartnerOf(scene, number, numbers);
    if (partner == 0) continue;
    const auto first_seen = [&](uint16_t of) {
      const auto mover = movers_.find(of);
      return mover == movers_.end() ? scene.time_seconds : mover->second.first_seconds;
    };
    const bool is_older = first_seen(number) < first_seen(partner);
    const uint16_t stays = is_older ? number : partner, goes = is_older ? partner : number;
    numbers.setTo(stays, numbers == goes);
    movers_.erase(goes);
    for (auto vote = votes_.begin(); vote != votes_.end();) {
      const bool is_of_it = vote->first.first == goes || vote->first.second == goes;
      vote = is_of_it ? votes_.erase(vote) : std::next(vote);
    }
  }
}

// The mover that `number` has touched and moved with for long enough; 0: none.
uint16_t MoverTracker::PartnerOf(const Scene& scene, uint16_t number, const cv::Mat1w& numbers) {
  const cv::Mat1b ring = RingAround(numbers == number, kTouch);
  const double least = kContact * cv::countNonZero(ring);
  const CellsByNumber cells = CellsOf(scene.cells, numbers);
  const auto own = cells.find(number);
  if (own == cells.end()) return 0;
  for (const auto& [other, contact] : CountNumbers(numbers, ring)) {
    const auto others = cells.find(other);
    if (contact < least || others == cells.end()) continue;
    if (apart_.count(std::minmax(number, other)) > 0) continue;
    const std::optional<double> distance =
        MotionDistance(scene.cells, own->second, others->second, kIsOne);
    int& votes = votes_[{number, other}];
    votes = distance && *distance < 1.0 ? votes + 1 : 0;
    if (votes >= options_.merge_votes) return other;
  }
  return 0;
}

void MoverTracker::DropFragments(cv::Mat1w& numbers) const {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    if (count >= kFragmentInSpecks * options_.min_pixels) continue;
    const cv::Mat1b region = numbers == number;
    const cv::Mat1b ring = RingAround(region, kTouch);
    const std::map<uint16_t, int> touched = CountNumbers(numbers, ring);
    const auto most =
        std::max_element(touched.begin(), touched.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != touched.end() && most->second >= kContact * cv::countNonZero(ring)) {
      numbers.setTo(most->first, region);
    } else if (2 * count < options_.min_pixels) {
      numbers.setTo(0, region);
    }
  }
}

void MoverTracker::Remember(const Scene& scene, const cv::Mat1w& numbers) {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    Mover now = Describe(scene, numbers == number);
    const auto before = movers_.find(number);
    if (before != movers_.end()) {
      const double seconds = scene.time_seconds - before->second.last_seconds;
      now.first_seconds = before->second.first_seconds;
      now.speed = before->second.speed;
      if (seconds > 0.0) {
        now.speed = 0.5 * now.speed + 0.5 / seconds * (now.centre - before->second.centre);
      }
      for (int i = 0; i < kMoverColours; ++i) {
        now.colours[i] = 0.8 * before->second.colours[i] + 0.2 * now.colours[i];
      }
    }
    movers_[number] = now;
  }
  std::erase_if(movers_, [&](const auto& mover) {
    return scene.time_seconds - mover.second.last_seconds > options_.lost_seconds;
  });
  const auto are_known = [&](const std::pair<uint16_t, uint16_t>& pair) {
    return movers_.count(pair.first) > 0 && movers_.count(pair.second) > 0;
  };
  std::erase_if(apart_, [&](const auto& pair) { return !are_known(pair); });
  std::erase_if(votes_,
                [&](const auto& vote) { return vote.second == 0 || !are_known(vote.first); });
}

uint16_t MoverTracker::NewNumber() {
  while (movers_.count(static_cast<uint16_t>(next_number_)) > 0) {
    next_number_ = next_number_ % kNumbers + 1;
  }
  const auto number = static_cast<uint16_t>(next_number_);
  next_number_ = next_number_ % kNumbers + 1;
  return number;
}

MoverTracker::Mover MoverTracker::Describe(const Scene& scene, const cv::Mat1b& region) {
  Mover mover;
  mover.first_seconds = mover.last_seconds = scene.time_seconds;
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (region(y, x) == 0) continue;
      ++mover.pixels;
      mover.centre += cv::Point2d(x, y);
      ++mover.colours[ColourOf(scene.pictures.now(y, x))];
    }
  }
  mover.centre /= std::max(mover.pixels, 1.0);
  for (double& share : mover.colours) share /= std::max(mover.pixels, 1.0);
  return mover;
}

}  // namespace egosieve::vision
