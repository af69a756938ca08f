#include "tools/suite/sequences.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kDepth = 3;

// The truth in a folder; empty if there is none, and in a synthetic drive that is not complete.
std::string TruthIn(const fs::path& folder) {
  std::error_code error;
  if (fs::is_regular_file(folder / "scene.json", error) &&
      fs::is_directory(folder / "masks", error)) {
    return folder.string();
  }
  if (fs::exists(folder / "unfinished", error)) return "";
  for (const char* masks : {"masks", "labels"}) {
    if (fs::is_directory(folder / masks, error)) return (folder / masks).string();
  }
  const fs::path tracks = folder / "tracks.csv";
  return fs::is_regular_file(tracks, error) ? tracks.string() : "";
}

void Visit(const fs::path& suite, const fs::path& folder, int depth, SequenceList& list) {
  std::error_code error;
  if (fs::is_directory(folder / "frames", error)) {
    const fs::path below = folder.lexically_relative(suite);
    const std::string name =
        below == "." ? fs::absolute(folder).filename().string() : below.generic_string();
    const std::string truth = TruthIn(folder);
    if (truth.empty()) {
      list.without_truth.push_back(name);
    } else {
      list.sequences.push_back(
          {name, name.substr(0, name.find('/')), (folder / "frames").string(), truth});
    }
    return;
  }
  if (depth == 0) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) Visit(suite, entry.path(), depth - 1, list);
  }
}

}  // namespace

absl::StatusOr<SequenceList> FindSequences(const std::string& suite) {
  std::error_code error;
  fs::path root = fs::absolute(suite).lexically_normal();
  if (root.filename().empty()) root = root.parent_path();
  if (!fs::is_directory(root, error)) {
    return absl::NotFoundError(absl::StrCat("no folder ", suite, "; give the suite's folder"));
  }
  SequenceList list;
  Visit(root, root, kDepth, list);
  std::sort(list.sequences.begin(), list.sequences.end(),
            [](const Sequence& a, const Sequence& b) { return a.name < b.name; });
  std::sort(list.without_truth.begin(), list.without_truth.end());
  if (list.sequences.empty()) {
    return absl::NotFoundError(absl::StrCat(
        "no sequence in ", suite,
        ": none of its folders has frames/ and masks/, labels/ or "
        "tracks.csv beside it",
        list.without_truth.empty() ? ""
                                   : absl::StrCat(" (frames without truth: ",
                                                  absl::StrJoin(list.without_truth, ", "), ")")));
  }
  return list;
}

}  // namespace egosieve::tools
