// Writes a synthetic drive (vision/synthetic/street.h) and its truth to a folder.
//
//   frames/NNNNNN.png   pictures; with `video`, video.mp4 (lossy) instead
//   masks/NNNNNN.png    255 on movers, 128 where the camera's own vehicle hides the scene, else 0
//   ids/NNNNNN.png      16 bits: the object that the pixel shows, 0 for scenery
//   own_vehicle.png     255 on the camera's own vehicle; only if it is visible
//   poses.txt           the camera's poses, one line per frame: the 12 numbers of world_from_camera
//   camera.json         focal_pixels, radial (camera.h, CA1), width, height, frames_per_second
//   scene.json          scenario, seed, intrinsics; per frame: time, pose, visible objects
//
// NNNNNN counts frames from 0. Each file is complete or absent, and scene.json is written last: a
// folder without it was interrupted, and has the empty file `unfinished` instead. Fields of
// scene.json that are not self-explanatory:
//
//   intrinsics          focal_pixels, centre_x, centre_y (pixel centres at integers), radial
//   world_from_camera   3 rows of 4: X_world = R X_camera + centre; camera x right, y down,
//                       z forward; world x east, y north, z up; metres
//   objects             id (as in ids/), class, moving, relation (standing, ahead, oncoming,
//                       crossing: its motion as the camera's driver sees it), heading_degrees
//                       (world, from the x axis, counter-clockwise), velocity (world),
//                       relative_velocity (camera axes, less the camera's own), distance_metres,
//                       area_pixels, box (x, y, width, height)
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "vision/synthetic/street.h"

namespace egosieve::tools {

// Compression of the pictures before they are written: none; JPEG of quality 60 for each; one H.264
// video of all, as OpenCV's FFmpeg writes it. The decoded pictures have the codec's artefacts.
// H.264's bytes depend on the library's version and the number of cores.
enum class Compression { kNone, kJpeg, kH264 };

struct SynthesizeOptions {
  std::string scenario = "street";
  uint64_t seed = 1;
  std::string output_folder;
  bool video = false;  // video.mp4 instead of frames/
  Compression compression = Compression::kNone;
  bool overwrite = false;  // replace a former drive in the folder
  vision::ScenarioOptions rendering;
};

// Called after each frame; returning false ends the work with Cancelled.
using AfterFrame = std::function<bool(int done, int total)>;

// InvalidArgument for options out of range; NotFound, listing the scenarios, for an unknown one.
// AlreadyExists if the folder is not empty, unless `overwrite` is set and it holds a drive: then
// that drive's files are removed, and only those. Unavailable, ResourceExhausted or
// PermissionDenied if a file cannot be written.
absl::Status Synthesize(const SynthesizeOptions& options, const AfterFrame& after_frame = nullptr);

}  // namespace egosieve::tools
