// Frames in order, from a video file, a folder or a glob of images or of videos, a list of images
// (file_list.h) or a single image. Videos of one folder, glob or list are chapters of one drive.
//
// Conversions, so that every frame is 8-bit BGR (frame.h): 16-bit values v become round(v / 257),
// or are stretched if the drive uses a part of their range (image_decoding.h); alpha is dropped,
// grey is replicated. EXIF and container rotations are applied.
//
// Image files are read in natural order: runs of digits compare as numbers ("9.png" before
// "10.png"), all else byte by byte. The index is the file's rank. Which files are read is told in
// input_files.h. Images of different sizes are delivered unchanged.
//
// The times of a video come from its stream. Frame counts in headers are only hints.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame.h"

namespace egosieve::vision {

// A frame that exists but cannot be read. The source continues after it.
struct DamagedFrame {
  int64_t index = 0;
  std::string reason;  // one sentence, naming the file
};

struct EndOfFrames {
  int64_t frame_count = 0;   // indices delivered or damaged: 0 .. frame_count - 1
  std::string warning;       // e.g. a video shorter than its header states; else empty
  double end_seconds = 0.0;  // of a video: the time of a further frame
};

using FrameRead = std::variant<Frame, DamagedFrame, EndOfFrames>;

struct FrameSourceOptions {
  // Frames per second, for the times of image files; a video has its own clock.
  double nominal_rate_hz = 10.0;
  // A file with the times of the pictures of a folder or a glob (file_list.h); empty: none.
  std::string times;

  absl::Status Validate() const;
};

// Not thread-safe; one reader.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  // The frame at next_index(), which then grows by one. After the end it keeps returning
  // EndOfFrames. An error means that the whole source cannot continue.
  virtual absl::StatusOr<FrameRead> Next() = 0;

  // Makes `index` the next frame. Videos decode from a key frame near it if their packets determine
  // the numbers of the frames, else from the beginning, and drop the frames before it. So frame k
  // is the same picture however it was reached. Beyond the end, Next() returns EndOfFrames.
  // InvalidArgument for a negative index.
  virtual absl::Status SeekTo(int64_t index) = 0;

  virtual int64_t next_index() const = 0;

  // A hint for progress bars: -1 if unknown; unreliable for videos.
  virtual int64_t expected_frame_count() const = 0;

  // The files that are read; none where pictures are generated.
  virtual std::vector<std::string> files() const { return {}; }

  // The name of a picture: that of its file, relative to the folder that was opened or to the
  // folder that all files of a glob share; NNNNNN.png if it has no file of its own. Files of other
  // programs refer to it.
  virtual std::string image_name(int64_t index) const;

  // What a user should know of how the input is read, one sentence each: files that are left out,
  // values that are stretched.
  virtual std::vector<std::string> remarks() const { return {}; }

  // Identifies the input, for logs and to refuse resuming with another input.
  virtual std::string description() const = 0;
};

// Opens and checks the input. An error states in one line the problem and its remedy.
//   NotFound         no such file, folder or match of the glob
//   InvalidArgument  not a video or image (a text file called .mp4), a folder without either or
//                    with those of several cameras, a video that opens but delivers no frame, a
//                    broken image file that is the only one, an invalid list
absl::StatusOr<std::unique_ptr<FrameSource>> OpenFrameSource(
    const std::string& input, const FrameSourceOptions& options = {});

// True where `a` comes before `b` in natural order; a strict weak ordering.
bool NaturalLess(const std::string& a, const std::string& b);

}  // namespace egosieve::vision
