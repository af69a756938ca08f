#include "tools/run_folder/baselines.h"

#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr double kLeastFollowed = 0.7;
// A few scene cuts do not make a run sparse.
constexpr double kSparseShare = 0.1;

// The last run of digits in a picture's name, without the extension.
std::optional<int64_t> NumberOf(const std::string& name) {
  size_t end = name.rfind('.');
  if (end == std::string::npos) end = name.size();
  while (end > 0 && !absl::ascii_isdigit(name[end - 1])) --end;
  size_t begin = end;
  while (begin > 0 && absl::ascii_isdigit(name[begin - 1])) --begin;
  int64_t number = 0;
  if (!absl::SimpleAtoi(name.substr(begin, end - begin), &number)) return std::nullopt;
  return number;
}

}  // namespace

Baselines::Baselines(const RunDescription& description) {
  const auto front_end = description.flags.find("front_end");
  by_flow_ = front_end != description.flags.end() && front_end->second == "default";
}

void Baselines::AddName(const FrameLine& line) {
  const std::optional<int64_t> number = NumberOf(line.image);
  if (!number) {
    step_ = 0;
    return;
  }
  const int64_t frames = line.index - last_index_, numbers = *number - last_number_;
  if (names_ == 0) {
    first_name_ = line.image;
  } else {
    const int64_t step = frames > 0 && numbers % frames == 0 ? numbers / frames : 0;
    if (names_ == 1) {
      step_ = step;
      second_name_ = line.image;
    }
    if (step != step_) step_ = 0;
  }
  last_number_ = *number;
  last_index_ = line.index;
  ++names_;
}

bool Baselines::IsThinned() const {
  return names_ >= kLeastNames && step_ >= 2 && step_ <= kLargestStep;
}

void Baselines::Add(const FrameLine& line) {
  AddName(line);
  if (!by_flow_ || line.features == 0) return;
  ++pairs_;
  far_apart_ +=
      static_cast<double>(line.matches) < kLeastFollowed * static_cast<double>(line.features);
}

std::string Baselines::Describe() const {
  if (far_apart_ == 0 ||
      static_cast<double>(far_apart_) < kSparseShare * static_cast<double>(pairs_)) {
    if (!IsThinned()) return "";
    return absl::StrCat("the pictures' numbers go up by ", step_, " (", first_name_, ", ",
                        second_name_,
                        "): of pictures chosen from a video more movers are missed than of all of "
                        "them; where you have the video: egosieve masks PICTURES "
                        "--from_video=FILE");
  }
  return absl::StrCat(far_apart_, " of ", pairs_,
                      " pairs of pictures lie too far apart to be followed well, and movers are "
                      "missed there; segment all pictures, or the video that they were taken "
                      "from: egosieve masks PICTURES --from_video=FILE");
}

}  // namespace egosieve::tools
