// Truth as boxes around things: lines of `frame,id,type,x1,y1,x2,y2,moving` under that header,
// fields in any order. Optional fields: truncated, occluded, depth, range.
//
//   frame      index in the input, from 0
//   type       Car, Van, Truck, Tram, Bus: vehicle; Pedestrian, Person, Person_sitting: person;
//              Cyclist: cyclist; any other: an area of unknown content
//   x1 .. y2   pixels from 0: left, top, right and bottom edge
//   moving     1, 0, or empty if unknown
//   truncated  by the image's border: 0 not, 1 partly, 2 largely
//   occluded   0 not, 1 partly, 2 largely, 3 unknown
//   depth      metres along the optical axis
//   range      near (nearer than 50 m) or far, if the depth is only estimated by eye
#ifndef EGOSIEVE_TOOLS_EVALUATION_BOX_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATION_BOX_TRUTH_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

enum class BoxClass { kVehicle, kPerson, kCyclist, kUntold };

const char* BoxClassName(BoxClass box_class);

struct LabelledBox {
  int64_t id = 0;
  BoxClass box_class = BoxClass::kUntold;
  double left = 0.0;  // pixels, as the other three
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;
  int truncated = 0;
  int occluded = 0;
  std::optional<bool> moving;
  std::optional<double> depth_metres;
  std::string range;  // near, far or empty

  // "10-20 m" by depth, "near" or "far" by range, else "unknown".
  const char* Distance() const;
};

using BoxTruth = std::map<int64_t, std::vector<LabelledBox>>;  // by frame

// The distances in the order in which they are printed.
inline constexpr const char* kBoxDistances[] = {"0-10 m", "10-20 m", "20-40 m", "40+ m",
                                                "near",   "far",     "unknown"};

// DataLoss, naming the line and its error.
absl::StatusOr<BoxTruth> ParseBoxTruth(absl::string_view csv);
// The same from a file, named in errors; NotFound.
absl::StatusOr<BoxTruth> ReadBoxTruth(const std::string& path);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_BOX_TRUTH_H_
