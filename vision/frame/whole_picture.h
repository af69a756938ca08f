// Whether a picture file is whole, before OpenCV decodes it: OpenCV fills what is missing with grey
// or black, and libraries tell of it on stderr alone.
//
//   JPEG   libjpeg decodes the file at an eighth of its size. It is damaged if the decoder runs out
//          of data before the last line, finds codes that no encoder writes, or has many left. What
//          lies behind the picture (the video of a motion photo, padding, trailers) does not matter
//   PNG    the chain of chunks, each with its length, reaches IEND
//
// Other formats are left to their decoders.
#ifndef EGOSIEVE_VISION_FRAME_WHOLE_PICTURE_H_
#define EGOSIEVE_VISION_FRAME_WHOLE_PICTURE_H_

#include <string>

#include "absl/status/status.h"

namespace egosieve::vision {

// DataLoss, with the decoder's words, if it is damaged or cut short. A JPEG that lacks its end
// marker alone gets one.
absl::Status CheckWhole(std::string& bytes);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_WHOLE_PICTURE_H_
