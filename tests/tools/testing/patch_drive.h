// A drive that is easy by construction: a textured plane slides past the camera, and a textured
// square slides the other way over it and starts again at the left when it has crossed. A
// homography explains the plane exactly.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace egosieve::tools {

struct PatchDriveOptions {
  int width_pixels = 192;
  int height_pixels = 128;
  int frames = 8;
};

// Small and quick: the texture is dense.
inline PatchDriveOptions SmallPatchDrive(int frames) { return {160, 96, frames}; }

cv::Mat3b PatchFrame(const PatchDriveOptions& options, int index);
cv::Mat1b PatchMask(const PatchDriveOptions& options, int index);

// root/frames/NNNNNN.png and root/masks/NNNNNN.png; replaces what lies at `root`.
void WritePatchDrive(const std::string& root, const PatchDriveOptions& options = {});

// The first `frames` as a video of JPEGs, ten a second.
void WritePatchVideo(const std::string& path, const PatchDriveOptions& options, int frames);

}  // namespace egosieve::tools
