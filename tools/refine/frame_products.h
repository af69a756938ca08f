// The products of refine for a frame, and their files.
//
//   masks        masks/NNNNNN.png        0 static, 255 moving
//   ids          ids/NNNNNN.png          16 bits: the mover's number, 0 where static
//   tracks       tracks.csv              one row for every mover of every frame:
//                frame,time_seconds,id,left,top,width,height,area,probability,sure
//   objects      full/NNNNNN.objects.json
//   probability  full/NNNNNN.prob.png    refined, value / 65535
//   deviation    full/NNNNNN.std.png     of the latent function, interpolated from the grid
//   class        full/NNNNNN.class.png   0 static, 128 unsure, 255 dynamic
//
// Boxes and areas are in pixels. probability is the mean over the mover's pixels. sure is 1 - 2
// mean sqrt(p (1 - p)): 1 if every p is 0 or 1, 0 if all are 1/2. It indicates errors of a map; the
// deviation indicates missing data.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/refine/full_maps.h"
#include "tools/run_folder/run_folder.h"
#include "vision/objects/map_objects.h"

namespace egosieve::tools {

struct ProductChoice {
  bool masks = true;
  bool ids = true;
  bool tracks = true;
  bool objects = true;
  bool probability = false;
  bool deviation = false;
  bool classes = false;

  // Words separated by commas. InvalidArgument for an unknown word, and if there is none.
  static absl::StatusOr<ProductChoice> FromText(absl::string_view text);
  std::string ToText() const;
};

struct FrameResult {
  int64_t index = 0;
  double time_seconds = 0.0;
  cv::Mat1f probability;  // refined
  cv::Mat1f deviation;    // empty if it is not wanted
  cv::Mat1b mask;
  cv::Mat1w ids;
};

// Makes the folders that the products need.
absl::Status CreateProductFolders(const RunFolder& folder, const ProductChoice& what);

// Writes the frame's files, each complete or not at all.
absl::Status WriteProducts(const RunFolder& folder, const ProductChoice& what,
                           const FrameResult& result, double deviation_full_scale,
                           const ClassThresholds& classes, const vision::ObjectThresholds& objects);

inline constexpr char kTracksHeader[] =
    "frame,time_seconds,id,left,top,width,height,area,probability,sure";

// The frame's rows, each with its line break, by increasing id.
std::string TrackRows(const FrameResult& result);

}  // namespace egosieve::tools
