#include "vision/masks/mover_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "absl/strings/str_format.h"
#include "vision/masks/motion_split.h"
#include "vision/masks/regions.h"

namespace egosieve::vision {
namespace {

// Flow's forward-backward error is below about 1.2 pixels.
constexpr float kLeastAgreement = 0.5f;
constexpr double kMotionScale = 0.7;  // pixels, of a mover's motion between two frames
constexpr int kMotionStep = 2;        // pixels; every second pixel suffices
// A piece that no mover explains is compared with movers from this size on.
constexpr int kLargePixels = 4 * kMinMoverPixels;
// Smaller pieces that touch another mover are more often a part of it than movers of their own.
constexpr int kFragmentPixels = 8 * kMinMoverPixels;
constexpr int kMostSplits = 3;  // of one mover in one frame
// Movers touch where this share of the pixels around one of them belongs to the other.
constexpr double kContact = 0.2;
constexpr int kTouch = 2;  // pixels
constexpr size_t kLeastPlaces = 6;
// Share of a mover's motion by which a new part beside it may differ: parts of one mover also differ
// where it turns or approaches.
constexpr double kJoins = 0.4;
constexpr double kColourDistance = 0.45;  // Bhattacharyya's, between a part and what it joins
// Of a new frame in a mover's speed and colours.
constexpr double kSpeedWeight = 0.5, kColourWeight = 0.2;

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

}  // namespace

void DropGlimpses(const std::vector<uint16_t>& first_seen, const cv::Mat1w& next,
                  cv::Mat1w& numbers) {
  for (const uint16_t number : first_seen) {
    if (cv::countNonZero(next == number) > 0) continue;
    const cv::Mat1b place = numbers == number;
    if (2 * cv::countNonZero(place & (next != 0)) < cv::countNonZero(place)) {
      numbers.setTo(0, place);
    }
  }
}

struct MoverTracker::Scene {
  double step_seconds = 0.0;  // since the frame before; 0: none
  AssignmentPictures pictures;
  MovingCells cells;
  std::vector<FlowPair> links;
};

cv::Mat1w MoverTracker::Add(const std::vector<TrackedFrame>& frames, size_t now,
                            const cv::Mat1b& mask) {
  Scene scene;
  scene.pictures.now = frames[now];
  scene.pictures.mask = mask;
  scene.links = LinksFrom(frames, now, kLookSeconds);
  scene.cells = FollowCells(mask, scene.links);
  cv::Mat1w numbers = cv::Mat1w::zeros(mask.size());
  if (now > 0 && !frames[now].flow.forward.empty() && last_.size() == mask.size()) {
    scene.step_seconds = frames[now].time_seconds - frames[now - 1].time_seconds;
    scene.pictures.before = frames[now - 1];
    if (now + 1 < frames.size() && !frames[now + 1].flow.forward.empty()) {
      scene.pictures.after = frames[now + 1];
    }
    numbers = AssignKnown(scene);
  }
  FillRegions(scene, numbers);
  SplitMovers(scene, numbers);
  DropFragments(numbers);
  Remember(scene, numbers);
  last_ = numbers;
  return numbers.clone();
}

cv::Mat1w MoverTracker::AssignKnown(const Scene& scene) const {
  const TrackedFrame& now = scene.pictures.now;
  const cv::Mat1f agreement = AgreementOf(now.errors.forward, 1.0);
  std::vector<KnownMover> known;
  for (const auto& [number, count] : CountNumbers(last_, last_ != 0)) {
    const Mover& mover = movers_.at(number);
    size_t places = 0;
    MoverMotion motion = MotionIn(last_ == number, now.flow.forward, agreement, &places);
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
  const std::vector<int> own = CellsIn(scene.cells, piece);
  std::optional<std::pair<double, uint16_t>> nearest;
  for (const auto& [number, count] : among) {
    const std::vector<int> others = CellsIn(scene.cells, numbers == number);
    const std::optional<double> distance = MotionDistance(scene.cells, own, others, kJoins);
    if (distance && (!nearest || *distance < nearest->first)) nearest = {*distance, number};
  }
  return nearest;
}

void MoverTracker::FillRegions(const Scene& scene, cv::Mat1w& numbers) {
  std::vector<Piece> unknown;
  for (const Piece& region : PiecesOf(scene.pictures.mask)) {
    const std::map<uint16_t, int> known = CountNumbers(numbers, region.pixels);
    if (known.empty()) {
      if (region.area >= kMinMoverPixels) unknown.push_back(region);
      continue;
    }
    cv::Mat1b rest = region.pixels.clone();
    for (const Piece& piece : PiecesOf(region.pixels & (numbers == 0))) {
      if (piece.area < kLargePixels) break;
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
  for (const Piece& piece : unknown) numbers.setTo(NewNumber(numbers), piece.pixels);
}

void MoverTracker::SplitMovers(const Scene& scene, cv::Mat1w& numbers) {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    for (int i = 0; i < kMostSplits; ++i) {
      const cv::Mat1b region = numbers == number;
      const auto split = SplitByMotion(scene.cells, CellsIn(scene.cells, region));
      if (!split) break;
      const cv::Mat1b part = PixelsOfPart(scene.cells, *split, region);
      if (cv::countNonZero(part) == 0) break;
      numbers.setTo(NumberOfPart(scene, part, number, numbers), part);
    }
  }
}

uint16_t MoverTracker::NumberOfPart(const Scene& scene, const cv::Mat1b& part, uint16_t whole,
                                    const cv::Mat1w& numbers) {
  const Mover seen = Describe(scene, part);
  std::map<uint16_t, int> touched = CountNumbers(numbers, RingAround(part, kTouch));
  for (auto entry = touched.begin(); entry != touched.end();) {
    const auto mover = movers_.find(entry->first);
    const bool may_be_it = entry->first != whole && mover != movers_.end() &&
                           ColourDistance(seen.colours, mover->second.colours) < kColourDistance;
    entry = may_be_it ? std::next(entry) : touched.erase(entry);
  }
  const auto nearest = NearestMotion(scene, part, touched, numbers);
  return nearest && nearest->first < 1.0 ? nearest->second : NewNumber(numbers);
}

void MoverTracker::DropFragments(cv::Mat1w& numbers) {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    if (count >= kFragmentPixels) continue;
    const cv::Mat1b region = numbers == number;
    const cv::Mat1b ring = RingAround(region, kTouch);
    const std::map<uint16_t, int> touched = CountNumbers(numbers, ring);
    const auto most =
        std::max_element(touched.begin(), touched.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != touched.end() && most->second >= kContact * cv::countNonZero(ring)) {
      numbers.setTo(most->first, region);
    } else if (2 * count < kMinMoverPixels) {
      numbers.setTo(0, region);
    }
  }
}

void MoverTracker::Remember(const Scene& scene, const cv::Mat1w& numbers) {
  std::map<uint16_t, Mover> movers;
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    Mover now = Describe(scene, numbers == number);
    const auto before = movers_.find(number);
    if (before != movers_.end()) {
      now.is_new = false;
      now.speed = before->second.speed;
      if (scene.step_seconds > 0.0) {
        const cv::Point2d speed = (now.centre - before->second.centre) / scene.step_seconds;
        now.speed += kSpeedWeight * (speed - now.speed);
      }
      for (int i = 0; i < kMoverColours; ++i) {
        now.colours[i] = before->second.colours[i] +
                         kColourWeight * (now.colours[i] - before->second.colours[i]);
      }
    }
    movers[number] = now;
  }
  movers_ = std::move(movers);
}

uint16_t MoverTracker::NewNumber(const cv::Mat1w& numbers) {
  const auto is_taken = [&](int number) {
    return movers_.count(static_cast<uint16_t>(number)) > 0 ||
           cv::countNonZero(numbers == number) > 0;
  };
  return NextNumber(is_taken, next_number_);
}

MoverTracker::Mover MoverTracker::Describe(const Scene& scene, const cv::Mat1b& region) {
  Mover mover;
  double pixels = 0.0;
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (region(y, x) == 0) continue;
      ++pixels;
      mover.centre += cv::Point2d(x, y);
      ++mover.colours[ColourOf(scene.pictures.now.image(y, x))];
    }
  }
  mover.centre /= std::max(pixels, 1.0);
  for (double& share : mover.colours) share /= std::max(pixels, 1.0);
  return mover;
}

std::vector<uint16_t> MoverTracker::SeenOnce() const {
  std::vector<uint16_t> numbers;
  for (const auto& [number, mover] : movers_) {
    if (mover.is_new) numbers.push_back(number);
  }
  return numbers;
}

std::string MoverTracker::ToText() const {
  // Run lengths: number, pixels, number, pixels, ...
  std::vector<int> runs;
  for (const uint16_t number : last_) {
    if (runs.empty() || runs[runs.size() - 2] != number) runs.insert(runs.end(), {number, 0});
    ++runs.back();
  }
  nlohmann::ordered_json json = {{"next_number", next_number_},
                                 {"last_size", {last_.cols, last_.rows}},
                                 {"last_runs", runs},
                                 {"movers", nlohmann::ordered_json::array()}};
  for (const auto& [number, mover] : movers_) {
    json["movers"].push_back({{"number", number},
                              {"is_new", mover.is_new},
                              {"centre", {mover.centre.x, mover.centre.y}},
                              {"speed", {mover.speed.x, mover.speed.y}},
                              {"colours", mover.colours}});
  }
  return json.dump();
}

absl::StatusOr<MoverTracker> MoverTracker::Restore(absl::string_view text) {
  MoverTracker tracker;
  try {
    const auto json = nlohmann::json::parse(text);
    tracker.next_number_ = json.at("next_number").get<int>();
    const auto size = json.at("last_size").get<std::array<int, 2>>();
    const auto runs = json.at("last_runs").get<std::vector<int>>();
    std::vector<uint16_t> numbers;
    const int64_t pixels = int64_t{size[0]} * size[1];
    for (size_t i = 0; i + 1 < runs.size(); i += 2) {
      if (runs[i + 1] < 0 || runs[i + 1] > pixels) break;
      numbers.insert(numbers.end(), runs[i + 1], static_cast<uint16_t>(runs[i]));
    }
    if (static_cast<int64_t>(numbers.size()) != pixels) {
      return absl::DataLossError("the state of the movers has pixels missing");
    }
    if (!numbers.empty()) tracker.last_ = cv::Mat1w(size[1], size[0], numbers.data()).clone();
    for (const nlohmann::json& entry : json.at("movers")) {
      Mover mover;
      mover.is_new = entry.at("is_new").get<bool>();
      mover.centre = {entry.at("centre").at(0).get<double>(),
                      entry.at("centre").at(1).get<double>()};
      mover.speed = {entry.at("speed").at(0).get<double>(), entry.at("speed").at(1).get<double>()};
      mover.colours = entry.at("colours").get<ColourShares>();
      tracker.movers_[entry.at("number").get<uint16_t>()] = mover;
    }
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(
        absl::StrFormat("the state of the movers cannot be read: %s", error.what()));
  }
  return tracker;
}

}  // namespace egosieve::vision
