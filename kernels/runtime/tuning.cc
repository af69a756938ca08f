#include "kernels/runtime/tuning.h"

#include <array>
#include <cstdlib>
#include <filesystem>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/argument_checks.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::kernels {
namespace {

struct Field {
  const char* name;
  int KernelTuning::*member;
  int least;
  int most;
};

constexpr std::array<Field, 10> kFields = {{
    {"float_lanes", &KernelTuning::float_lanes, 1, 16},
    {"mean_width", &KernelTuning::mean_width, 1, 8},
    {"width", &KernelTuning::width, 1, 8},
    {"panel", &KernelTuning::panel, 1, 32},
    {"panels_per_group", &KernelTuning::panels_per_group, 1, 64},
    {"depth", &KernelTuning::depth, 4, 4096},
    {"micro_tiles", &KernelTuning::micro_tiles, 1, 64},
    {"work_group", &KernelTuning::work_group, 1, 1024},
    {"groups_per_unit", &KernelTuning::groups_per_unit, 1, 64},
    {"local_tiles", &KernelTuning::local_tiles, 0, 1},
}};

}  // namespace

absl::Status KernelTuning::Validate() const {
  for (const Field& field : kFields) {
    const int value = this->*field.member;
    EGOSIEVE_REQUIRE(InvalidArgument, value >= field.least && value <= field.most,
                     "%s = %d; it must be from %d to %d", field.name, value, field.least,
                     field.most);
  }
  EGOSIEVE_REQUIRE(InvalidArgument,
                   float_lanes == 1 || float_lanes == 4 || float_lanes == 8 || float_lanes == 16,
                   "float_lanes = %d; it must be 1, 4, 8 or 16", float_lanes);
  if (local_tiles == 0) return absl::OkStatus();
  EGOSIEVE_REQUIRE(InvalidArgument,
                   float_lanes == 1 && work_group % panels_per_group == 0 &&
                       panel * panels_per_group % depth == 0,
                   "local_tiles = 1 with float_lanes = %d, panel = %d, panels_per_group = %d, "
                   "work_group = %d, depth = %d; float_lanes must be 1, panels_per_group "
                   "divide work_group, and depth divide "
                   "panel * panels_per_group",
                   float_lanes, panel, panels_per_group, work_group, depth);
  return absl::OkStatus();
}

// 64 sums in registers, blocks of 128 rows by 128 queries, 8 KiB of local memory: fast on an H200
// (bench/results/gpu.md). `egosieve tune` searches for others.
KernelTuning DefaultGpuTuning() {
  KernelTuning tuning;
  tuning.local_tiles = 1;
  tuning.float_lanes = 1;
  tuning.mean_width = 4;
  tuning.width = 8;
  tuning.panel = 8;
  tuning.panels_per_group = 16;
  tuning.depth = 8;
  tuning.micro_tiles = 1;
  tuning.work_group = 256;
  tuning.groups_per_unit = 2;
  return tuning;
}

KernelTuning DefaultTuning(int float_lanes) {
  KernelTuning tuning;
  tuning.float_lanes = float_lanes;
  if (float_lanes < 16) {
    // 16 registers instead of 32.
    tuning.mean_width = 1;
    tuning.width = 2;
    tuning.panel = 6;
    tuning.panels_per_group = 16;
  }
  if (float_lanes == 1) {
    tuning.width = 8;
    tuning.micro_tiles = 2;
  }
  return tuning;
}

std::string FormatTuning(const KernelTuning& tuning) {
  std::string text;
  for (const Field& field : kFields)
    absl::StrAppend(&text, field.name, " ", tuning.*field.member, "\n");
  return text;
}

KernelTuning ParseTuning(std::string_view text, const KernelTuning& defaults) {
  KernelTuning tuning = defaults;
  for (const absl::string_view line :
       absl::StrSplit(absl::string_view(text.data(), text.size()), '\n')) {
    const std::vector<absl::string_view> words = absl::StrSplit(line, ' ', absl::SkipWhitespace());
    int value;
    if (words.size() != 2 || !absl::SimpleAtoi(words[1], &value)) continue;
    for (const Field& field : kFields) {
      if (words[0] == field.name) tuning.*field.member = value;
    }
  }
  return tuning.Validate().ok() ? tuning : defaults;
}

std::string CacheFolder() {
  if (const char* own = std::getenv("EGOSIEVE_CACHE_DIR"); own != nullptr && *own != '\0')
    return own;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return absl::StrCat(cache, "/egosieve");
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return absl::StrCat(home, "/.cache/egosieve");
  }
  return "";
}

uint64_t HashBytes(std::string_view bytes) {
  uint64_t hash = 14695981039346656037u;
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 1099511628211u;
  }
  return hash;
}

std::string TuningPath(const DeviceInfo& device) {
  const std::string folder = CacheFolder();
  if (folder.empty()) return "";
  const uint64_t key = HashBytes(
      absl::StrCat(device.name, "\n", device.vendor, "\n", device.platform, "\n", device.driver));
  return absl::StrFormat("%s/tuning/%016x.txt", folder, key);
}

KernelTuning LoadTuning(const DeviceInfo& device, const KernelTuning& defaults) {
  const std::string path = TuningPath(device);
  return path.empty() ? defaults : ParseTuning(ReadFile(path).value_or(""), defaults);
}

absl::Status SaveTuning(const DeviceInfo& device, const KernelTuning& tuning) {
  const std::string path = TuningPath(device);
  EGOSIEVE_REQUIRE(FailedPrecondition, !path.empty(),
                   "there is no cache folder: set HOME, XDG_CACHE_HOME or EGOSIEVE_CACHE_DIR");
  CreateFolder(std::filesystem::path(path).parent_path().string()).IgnoreError();  // reported below
  return WriteFileAtomically(path, FormatTuning(tuning));
}

}  // namespace egosieve::kernels
