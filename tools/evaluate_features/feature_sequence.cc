#include "tools/evaluate_features/feature_sequence.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluate/truth_masks.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// "" where the folder has none.
std::string TruthIn(const fs::path& folder) {
  std::error_code error;
  for (const char* name : {"masks", "labels"}) {
    if (fs::is_directory(folder / name, error)) return (folder / name).string();
  }
  const fs::path tracks = folder / "tracks.csv";
  return fs::is_regular_file(tracks, error) ? tracks.string() : "";
}

void AddSequence(const fs::path& folder, const fs::path& root,
                 std::vector<FeatureSequence>& sequences) {
  std::error_code error;
  const fs::path frames = folder / "frames";
  const std::string truth = TruthIn(folder);
  if (!fs::is_directory(frames, error) || truth.empty()) return;
  std::string name = folder.lexically_relative(root).string();
  if (name == "." || name.empty()) name = fs::absolute(folder).lexically_normal().filename();
  if (name.empty()) name = folder.string();
  sequences.push_back({name, frames.string(), truth});
}

// The number at the end of a frame's name; 0 where there is none.
int64_t NumberOf(const std::string& name) {
  const size_t last = name.find_last_not_of("0123456789");
  int64_t number = 0;
  return absl::SimpleAtoi(last == std::string::npos ? name : name.substr(last + 1), &number)
             ? number
             : 0;
}

}  // namespace

absl::StatusOr<std::vector<FeatureSequence>> FindFeatureSequences(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return absl::NotFoundError(absl::StrCat(folder, ": there is no such folder"));
  }
  std::vector<FeatureSequence> sequences;
  AddSequence(folder, folder, sequences);
  for (fs::recursive_directory_iterator at(folder, error), end; at != end; at.increment(error)) {
    if (error) break;
    if (at->is_directory(error)) AddSequence(at->path(), folder, sequences);
  }
  if (sequences.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder, ": no folder in it has frames/ and masks/, labels/ or tracks.csv"));
  }
  std::sort(sequences.begin(), sequences.end(),
            [](const FeatureSequence& a, const FeatureSequence& b) {
              return vision::NaturalLess(a.name, b.name);
            });
  return sequences;
}

absl::StatusOr<FeatureTruth> ReadFeatureTruth(const FeatureSequence& sequence) {
  FeatureTruth truth;
  const std::vector<std::string> names = FrameNames(sequence.frames);
  if (absl::EndsWith(sequence.truth, ".csv")) {
    const int64_t first_number = names.empty() ? 0 : NumberOf(names.front());
    EGOSIEVE_ASSIGN_OR_RETURN(truth.tracks,
                              vision::ReadLabelledTracks(sequence.truth, first_number));
    if (truth.tracks.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(sequence.truth, ": there is no track in it"));
    }
    return truth;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const TruthMasks masks,
                            ListTruthMasks(sequence.truth, names, MatchMasks::kAuto));
  truth.masks = masks.paths;
  return truth;
}

}  // namespace egosieve::tools
