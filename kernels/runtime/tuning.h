// The best shapes of the kernels for one device, which the tuner (tools/tune) searches for.
//
// A table is a text file of lines "name value" in the user's cache folder, one file per device,
// read when a context is opened. Unknown names, values out of range and damaged files are ignored;
// the defaults are then used.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "kernels/runtime/device.h"

namespace egosieve::kernels {

struct KernelTuning {
  int float_lanes = 4;  // lanes of a float vector: 1, 4, 8 or 16
  int mean_width = 2;   // vectors of queries at once for means alone: 1 to 8
  int width = 3;        // vectors of queries in a register block of the factor's kernel: 1 to 8
  int panel = 8;        // rows of the factor in a register block: 1 to 32
  int panels_per_group = 12;  // register blocks in a cache block of rows: 1 to 64
  int depth = 192;            // columns of the factor in a cache block: 4 to 4096
  int micro_tiles = 4;        // register blocks of queries in a tile: 1 to 64
  int work_group = 1;         // work-items side by side, each with a tile: 1 to 1024
  int groups_per_unit = 1;    // work-groups per compute unit: 1 to 64
  // 1: the kernels of kernels/cl/dense_posterior_local.cl, in which a work-group shares a tile and
  // stages it in local memory. Then float_lanes is 1, panels_per_group divides work_group, and
  // depth divides panel * panels_per_group. 0: those of dense_posterior.cl.
  int local_tiles = 0;

  // InvalidArgument, naming field and value.
  absl::Status Validate() const;
  friend bool operator==(const KernelTuning& a, const KernelTuning& b) = default;
};

// Good values, without a search, for devices with vectors of `float_lanes` lanes.
KernelTuning DefaultTuning(int float_lanes);
// For thousands of scalar work-items side by side, with tiles in local memory.
KernelTuning DefaultGpuTuning();

std::string FormatTuning(const KernelTuning& tuning);

// `defaults` with the values in `text`; `defaults` alone if the result would be invalid.
KernelTuning ParseTuning(std::string_view text, const KernelTuning& defaults);

// The path of a device's table; empty if there is no cache folder.
std::string TuningPath(const DeviceInfo& device);

KernelTuning LoadTuning(const DeviceInfo& device, const KernelTuning& defaults);

// Writes a file beside the table and renames it.
absl::Status SaveTuning(const DeviceInfo& device, const KernelTuning& tuning);

// The user's cache folder: $EGOSIEVE_CACHE_DIR, else $XDG_CACHE_HOME/egosieve, else $HOME/.cache/egosieve; empty if none is
// set. It need not exist.
std::string CacheFolder();

// FNV-1a, 64 bits.
uint64_t HashBytes(std::string_view bytes);

}  // namespace egosieve::kernels
