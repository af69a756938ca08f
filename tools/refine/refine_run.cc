#include "tools/refine/refine_run.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/segmented_pictures.h"
#include "vision/masks/mask_image.h"

namespace egosieve::tools {
namespace {

constexpr size_t kChunkFrames = 32;
// Frames read on each side of a chunk, for any frame rate; bounds memory.
constexpr size_t kMostReachFrames = 24;
constexpr char kTracks[] = "tracks.csv";

// Frames before the first learnt frame have the map of the prior. Methods without a model learn
// only from the frame itself.
std::vector<bool> OwnMaps(const std::vector<FrameLine>& lines) {
  std::vector<bool> own;
  for (const FrameLine& line : lines) {
    own.push_back(line.model_size > 0 || line.outcome == FrameLine::Outcome::kLearnt);
  }
  return own;
}

std::vector<FrameLine> LinesWithPictures(const std::vector<FrameLine>& lines) {
  std::vector<FrameLine> chosen;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(chosen), [](const FrameLine& line) {
    return line.has_map() && line.outcome != FrameLine::Outcome::kFailed;
  });
  return chosen;
}

size_t ChunkEnd(const std::vector<FrameLine>& lines, size_t begin) {
  size_t end = begin + 1;
  while (end < lines.size() && end < begin + kChunkFrames &&
         lines[end].width_pixels == lines[begin].width_pixels &&
         lines[end].height_pixels == lines[begin].height_pixels) {
    ++end;
  }
  return end;
}

// Differs for refinements that differ. lines: those with pictures.
std::string SignatureOf(const RunDescription& description, const std::vector<FrameLine>& lines,
                        const RefineOptions& options) {
  return absl::StrFormat(
      "movers=2 what=%s mask=%g,%g objects=%g,%g classes=%g,%g causal=%d frames=%d-%d maps=%d "
      "started=%s",
      options.what.ToText(), options.mask.low, options.mask.high, options.objects.low,
      options.objects.high, options.classes.static_below, options.classes.dynamic_above,
      options.window.link.causal ? 1 : 0, lines.empty() ? -1 : lines.front().index,
      lines.empty() ? -1 : lines.back().index, lines.size(), description.started_utc);
}

nlohmann::json ReadState(const RunFolder& folder) {
  return nlohmann::json::parse(ReadFile(folder.File(kRefineState)).value_or(""), nullptr, false);
}

}  // namespace

absl::Status RefineOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(classes.Validate());
  EGOSIEVE_RETURN_IF_ERROR(objects.Validate());
  if (mask.Validate().ok()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "--mask_low=%g and --mask_high=%g; both must lie in [0, 1], the first not above the second",
      mask.low, mask.high));
}

bool IsRefined(const RunFolder& folder) {
  const nlohmann::json json = ReadState(folder);
  return json.is_object() && json.value("frames_done", -1) == json.value("frames", -2);
}

absl::StatusOr<bool> IsResumable(const RunFolder& folder, const std::vector<FrameLine>& lines,
                                 const RefineOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  const nlohmann::json json = ReadState(folder);
  return json.is_object() &&
         json.value("options", "") == SignatureOf(description, LinesWithPictures(lines), options);
}

absl::StatusOr<std::unique_ptr<RefineRun>> RefineRun::Open(const RunFolder& folder,
                                                           const std::vector<FrameLine>& lines,
                                                           const RefineOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  std::unique_ptr<RefineRun> run(new RefineRun(folder, options));
  EGOSIEVE_ASSIGN_OR_RETURN(run->description_, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(run->ignored_, folder.ReadIgnoredAreas());
  EGOSIEVE_ASSIGN_OR_RETURN(run->source_, OpenPictures(run->description_, options.input));
  run->lines_ = LinesWithPictures(lines);
  run->has_map_of_its_own_ = OwnMaps(run->lines_);
  EGOSIEVE_RETURN_IF_ERROR(run->Begin());
  return run;
}

absl::Status RefineRun::Begin() {
  RemoveAbandonedFiles(folder_.path());
  frames_ = static_cast<int64_t>(lines_.size());
  EGOSIEVE_RETURN_IF_ERROR(CreateProductFolders(folder_, options_.what));
  if (!options_.resume) return StartTracks();
  EGOSIEVE_ASSIGN_OR_RETURN(const bool goes_on, IsResumable(folder_, lines_, options_));
  return goes_on ? RestoreState() : StartTracks();
}

absl::Status RefineRun::StartTracks() {
  std::error_code error;
  std::filesystem::remove(folder_.File(kRefineState), error);
  if (!options_.what.tracks) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(folder_.File(kTracks), absl::StrCat(kTracksHeader, "\n")));
  EGOSIEVE_ASSIGN_OR_RETURN(LineLog log, LineLog::Open(folder_.File(kTracks)));
  tracks_ = std::make_unique<LineLog>(std::move(log));
  return absl::OkStatus();
}

absl::Status RefineRun::RestoreState() {
  const nlohmann::json json = ReadState(folder_);
  done_before_ = json.value("frames_done", int64_t{0});
  track_rows_ = json.value("track_rows", int64_t{0});
  if (done_before_ < 0 || done_before_ > frames()) {
    return absl::DataLossError(
        absl::StrCat(folder_.File(kRefineState), " is damaged; leave --resume out to begin anew"));
  }
  if (options_.what.tracks) {
    EGOSIEVE_ASSIGN_OR_RETURN(LineLog log,
                              LineLog::OpenTruncated(folder_.File(kTracks), track_rows_ + 1));
    tracks_ = std::make_unique<LineLog>(std::move(log));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(tracker_, vision::MoverTracker::Restore(json.value("tracker", "")));
  EGOSIEVE_ASSIGN_OR_RETURN(links_, vision::MoverLinks::Restore(json.value("links", "")));
  return absl::OkStatus();
}

absl::Status RefineRun::SaveState(size_t done) {
  const nlohmann::ordered_json json = {{"options", SignatureOf(description_, lines_, options_)},
                                       {"frames_done", done},
                                       {"frames", lines_.size()},
                                       {"track_rows", track_rows_},
                                       {"tracker", tracker_.ToText()},
                                       {"links", links_.ToText()}};
  return WriteFileAtomically(folder_.File(kRefineState), json.dump(1) + "\n");
}

absl::StatusOr<vision::WindowFrame> RefineRun::ReadFrame(size_t i) {
  const FrameLine& line = lines_[i];
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::Frame frame, ReadPicture(line, *source_));
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps, folder_.ReadGridMaps(line, description_, false));
  EGOSIEVE_ASSIGN_OR_RETURN(cv::Mat1f probability,
                            InterpolateMap(GridOf(line, description_), maps.probability));
  probability.setTo(0.0F, ignored_.In(line));
  return vision::MakeWindowFrame(line.time_seconds, frame.image, probability,
                                 has_map_of_its_own_[i]);
}

absl::Status RefineRun::MoveWindowAround(size_t begin, size_t end) {
  const double reach = options_.window.ReachSeconds();
  size_t from = begin, to = end;
  const double first_seconds = lines_[begin].time_seconds;
  const double last_seconds = lines_[end - 1].time_seconds;
  while (from > 0 && begin - from < kMostReachFrames &&
         first_seconds - lines_[from - 1].time_seconds <= reach) {
    --from;
  }
  while (!options_.window.link.causal && to < lines_.size() && to - end < kMostReachFrames &&
         lines_[to].time_seconds - last_seconds <= reach) {
    ++to;
  }
  if (from > window_begin_ + window_.size()) window_.clear();
  if (window_.empty()) window_begin_ = from;
  window_.erase(window_.begin(), window_.begin() + static_cast<int64_t>(from - window_begin_));
  window_begin_ = from;
  while (window_begin_ + window_.size() < to) {
    EGOSIEVE_ASSIGN_OR_RETURN(vision::WindowFrame frame, ReadFrame(window_begin_ + window_.size()));
    window_.push_back(std::move(frame));
  }
  return vision::LinkFrames(window_);
}

std::vector<cv::Mat1f> RefineRun::RefinedMapsOf(size_t begin, size_t end) const {
  std::vector<cv::Mat1f> maps =
      vision::RefineWindow(window_, static_cast<int>(begin - window_begin_),
                           static_cast<int>(end - begin), options_.window);
  for (cv::Mat1f& map : maps) map = MapValues(MapPixels(map, 1.0), 1.0);
  return maps;
}

std::vector<cv::Mat1w> RefineRun::NumberMovers(size_t begin, size_t end,
                                               const std::vector<FrameResult>& results) {
  const bool causal = options_.window.link.causal;
  std::vector<vision::TrackedFrame> tracked;
  std::vector<cv::Mat1w> numbers;
  std::vector<uint16_t> seen_once;
  vision::MoverTracker next_chunk;
  for (size_t i = 0; i < results.size(); ++i) {
    const size_t now = begin - window_begin_ + i;
    const size_t seen = causal ? now + 1 : window_.size();
    while (tracked.size() < seen) tracked.push_back(window_[tracked.size()]);
    if (begin + i == end) next_chunk = tracker_;
    vision::MoverTracker& tracker = begin + i < end ? tracker_ : next_chunk;
    numbers.push_back(
        tracker.Add(tracked, now, vision::SmallMask(results[i].mask, window_[now].image.size())));
    if (i > 0 && !causal &&
        results[i].time_seconds - results[i - 1].time_seconds <= vision::kGlimpseSeconds) {
      vision::DropGlimpses(seen_once, numbers[i], numbers[i - 1]);
    }
    seen_once = tracker.SeenOnce();
  }
  numbers.resize(end - begin);
  LinkMovers(begin, tracked, numbers);
  return numbers;
}

void RefineRun::LinkMovers(size_t begin, const std::vector<vision::TrackedFrame>& tracked,
                           std::vector<cv::Mat1w>& numbers) {
  const bool causal = options_.window.link.causal;
  std::vector<vision::SightedFrame> sightings(numbers.size());
  kernels::ParallelFor(static_cast<int64_t>(numbers.size()), [&](int64_t i) {
    sightings[i] = vision::SightingsOf(tracked, begin - window_begin_ + i, numbers[i], causal);
  });
  const size_t at_once = causal ? 1 : numbers.size();
  for (size_t i = 0; i < numbers.size(); i += at_once) {
    const auto movers = links_.Add({sightings.begin() + static_cast<int64_t>(i),
                                    sightings.begin() + static_cast<int64_t>(i + at_once)});
    for (size_t k = 0; k < at_once; ++k) {
      for (uint16_t& number : numbers[i + k]) {
        if (number != 0) number = movers[k].at(number);
      }
    }
  }
}

absl::Status RefineRun::RunChunk(size_t begin, size_t end) {
  const bool sees_next = !options_.window.link.causal && end < lines_.size() &&
                         lines_[end].width_pixels == lines_[begin].width_pixels &&
                         lines_[end].height_pixels == lines_[begin].height_pixels;
  const size_t seen = sees_next ? end + 1 : end;
  EGOSIEVE_RETURN_IF_ERROR(MoveWindowAround(begin, seen));
  const std::vector<cv::Mat1f> refined = RefinedMapsOf(begin, seen);
  std::vector<FrameResult> results(refined.size());
  kernels::ParallelFor(static_cast<int64_t>(results.size()), [&](int64_t i) {
    const FrameLine& line = lines_[begin + i];
    results[i].index = line.index;
    results[i].time_seconds = line.time_seconds;
    results[i].probability = refined[i];
    results[i].mask = vision::MaskOf(refined[i], options_.mask, ignored_.In(line));
  });
  const std::vector<cv::Mat1w> numbers = NumberMovers(begin, end, results);
  results.resize(end - begin);
  for (size_t i = 0; i < results.size(); ++i) {
    results[i].ids = vision::NumberPixels(numbers[i], results[i].mask);
    window_[begin - window_begin_ + i].full.release();
  }
  return WriteChunk(begin, results);
}

absl::Status RefineRun::WriteChunk(size_t begin, std::vector<FrameResult>& results) {
  std::vector<absl::Status> statuses(results.size(), absl::OkStatus());
  std::vector<std::string> rows(results.size());
  const auto write = [&](int64_t i) {
    const FrameLine& line = lines_[begin + i];
    if (options_.what.deviation) {
      EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps,
                                folder_.ReadGridMaps(line, description_, true));
      EGOSIEVE_ASSIGN_OR_RETURN(results[i].deviation,
                                InterpolateMap(GridOf(line, description_), maps.deviation));
    }
    if (options_.what.tracks) rows[i] = TrackRows(results[i]);
    return WriteProducts(folder_, options_.what, results[i], description_.deviation_full_scale,
                         options_.classes, options_.objects);
  };
  kernels::ParallelFor(static_cast<int64_t>(results.size()),
                       [&](int64_t i) { statuses[i] = write(i); });
  for (const absl::Status& status : statuses) EGOSIEVE_RETURN_IF_ERROR(status);
  std::string all = absl::StrJoin(rows, "");
  if (!all.empty()) {
    track_rows_ += std::count(all.begin(), all.end(), '\n');
    all.pop_back();
    EGOSIEVE_RETURN_IF_ERROR(tracks_->Append(all));
  }
  return SaveState(begin + results.size());
}

absl::Status RefineRun::Run(const std::function<bool()>& after_frame) {
  for (size_t begin = 0, end = 0; begin < lines_.size(); begin = end) {
    end = ChunkEnd(lines_, begin);
    if (static_cast<int64_t>(begin) < done_before_) continue;
    EGOSIEVE_RETURN_IF_ERROR(RunChunk(begin, end));
    bool goes_on = true;
    for (size_t i = begin; i < end; ++i) goes_on = after_frame() && goes_on;
    if (!goes_on) return absl::CancelledError(absl::StrCat("interrupted after ", end, " frames"));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
