#include "vision/frame/quiet_libraries.h"

#include <cstdlib>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

extern "C" {
#include <libavutil/log.h>
}

namespace egosieve::vision {
void QuietLibraries() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (std::getenv("OPENCV_LOG_LEVEL") == nullptr) {
      cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
      cv::redirectError([](int, const char*, const char*, const char*, int, void*) {
        return 0;  // exceptions are still thrown
      });
    }
  });
  // Not once: OpenCV sets another level where it opens a video.
  if (std::getenv("OPENCV_FFMPEG_LOGLEVEL") == nullptr) av_log_set_level(AV_LOG_QUIET);
}

}  // namespace egosieve::vision
