#include "vision/masks/mover_tracker.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "absl/strings/str_format.h"
#include "vision/masks/motion_split.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {
namespace {

constexpr int kNumbers = 65535;
// A prediction counts where the flow's forward-backward error is below about one pixel.
constexpr float kLeastAgreement = 0.6f;
// Of the largest piece of a number: smaller pieces are errors of flow, given to what is around.
constexpr double kLeastStray = 0.1;
// Flow differs where it does by so many pixels and so much of the faster one: parts of one mover
// that turns or comes near differ, too.
constexpr double kDifferentPixels = 1.5;
constexpr double kDifferentShare = 0.4;
// A piece is large from so many times the pixels of a speck.
constexpr int kLargeInSpecks = 4;

// Every pixel of `region` that has no number takes that of the nearest pixel of it that has one.
void FillNearest(const cv::Mat1b& region, cv::Mat1w& numbers) {
  cv::Mat1b is_empty(region.size(), uint8_t{255});
  is_empty.setTo(0, (numbers != 0) & (region != 0));
  if (cv::countNonZero(is_empty) == static_cast<int>(is_empty.total())) return;
  cv::Mat1f distance;
  cv::Mat1i labels;
  cv::distanceTransform(is_empty, distance, labels, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::vector<uint16_t> number_of(numbers.total() + 1, 0);
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (is_empty(y, x) == 0) number_of[labels(y, x)] = numbers(y, x);
    }
  }
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (region(y, x) != 0 && numbers(y, x) == 0) numbers(y, x) = number_of[labels(y, x)];
    }
  }
}

std::set<uint16_t> NumbersIn(const cv::Mat1w& numbers, const cv::Mat1b& region) {
  std::set<uint16_t> found;
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (region(y, x) != 0 && numbers(y, x) != 0) found.insert(numbers(y, x));
    }
  }
  return found;
}

struct Piece {
  cv::Mat1b pixels;
  int area = 0;
};

// 8-connected, the largest first; equal ones in the order of their first pixels.
std::vector<Piece> PiecesOf(const cv::Mat1b& region) {
  cv::Mat1i labels;
  cv::Mat stats, centres;
  const int count = cv::connectedComponentsWithStats(region, labels, stats, centres, 8, CV_32S);
  std::vector<Piece> pieces;
  for (int i = 1; i < count; ++i) {
    pieces.push_back({labels == i, stats.at<int>(i, cv::CC_STAT_AREA)});
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.area > b.area; });
  return pieces;
}

bool MoveAlike(const cv::Scalar& a, const cv::Scalar& b) {
  const double difference = std::hypot(a[0] - b[0], a[1] - b[1]);
  const double speed = std::max(std::hypot(a[0], a[1]), std::hypot(b[0], b[1]));
  return difference <= kDifferentPixels + kDifferentShare * speed;
}

// Pieces of `region` without a number, of at least min_pixels, that move otherwise than the number
// that is nearest to them, as far as flow and its return agree in most of them: those that move as
// another number of the region take it, the others are returned.
std::vector<cv::Mat1b> StrangersIn(const cv::Mat1b& region, const FlowPair& flow, int min_pixels,
                                   cv::Mat1w& numbers) {
  std::vector<cv::Mat1b> strangers;
  if (flow.backward.empty()) return strangers;
  const std::vector<Piece> pieces = PiecesOf(region & (numbers == 0));
  if (pieces.empty() || pieces.front().area < min_pixels) return strangers;
  const cv::Mat1b holds = FlowAgreement(flow.backward, flow.forward, 1.0) >= kLeastAgreement;
  std::map<uint16_t, cv::Scalar> motions;
  for (const uint16_t number : NumbersIn(numbers, region)) {
    motions[number] = cv::mean(flow.backward, (numbers == number) & region);
  }
  cv::Mat1w filled = numbers.clone();
  FillNearest(region, filled);
  for (const Piece& piece : pieces) {
    const cv::Mat1b known = piece.pixels & holds;
    if (piece.area < min_pixels || 2 * cv::countNonZero(known) < piece.area) continue;
    const cv::Scalar own = cv::mean(flow.backward, known);
    uint16_t nearest = 0;
    int most = 0;
    for (const auto& [number, motion] : motions) {
      const int pixels = cv::countNonZero((filled == number) & piece.pixels);
      if (pixels > most) {
        nearest = number;
        most = pixels;
      }
    }
    if (nearest == 0 || MoveAlike(own, motions[nearest])) continue;
    const auto alike = std::find_if(motions.begin(), motions.end(), [&](const auto& entry) {
      return MoveAlike(own, entry.second);
    });
    if (alike != motions.end()) {
      numbers.setTo(alike->first, piece.pixels);
    } else {
      strangers.push_back(piece.pixels);
    }
  }
  return strangers;
}

double ColourDistance(absl::Span<const double> a, absl::Span<const double> b) {
  double overlap = 0.0;
  for (size_t i = 0; i < a.size(); ++i) overlap += std::sqrt(a[i] * b[i]);
  return std::sqrt(std::max(0.0, 1.0 - overlap));
}

}  // namespace

absl::Status MoverTrackerOptions::Validate() const {
  if (min_pixels >= 1 && lost_seconds >= 0.0 && split_votes >= 1 && min_piece > 0.0 &&
      max_distance >= 0.0) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "min_pixels = %d, lost_seconds = %g, split_votes = %d, min_piece = %g, max_distance = %g; "
      "min_pixels and split_votes must be at least 1, min_piece positive, the others not negative",
      min_pixels, lost_seconds, split_votes, min_piece, max_distance));
}

cv::Mat1w MoverTracker::Add(double time_seconds, const cv::Mat3b& image, const cv::Mat1b& mask,
                            const FlowPair& flow) {
  cv::Mat1w numbers = FillRegions(image, mask, time_seconds, flow, Predict(mask, flow));
  SplitMovers(time_seconds, image, flow, numbers);
  Remember(time_seconds, image, numbers);
  last_ = numbers;
  return numbers.clone();
}

cv::Mat1w MoverTracker::Predict(const cv::Mat1b& mask, const FlowPair& flow) const {
  cv::Mat1w numbers = cv::Mat1w::zeros(mask.size());
  if (flow.backward.empty() || last_.size() != mask.size()) return numbers;
  const cv::Mat1w warped = WarpByFlow(last_, flow.backward, cv::INTER_NEAREST);
  const cv::Mat1f agreement = FlowAgreement(flow.backward, flow.forward, 1.0);
  warped.copyTo(numbers, (mask != 0) & (agreement >= kLeastAgreement));
  // What strays from its mover is an error of flow.
  for (const uint16_t number : NumbersIn(numbers, mask)) {
    const std::vector<Piece> pieces = PiecesOf(numbers == number);
    for (const Piece& piece : pieces) {
      if (piece.area < kLeastStray * pieces.front().area) numbers.setTo(0, piece.pixels);
    }
  }
  return numbers;
}

cv::Mat1w MoverTracker::FillRegions(const cv::Mat3b& image, const cv::Mat1b& mask,
                                    double time_seconds, const FlowPair& flow, cv::Mat1w numbers) {
  std::vector<cv::Mat1b> unknown;
  for (const Piece& piece : PiecesOf(mask)) {
    if (!NumbersIn(numbers, piece.pixels).empty()) {
      cv::Mat1b rest = piece.pixels.clone();
      for (const cv::Mat1b& stranger :
           StrangersIn(piece.pixels, flow, kLargeInSpecks * options_.min_pixels, numbers)) {
        unknown.push_back(stranger);
        rest.setTo(0, stranger);
      }
      FillNearest(rest, numbers);
    } else if (piece.area >= options_.min_pixels) {
      unknown.push_back(piece.pixels);
    }
  }
  for (const cv::Mat1b& region : unknown) {
    numbers.setTo(NumberFor(Describe(image, region, time_seconds), numbers, time_seconds), region);
  }
  return numbers;
}

uint16_t MoverTracker::NumberFor(const Mover& seen, const cv::Mat1w& numbers, double time_seconds) {
  const std::set<uint16_t> taken = NumbersIn(numbers, numbers != 0);
  uint16_t best = 0;
  double best_distance = options_.max_distance;
  for (const auto& [number, mover] : movers_) {
    const double lost = time_seconds - mover.last_seconds;
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

uint16_t MoverTracker::NumberOfPart(const Mover& seen, const cv::Mat1b& part, uint16_t whole,
                                    const FlowPair& flow, const cv::Mat1w& numbers) {
  cv::Mat1b around;
  cv::dilate(part, around, cv::Mat(), {-1, -1}, 2);
  for (const uint16_t number : NumbersIn(numbers, around)) {
    const auto mover = movers_.find(number);
    if (number == whole || mover == movers_.end() || flow.backward.empty()) continue;
    const bool moves_alike =
        MoveAlike(cv::mean(flow.backward, part), cv::mean(flow.backward, numbers == number));
    if (moves_alike &&
        ColourDistance(seen.colours, mover->second.colours) < options_.max_distance) {
      return number;
    }
  }
  return NumberFor(seen, numbers, seen.last_seconds);
}

void MoverTracker::SplitMovers(double time_seconds, const cv::Mat3b& image, const FlowPair& flow,
                               cv::Mat1w& numbers) {
  for (const uint16_t number : NumbersIn(numbers, numbers != 0)) {
    const cv::Mat1b region = numbers == number;
    const std::vector<Piece> pieces = PiecesOf(region);
    cv::Mat1b part;
    if (pieces.size() > 1 && pieces[1].area >= options_.min_piece * pieces[0].area &&
        pieces[1].area >= options_.min_pixels) {
      part = pieces[1].pixels;
    } else if (!flow.backward.empty()) {
      const cv::Mat1b parts = SplitByMotion(region, flow.backward);
      if (!parts.empty()) part = parts == 2;
    }
    const auto mover = movers_.find(number);
    if (mover == movers_.end()) continue;
    mover->second.votes = part.empty() ? 0 : mover->second.votes + 1;
    if (mover->second.votes < options_.split_votes) continue;
    mover->second.votes = 0;
    numbers.setTo(NumberOfPart(Describe(image, part, time_seconds), part, number, flow, numbers),
                  part);
  }
}

void MoverTracker::Remember(double time_seconds, const cv::Mat3b& image, const cv::Mat1w& numbers) {
  for (const uint16_t number : NumbersIn(numbers, numbers != 0)) {
    Mover now = Describe(image, numbers == number, time_seconds);
    const auto before = movers_.find(number);
    if (before != movers_.end()) {
      const double seconds = time_seconds - before->second.last_seconds;
      now.votes = before->second.votes;
      now.speed = before->second.speed;
      if (seconds > 0.0) {
        now.speed = 0.5 * now.speed + 0.5 / seconds * (now.centre - before->second.centre);
      }
      for (int i = 0; i < kColours; ++i) {
        now.colours[i] = 0.8 * before->second.colours[i] + 0.2 * now.colours[i];
      }
    }
    movers_[number] = now;
  }
  for (auto mover = movers_.begin(); mover != movers_.end();) {
    const bool is_gone = time_seconds - mover->second.last_seconds > options_.lost_seconds;
    mover = is_gone ? movers_.erase(mover) : std::next(mover);
  }
}

uint16_t MoverTracker::NewNumber() {
  while (movers_.count(static_cast<uint16_t>(next_number_)) > 0) {
    next_number_ = next_number_ % kNumbers + 1;
  }
  const auto number = static_cast<uint16_t>(next_number_);
  next_number_ = next_number_ % kNumbers + 1;
  return number;
}

MoverTracker::Mover MoverTracker::Describe(const cv::Mat3b& image, const cv::Mat1b& region,
                                           double time_seconds) {
  Mover mover;
  mover.last_seconds = time_seconds;
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      if (region(y, x) == 0) continue;
      ++mover.pixels;
      mover.centre += cv::Point2d(x, y);
      const cv::Vec3b& colour = image(y, x);
      ++mover.colours[(colour[0] >> 6) * 16 + (colour[1] >> 6) * 4 + (colour[2] >> 6)];
    }
  }
  mover.centre /= std::max(mover.pixels, 1.0);
  for (double& share : mover.colours) share /= std::max(mover.pixels, 1.0);
  return mover;
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
                              {"last_seconds", mover.last_seconds},
                              {"centre", {mover.centre.x, mover.centre.y}},
                              {"speed", {mover.speed.x, mover.speed.y}},
                              {"pixels", mover.pixels},
                              {"colours", mover.colours},
                              {"votes", mover.votes}});
  }
  return json.dump();
}

absl::StatusOr<MoverTracker> MoverTracker::Restore(const MoverTrackerOptions& options,
                                                   absl::string_view text) {
  MoverTracker tracker(options);
  try {
    const auto json = nlohmann::json::parse(text);
    tracker.next_number_ = json.at("next_number").get<int>();
    const auto size = json.at("last_size").get<std::array<int, 2>>();
    const auto runs = json.at("last_runs").get<std::vector<int>>();
    std::vector<uint16_t> numbers;
    for (size_t i = 0; i + 1 < runs.size(); i += 2) {
      numbers.insert(numbers.end(), runs[i + 1], static_cast<uint16_t>(runs[i]));
    }
    if (static_cast<int64_t>(numbers.size()) != int64_t{size[0]} * size[1]) {
      return absl::DataLossError("the state of the movers has pixels missing");
    }
    if (!numbers.empty()) tracker.last_ = cv::Mat1w(size[1], size[0], numbers.data()).clone();
    for (const nlohmann::json& entry : json.at("movers")) {
      Mover mover;
      mover.last_seconds = entry.at("last_seconds").get<double>();
      mover.centre = {entry.at("centre").at(0).get<double>(),
                      entry.at("centre").at(1).get<double>()};
      mover.speed = {entry.at("speed").at(0).get<double>(), entry.at("speed").at(1).get<double>()};
      mover.pixels = entry.at("pixels").get<double>();
      mover.colours = entry.at("colours").get<std::array<double, kColours>>();
      mover.votes = entry.at("votes").get<int>();
      tracker.movers_[entry.at("number").get<uint16_t>()] = mover;
    }
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(
        absl::StrFormat("the state of the movers cannot be read: %s", error.what()));
  }
  return tracker;
}

}  // namespace egosieve::vision
