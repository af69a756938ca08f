#include "tests/tools/testing/run_comparison.h"

#include <filesystem>
#include <map>
#include <variant>

#include "absl/strings/str_cat.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

std::string LinesWithoutTimes(const RunFolder& folder) {
  const std::vector<FrameLine> lines = *folder.ReadLines();
  std::string text;
  for (FrameLine line : lines) {
    line.milliseconds.clear();
    text += ToText(line) + "\n";
  }
  return text;
}

std::string DescriptionWithoutTimes(const RunFolder& folder) {
  RunDescription description = *folder.ReadDescription();
  description.seconds = 0.0;
  description.started_utc.clear();
  description.finished_utc.clear();
  return ToText(description);
}

// Two runs of the same input begin at two times, which refine notes.
std::string WithoutStart(std::string text) {
  const size_t begin = text.find(" started=");
  if (begin != std::string::npos) text.erase(begin, text.find('"', begin) - begin);
  return text;
}

// An encoder's bytes depend on where its memory lies: of a video the pictures are counted.
std::string PicturesOf(const std::string& path) {
  const auto video = vision::OpenFrameSource(path);
  if (!video.ok()) return std::string(video.status().message());
  int whole = 0;
  while (true) {
    const auto read = (*video)->Next();
    if (!read.ok()) return std::string(read.status().message());
    if (const auto* end = std::get_if<vision::EndOfFrames>(&*read)) {
      return absl::StrCat(whole, " of ", end->frame_count, " pictures ", end->warning);
    }
    whole += std::holds_alternative<vision::Frame>(*read);
  }
}

std::map<std::string, std::string> Contents(const std::string& path) {
  const RunFolder folder = *RunFolder::Open(path);
  std::map<std::string, std::string> contents;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), path).string();
    if (name.rfind("log/", 0) == 0) continue;  // named by time and process; ReadLines has its lines
    if (FolderLock::IsLockFile(name)) continue;  // of who has worked on the run
    contents[name] = name == "frames.jsonl"       ? LinesWithoutTimes(folder)
                     : name == "run.json"         ? DescriptionWithoutTimes(folder)
                     : name == "reconstruct.json" ? WithoutStart(*ReadFile(entry.path().string()))
                     : name == "overlay.mp4"      ? PicturesOf(entry.path().string())
                                                  : *ReadFile(entry.path().string());
  }
  return contents;
}

}  // namespace

std::string CompareRuns(const std::string& a, const std::string& b) {
  const auto in_a = Contents(a);
  auto in_b = Contents(b);
  for (const auto& [name, bytes] : in_a) {
    const auto other = in_b.extract(name);
    if (other.empty()) return absl::StrCat(name, " is missing in ", b);
    if (other.mapped() != bytes) return absl::StrCat(name, " differs");
  }
  return in_b.empty() ? "" : absl::StrCat(in_b.begin()->first, " is missing in ", a);
}

}  // namespace egosieve::tools
