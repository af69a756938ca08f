// What of videos is not read as it was meant to be seen, or recorded.
//
//   interlaced     two half pictures of different times lie in each frame: what moves has combed
//                  edges
//   HDR            brightness coded for very bright screens (PQ, HLG) is taken for ordinary
//                  brightness: pictures are read with little contrast
//
//   gaps           chapters of one drive between which time is missing, or that come in another
//                  order than their times: by the creation times of the files, where all have one
//                  and a gap is longer than kGapSeconds
//
// Ten or twelve bits a colour alone are read rightly, rounded to eight.
#ifndef EGOSIEVE_VISION_FRAME_VIDEO_REMARKS_H_
#define EGOSIEVE_VISION_FRAME_VIDEO_REMARKS_H_

#include <string>
#include <vector>

namespace egosieve::vision {

// Creation times are in whole seconds, and cameras need a moment to begin a file.
inline constexpr double kGapSeconds = 3.0;

// Of a video, or of the chapters of a drive in their order, which are alike but for their times. A
// sentence each, with what to do; none for what is no video. By what the files say of themselves.
std::vector<std::string> RemarksOnVideos(const std::vector<std::string>& paths);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_VIDEO_REMARKS_H_
