// Compiled programs on disk, under programs/ in the user's cache folder
// (kernels/runtime/cache_folder.h).
//
// A file's name is the hash of everything that the binary depends on: source, options, device,
// vendor, driver and platform with their versions. The file contains that text again, the binary,
// and a hash of both. A file that does not match in every byte counts as absent, and an unwritable
// cache is not an error.
#ifndef EGOSIEVE_KERNELS_RUNTIME_PROGRAM_CACHE_H_
#define EGOSIEVE_KERNELS_RUNTIME_PROGRAM_CACHE_H_

#include <CL/opencl.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "kernels/runtime/device.h"

namespace egosieve::kernels {

// Everything that a binary depends on.
std::string ProgramKey(const DeviceInfo& device, std::string_view source, std::string_view options);

// The path of a key's binary; empty if there is no cache folder.
std::string ProgramPath(const std::string& key);

// Empty if there is no undamaged file for this key.
std::string LoadBinary(const std::string& key);

// Errors are ignored: the next run compiles again.
void StoreBinary(const std::string& key, std::string_view binary);

// Builds `source`: from the cached binary if the driver accepts it, otherwise anew, and stores the
// binary. Throws cl::Error and cl::BuildError.
cl::Program BuildProgram(const cl::Context& context, const cl::Device& device,
                         const DeviceInfo& info, const std::string& source,
                         const std::string& options, bool use_cache);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_PROGRAM_CACHE_H_
