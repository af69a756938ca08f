#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_format.h"
#include "vision/masks/mover_tracker.h"

namespace egosieve::vision {

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
