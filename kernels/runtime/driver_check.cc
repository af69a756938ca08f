#include "kernels/runtime/driver_check.h"

#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

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

std::atomic<pid_t> first_user{0};

// A program of PoCL's takes up to about so many bytes.
constexpr size_t kProgramBytes = 65536;

// `folder`, or its nearest existing parent; empty if there is none but the root.
std::string ExistingPart(std::string folder) {
  while (access(folder.c_str(), F_OK) != 0) {
    const size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) return "";
    folder.resize(slash);
  }
  return folder;
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

absl::Status CheckNotForked() {
  const pid_t here = getpid();
  pid_t user = 0;
  if (first_user.compare_exchange_strong(user, here) || user == here) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "this process was forked from one that had used OpenCL, whose drivers do not survive that: "
      "start processes by spawn (in Python multiprocessing.get_context(\"spawn\")), fork before "
      "the first use, or use the device \"reference\" in both");
}

std::string PoclCacheFolder() {
  if (const char* chosen = std::getenv("POCL_CACHE_DIR")) return chosen;
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return absl::StrCat(cache, "/pocl/kcache");
  if (const char* home = std::getenv("HOME")) return absl::StrCat(home, "/.cache/pocl/kcache");
  return "";
}

absl::Status CheckPoclCanWrite() {
  const std::string folder = PoclCacheFolder(), existing = ExistingPart(folder);
  if (existing.empty()) return absl::PermissionDeniedError(absl::StrCat("cannot write ", folder));
  const std::string path = absl::StrCat(existing, "/egosieve-room");
  EGOSIEVE_ASSIGN_OR_RETURN(const TemporaryFile file, TemporaryFile::Create(path));
  return WriteAll(file.descriptor(), std::string(kProgramBytes, '\0'), path);
}

void LetPoclWrite() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr) return;
  const std::string existing = ExistingPart(PoclCacheFolder());
  if (!existing.empty() && access(existing.c_str(), W_OK | X_OK) == 0) return;
  const char* temporary = std::getenv("TMPDIR");
  const std::string folder =
      absl::StrCat(temporary != nullptr ? temporary : "/tmp", "/egosieve-pocl-", getuid());
  mkdir(folder.c_str(), 0700);
  struct stat status;
  if (lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == getuid()) {
    setenv("POCL_CACHE_DIR", folder.c_str(), /*overwrite=*/0);
  }
}

}  // namespace egosieve::kernels
