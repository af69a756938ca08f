// Frames in order, from a video file, a folder or a glob of images or of videos, a list of images
// (file_list.h) or a single image. Videos of one folder, glob or list are chapters of one drive.
//
// Conversions, so that every frame is 8-bit BGR (frame.h): 16-bit values v become round(v / 257),
// alpha is dropped, grey is replicated. EXIF and container rotations are applied.
//
// Image files come in natural order: runs of digits compare as numbers ("9.png" before "10.png"),
// everything else byte by byte; the index is the file's rank. Files without an image's extension
// and hidden files are passed over. Images of different sizes are delivered as they are.
//
// A video's time comes from its stream; frame counts in headers are hints only.
#ifndef EGOSIEVE_VISION_FRAME_FRAME_SOURCE_H_
#define EGOSIEVE_VISION_FRAME_FRAME_SOURCE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame.h"

namespace egosieve::vision {

// A frame that is there and cannot be read; the source goes on behind it.
struct DamagedFrame {
  int64_t index = 0;
  std::string reason;  // one sentence, naming the file
};

struct EndOfFrames {
  int64_t frame_count = 0;   // indices delivered or damaged: 0 .. frame_count - 1
  std::string warning;       // e.g. a video that ended before its header said; empty otherwise
  double end_seconds = 0.0;  // of a video: when a further frame would have come
};

using FrameRead = std::variant<Frame, DamagedFrame, EndOfFrames>;

struct FrameSourceOptions {
  // Frames a second for the times of image files; a video has its own clock.
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
  // EndOfFrames. An error means that the source as a whole cannot go on.
  virtual absl::StatusOr<FrameRead> Next() = 0;

  // Makes `index` the next frame. Videos decode from a key frame near it where their packets tell
  // the frames' numbers, else from the beginning, and drop what comes before: frame k is the same
  // picture however it was reached. Beyond the end: Next()
  // returns EndOfFrames. InvalidArgument for a negative index.
  virtual absl::Status SeekTo(int64_t index) = 0;

  virtual int64_t next_index() const = 0;

  // A hint for progress bars: -1 where unknown, and not to be trusted for videos.
  virtual int64_t expected_frame_count() const = 0;

  // The files that it reads; none where pictures are made.
  virtual std::vector<std::string> files() const { return {}; }

  // The name of a picture: its file's, relative to the folder that was opened or that all files of
  // a glob share; NNNNNN.png where it has no file of its own. Other programs' files go by it.
  virtual std::string image_name(int64_t index) const;

  // Identifies the input for logs and for refusing to resume with another one.
  virtual std::string description() const = 0;
};

// Opens and looks at the input: errors say in one line what is wrong and what to do.
//   NotFound         no such file, folder or match of the glob
//   InvalidArgument  not a video or image (a text file called .mp4), a folder without either, a
//                    video that opens but delivers no frame, an image file that is the only one
//                    and broken, a list that does not hold what it must
absl::StatusOr<std::unique_ptr<FrameSource>> OpenFrameSource(
    const std::string& input, const FrameSourceOptions& options = {});

// True where `a` comes before `b` in natural order; a strict weak ordering.
bool NaturalLess(const std::string& a, const std::string& b);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_FRAME_SOURCE_H_
