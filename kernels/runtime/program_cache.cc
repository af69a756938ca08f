#include "kernels/runtime/program_cache.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/runtime/cache_folder.h"

namespace egosieve::kernels {
namespace {

constexpr char kFormat[] = "egosieve program 1\n";

// Format, length of the key, key, binary, and a hash of all these as 16 digits.
std::string Encode(const std::string& key, std::string_view binary) {
  std::string file = absl::StrCat(kFormat, key.size(), "\n", key);
  file.append(binary.data(), binary.size());
  absl::StrAppendFormat(&file, "%016x", HashBytes(file));
  return file;
}

std::string Decode(const std::string& key, const std::string& file) {
  const std::string prefix = absl::StrCat(kFormat, key.size(), "\n", key);
  constexpr size_t kHashDigits = 16;
  if (file.size() < prefix.size() + kHashDigits || file.compare(0, prefix.size(), prefix) != 0)
    return "";
  const size_t end = file.size() - kHashDigits;
  const std::string hash = absl::StrFormat("%016x", HashBytes(std::string_view(file.data(), end)));
  if (file.compare(end, kHashDigits, hash) != 0) return "";
  return file.substr(prefix.size(), end - prefix.size());
}

// A program whose build has failed is dropped, not released: after some failures, such as a lack of
// memory, PoCL 3.1 keeps the program's lock held, and clReleaseProgram would wait for it forever.
void Build(cl::Program& program, const cl::Device& device, const std::string& options) {
  try {
    // Program::build would request the log after any error, and throw that request's error instead.
    const cl_int code = clBuildProgram(program(), 1, &device(), options.c_str(), nullptr, nullptr);
    if (code == CL_BUILD_PROGRAM_FAILURE) {
      throw cl::BuildError(code, "clBuildProgram", program.getBuildInfo<CL_PROGRAM_BUILD_LOG>());
    }
    if (code != CL_SUCCESS) throw cl::Error(code, "clBuildProgram");
  } catch (...) {
    program() = nullptr;
    throw;
  }
}

// Returns a null program if the driver refuses the binary, as may happen after a driver update that
// does not change its version.
cl::Program FromBinary(const cl::Context& context, const cl::Device& device,
                       const std::string& binary, const std::string& options) {
  try {
    cl::Program program(context, {device},
                        {std::vector<unsigned char>(binary.begin(), binary.end())});
    Build(program, device, options);
    return program;
  } catch (const cl::Error&) {
    return cl::Program();
  }
}

}  // namespace

std::string ProgramKey(const DeviceInfo& device, std::string_view source,
                       std::string_view options) {
  return absl::StrCat(device.name, "\n", device.vendor, "\n", device.platform, "\n", device.version,
                      "\n", device.driver, "\n", absl::string_view(options.data(), options.size()),
                      "\n", absl::string_view(source.data(), source.size()));
}

std::string ProgramPath(const std::string& key) {
  const std::string folder = CacheFolder();
  return folder.empty() ? "" : absl::StrFormat("%s/programs/%016x.bin", folder, HashBytes(key));
}

std::string LoadBinary(const std::string& key) {
  const std::string path = ProgramPath(key);
  return path.empty() ? "" : Decode(key, ReadCacheFile(path));
}

void StoreBinary(const std::string& key, std::string_view binary) {
  const std::string path = ProgramPath(key);
  if (!path.empty()) WriteCacheFile(path, Encode(key, binary)).IgnoreError();
}

cl::Program BuildProgram(const cl::Context& context, const cl::Device& device,
                         const DeviceInfo& info, const std::string& source,
                         const std::string& options, bool use_cache) {
  const std::string key = ProgramKey(info, source, options);
  if (use_cache) {
    const std::string binary = LoadBinary(key);
    if (!binary.empty()) {
      cl::Program program = FromBinary(context, device, binary, options);
      if (program() != nullptr) return program;
    }
  }
  cl::Program program(context, source);
  Build(program, device, options);
  if (use_cache) {
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    if (binaries.size() == 1 && !binaries[0].empty()) {
      StoreBinary(key, std::string_view(reinterpret_cast<const char*>(binaries[0].data()),
                                        binaries[0].size()));
    }
  }
  return program;
}

}  // namespace egosieve::kernels
