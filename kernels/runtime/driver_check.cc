#include "kernels/runtime/driver_check.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "kernels/runtime/pocl_cache.h"

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;

constexpr char kElse[] = ", or use the device \"reference\"";

fs::path VendorFolder() {
  const char* vendors = std::getenv("OCL_ICD_VENDORS");
  return vendors != nullptr && *vendors != '\0' ? vendors : "/etc/OpenCL/vendors";
}

}  // namespace

std::string WhyNoDevice() {
  std::string loaded;
  std::error_code error;
  for (fs::directory_iterator it(VendorFolder(), error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() != ".icd" || !it->is_regular_file(error)) continue;
    std::string library;
    std::ifstream file(it->path());
    std::getline(file, library);
    absl::StripAsciiWhitespace(&library);
    if (library.empty()) continue;
    void* handle = dlopen(library.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (handle == nullptr) {
      const char* reason = dlerror();
      return absl::StrCat("the OpenCL driver of ", it->path().string(), " does not load (",
                          reason != nullptr ? reason : library,
                          "); give the process more memory (see ulimit -v), mend the driver",
                          kElse);
    }
    dlclose(handle);
    absl::StrAppend(&loaded, loaded.empty() ? "" : ", ", library);
  }
  if (loaded.empty()) {
    return absl::StrCat(
        "no OpenCL device was found: install an OpenCL driver (Debian: pocl-opencl-icd)", kElse);
  }
  return absl::StrCat("the OpenCL driver ", loaded,
                      " is installed and gives no device; let it write to the folder ",
                      PoclCacheFolder(),
                      " (see HOME, TMPDIR, POCL_CACHE_DIR), allow it more memory "
                      "and threads (see ulimit -v, ulimit -u)",
                      kElse);
}

}  // namespace egosieve::kernels
