#include "kernels/runtime/driver_check.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
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

struct Driver {
  std::string file;     // the file that names it to the loader
  std::string library;  // the library's name in that file
};

std::vector<Driver> InstalledDrivers() {
  std::vector<Driver> drivers;
  std::error_code error;
  for (fs::directory_iterator it(VendorFolder(), error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() != ".icd" || !it->is_regular_file(error)) continue;
    std::string library;
    std::ifstream file(it->path());
    std::getline(file, library);
    absl::StripAsciiWhitespace(&library);
    if (!library.empty()) drivers.push_back({it->path().string(), library});
  }
  return drivers;
}

}  // namespace

absl::Status CheckDriversCanStart(const std::string& processors) {
  std::error_code error;
  if (fs::exists(processors, error)) return absl::OkStatus();
  for (const Driver& driver : InstalledDrivers()) {
    if (!absl::StrContains(driver.library, "pocl")) continue;
    return absl::UnavailableError(
        absl::StrCat("the OpenCL driver ", driver.library, " cannot find the processors, as ",
                     processors, " is missing; mount /sys (mount -t sysfs sysfs /sys)", kElse));
  }
  return absl::OkStatus();
}

std::string WhyNoDevice() {
  std::string loaded;
  for (const auto& [file, library] : InstalledDrivers()) {
    void* handle = dlopen(library.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (handle == nullptr) {
      const char* reason = dlerror();
      return absl::StrCat(
          "the OpenCL driver of ", file, " does not load (", reason != nullptr ? reason : library,
          "); give the process more memory (see ulimit -v), repair the driver", kElse);
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
