#include "tools/run_folder/shot_list.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr char kShotsFile[] = "/shots.json", kShotsField[] = "shots", kShotsEnd[] = "end";

}  // namespace

absl::StatusOr<ShotList> ReadShots(const std::string& path) {
  const std::string file = path + kShotsFile;
  ShotList shots;
  const absl::StatusOr<std::string> text = kernels::ReadFile(file);
  if (absl::IsNotFound(text.status())) return shots;
  EGOSIEVE_RETURN_IF_ERROR(text.status());
  try {
    const nlohmann::json json = nlohmann::json::parse(*text);
    json.at(kShotsField).get_to(shots.first_frames);
    json.at(kShotsEnd).get_to(shots.end);
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(
        absl::StrCat(file, ": ", error.what(), "; start the run anew with --overwrite"));
  }
  return shots;
}

absl::Status WriteShots(const std::string& path, const ShotList& shots) {
  const nlohmann::ordered_json json = {{kShotsField, shots.first_frames}, {kShotsEnd, shots.end}};
  return kernels::WriteFileAtomically(path + kShotsFile, json.dump() + "\n");
}

std::string DescribeCuts(const ShotList& shots) {
  const size_t count = shots.first_frames.size();
  if (count < 2) return "";
  const std::vector<int64_t> cuts(shots.first_frames.begin() + 1, shots.first_frames.end());
  return absl::StrCat(count, " shots, cut before ", count == 2 ? "frame " : "frames ",
                      absl::StrJoin(cuts, ", "));
}

}  // namespace egosieve::tools
