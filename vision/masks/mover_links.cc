#include "vision/masks/mover_links.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ranges>
#include <utility>

#include "absl/strings/str_format.h"
#include "vision/masks/regions.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kEndSeconds = 0.25;
// (ML2)
constexpr double kPlaceShare = 0.3, kSpeedNoise = 5.0, kSpeedShare = 0.4;
constexpr double kColours = 0.25, kMostCost = 8.0;
constexpr float kAgrees = 0.5f;
constexpr int kEverySecond = 2;  // pixels; every second pixel suffices
constexpr size_t kLeastSteps = 6;

// The median of flow over the pixels of each number where it agrees with its return. errors: of
// ReturnErrors.
std::map<uint16_t, cv::Point2d> MedianFlow(const cv::Mat1w& numbers, const cv::Mat& flow,
                                           const cv::Mat1f& errors) {
  std::map<uint16_t, cv::Point2d> medians;
  if (flow.empty()) return medians;
  const cv::Mat1f agreement = AgreementOf(errors, 1.0);
  std::map<uint16_t, std::pair<std::vector<double>, std::vector<double>>> steps;
  for (int y = 0; y < numbers.rows; y += kEverySecond) {
    for (int x = 0; x < numbers.cols; x += kEverySecond) {
      if (agreement(y, x) < kAgrees) continue;
      auto& [along_x, along_y] = steps[numbers(y, x)];
      const cv::Vec2f& step = flow.at<cv::Vec2f>(y, x);
      along_x.push_back(step[0]);
      along_y.push_back(step[1]);
    }
  }
  for (auto& [number, of] : steps) {
    if (of.first.size() >= kLeastSteps) medians[number] = {Median(of.first), Median(of.second)};
  }
  return medians;
}

nlohmann::json ToJson(const cv::Point2d& point) { return {point.x, point.y}; }

nlohmann::json ToJson(const std::optional<cv::Point2d>& point) {
  return point ? ToJson(*point) : nlohmann::json();
}

cv::Point2d PointFrom(const nlohmann::json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>()};
}

std::optional<cv::Point2d> OptionalPointFrom(const nlohmann::json& json) {
  if (json.is_null()) return std::nullopt;
  return PointFrom(json);
}

double Square(double value) { return value * value; }

}  // namespace

SightedFrame SightingsOf(const std::vector<TrackedFrame>& frames, size_t now,
                         const cv::Mat1w& numbers, bool causal) {
  std::map<uint16_t, Sighting> seen;
  for (int y = 0; y < numbers.rows; ++y) {
    for (int x = 0; x < numbers.cols; ++x) {
      if (numbers(y, x) == 0) continue;
      Sighting& sighting = seen[numbers(y, x)];
      ++sighting.pixels;
      sighting.centre += cv::Point2d(x, y);
      ++sighting.colours[ColourOf(frames[now].image(y, x))];
    }
  }
  const double time = frames[now].time_seconds;
  std::map<uint16_t, cv::Point2d> arriving, leaving;
  const double since = now > 0 ? time - frames[now - 1].time_seconds : 0.0;
  if (since > 0.0) {
    arriving = MedianFlow(numbers, frames[now].flow.backward, frames[now].errors.backward);
  }
  const bool sees_next = !causal && now + 1 < frames.size();
  const double until = sees_next ? frames[now + 1].time_seconds - time : 0.0;
  if (until > 0.0) {
    leaving = MedianFlow(numbers, frames[now + 1].flow.forward, frames[now + 1].errors.forward);
  }
  std::vector<Sighting> sightings;
  for (auto& [number, sighting] : seen) {
    sighting.number = number;
    sighting.time_seconds = time;
    sighting.centre /= sighting.pixels;
    for (double& share : sighting.colours) share /= sighting.pixels;
    if (arriving.count(number) > 0) {
      sighting.arriving = (arriving[0] - arriving[number]) / since;
    }
    if (leaving.count(number) > 0) {
      sighting.leaving = (leaving[number] - leaving[0]) / until;
    }
    sightings.push_back(sighting);
  }
  return {time, -arriving[0], std::move(sightings)};
}

void MoverLinks::Extend(const Sighting& sighting, cv::Point2d shift,
                        const std::optional<cv::Point2d>& speed, End& end) {
  const double seconds = std::abs(sighting.time_seconds - end.time_seconds);
  const double weight = end.pixels > 0.0 ? 1.0 - std::exp(-seconds / kEndSeconds) : 1.0;
  end.time_seconds = sighting.time_seconds;
  end.place = sighting.centre - shift;  // (ML1)
  end.pixels += weight * (sighting.pixels - end.pixels);
  if (speed) end.speed = end.speed ? *end.speed + weight * (*speed - *end.speed) : *speed;
  for (size_t i = 0; i < end.colours.size(); ++i) {
    end.colours[i] += weight * (sighting.colours[i] - end.colours[i]);
  }
}

// The open pieces, some of which go on, and then the new ones.
std::vector<MoverLinks::Piece> MoverLinks::PiecesOf(
    const std::vector<SightedFrame>& frames, std::vector<std::map<uint16_t, size_t>>* piece_of) {
  std::vector<Piece> pieces = open_;
  std::map<uint16_t, size_t> current;  // the piece of each number in the frame before
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].last.time_seconds == last_seconds_) current[pieces[i].number] = i;
  }
  std::vector<cv::Point2d> shifts;
  for (const SightedFrame& frame : frames) {
    shift_ += frame.shift;
    shifts.push_back(shift_);
    last_seconds_ = frame.time_seconds;
    std::map<uint16_t, size_t> next;
    for (const Sighting& sighting : frame.sightings) {
      const auto before = current.find(sighting.number);
      const size_t i = before != current.end() ? before->second : pieces.size();
      if (i == pieces.size()) pieces.emplace_back().number = sighting.number;
      Extend(sighting, shift_, sighting.arriving ? sighting.arriving : sighting.leaving,
             pieces[i].last);
      next[sighting.number] = i;
    }
    current = next;
    piece_of->push_back(std::move(next));
  }
  for (size_t t = frames.size(); t-- > 0;) {
    for (const Sighting& sighting : frames[t].sightings) {
      Extend(sighting, shifts[t], sighting.leaving ? sighting.leaving : sighting.arriving,
             pieces[(*piece_of)[t].at(sighting.number)].first);
    }
  }
  return pieces;
}

// Nothing where `after` does not begin within kLostSeconds after the other has ended.
std::optional<double> MoverLinks::CostOf(const Piece& before, const Piece& after) {
  const End& a = before.last;
  const End& b = after.first;
  const double seconds = b.time_seconds - a.time_seconds;
  if (seconds <= 0.0 || seconds > kLostSeconds) return std::nullopt;
  const cv::Point2d still(0.0, 0.0);
  const cv::Point2d speed_a = a.speed.value_or(b.speed.value_or(still));
  const cv::Point2d speed_b = b.speed.value_or(speed_a);
  const cv::Point2d speed = 0.5 * (speed_a + speed_b);
  const double reach =
      std::sqrt(std::max(a.pixels, b.pixels)) + kPlaceShare * cv::norm(speed) * seconds + 1.0;
  const double noise = kSpeedNoise + kSpeedShare * std::max(cv::norm(speed_a), cv::norm(speed_b));
  return Square(cv::norm(a.place + speed * seconds - b.place) / reach) +
         Square(cv::norm(speed_a - speed_b) / noise) +
         Square(ColourDistance(a.colours, b.colours) / kColours) +
         0.5 * Square(std::log(a.pixels / b.pixels));
}

void MoverLinks::JoinPieces(std::vector<Piece>& pieces) {
  std::vector<Join> joins;
  for (size_t b = open_.size(); b < pieces.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      const std::optional<double> cost = CostOf(pieces[a], pieces[b]);
      if (cost && *cost < kMostCost) joins.push_back({*cost, a, b});
    }
  }
  std::ranges::stable_sort(joins, {}, &Join::cost);
  std::vector<uint8_t> is_followed(pieces.size(), 0);
  std::vector<size_t> before(pieces.size(), pieces.size());
  for (const Join& join : joins) {
    if (is_followed[join.before] != 0 || before[join.after] < pieces.size()) continue;
    is_followed[join.before] = 1;
    before[join.after] = join.before;
  }
  // Pieces are in the order of their beginnings, so the one that a piece follows has its mover.
  for (size_t i = open_.size(); i < pieces.size(); ++i) {
    pieces[i].mover = before[i] < pieces.size() ? pieces[before[i]].mover : NewNumber(pieces);
  }
  open_.clear();
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (is_followed[i] == 0 && last_seconds_ - pieces[i].last.time_seconds <= kLostSeconds) {
      open_.push_back(pieces[i]);
    }
  }
}

uint16_t MoverLinks::NewNumber(const std::vector<Piece>& pieces) {
  const auto is_taken = [&](int number) {
    return std::ranges::find(pieces, number, &Piece::mover) != pieces.end();
  };
  return NextNumber(is_taken, next_number_);
}

std::vector<std::map<uint16_t, uint16_t>> MoverLinks::Add(const std::vector<SightedFrame>& frames) {
  std::vector<std::map<uint16_t, size_t>> piece_of;
  std::vector<Piece> pieces = PiecesOf(frames, &piece_of);
  JoinPieces(pieces);
  std::vector<std::map<uint16_t, uint16_t>> numbers;
  for (const auto& frame : piece_of) {
    auto& of_frame = numbers.emplace_back();
    for (const auto& [number, i] : frame) of_frame[number] = pieces[i].mover;
  }
  return numbers;
}

std::string MoverLinks::ToText() const {
  nlohmann::ordered_json json = {{"next_number", next_number_},
                                 {"last_seconds", last_seconds_},
                                 {"shift", ToJson(shift_)},
                                 {"pieces", nlohmann::ordered_json::array()}};
  for (const Piece& piece : open_) {
    json["pieces"].push_back({{"mover", piece.mover},
                              {"number", piece.number},
                              {"last_seconds", piece.last.time_seconds},
                              {"last_place", ToJson(piece.last.place)},
                              {"last_speed", ToJson(piece.last.speed)},
                              {"last_pixels", piece.last.pixels},
                              {"last_colours", piece.last.colours}});
  }
  return json.dump();
}

absl::StatusOr<MoverLinks> MoverLinks::Restore(absl::string_view text) {
  MoverLinks links;
  try {
    const auto json = nlohmann::json::parse(text);
    links.next_number_ = json.at("next_number").get<int>();
    links.last_seconds_ = json.at("last_seconds").get<double>();
    links.shift_ = PointFrom(json.at("shift"));
    for (const nlohmann::json& entry : json.at("pieces")) {
      Piece& piece = links.open_.emplace_back();
      piece.mover = entry.at("mover").get<uint16_t>();
      piece.number = entry.at("number").get<uint16_t>();
      piece.last.time_seconds = entry.at("last_seconds").get<double>();
      piece.last.place = PointFrom(entry.at("last_place"));
      piece.last.speed = OptionalPointFrom(entry.at("last_speed"));
      piece.last.pixels = entry.at("last_pixels").get<double>();
      piece.last.colours = entry.at("last_colours").get<ColourShares>();
    }
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(
        absl::StrFormat("the state of the movers' pieces cannot be read: %s", error.what()));
  }
  return links;
}

}  // namespace egosieve::vision
