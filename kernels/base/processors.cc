#include "kernels/base/processors.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <thread>

#include "absl/strings/str_cat.h"

namespace egosieve::kernels {
namespace {

constexpr double kNoQuota = std::numeric_limits<double>::infinity();

// Quota over period; a quota of "max" or -1 means no limit.
double Ratio(std::istream& quota, std::istream& period) {
  double allowed = 0.0, of = 0.0;
  const bool is_limited = quota >> allowed && period >> of && allowed > 0.0 && of > 0.0;
  return is_limited ? allowed / of : kNoQuota;
}

// Quota of one group.
double QuotaIn(const std::string& folder) {
  std::ifstream both(folder + "/cpu.max");
  if (both) return Ratio(both, both);
  std::ifstream quota(folder + "/cpu.cfs_quota_us"), period(folder + "/cpu.cfs_period_us");
  return Ratio(quota, period);
}

// Least quota of a group and all groups above it. In a container the root may be the group itself,
// and the path in /proc/self/cgroup may not exist.
double LeastQuota(const std::string& mount, std::string path) {
  double least = kNoQuota;
  while (true) {
    least = std::min(least, QuotaIn(mount + path));
    const size_t slash = path.rfind('/');
    if (slash == std::string::npos) return least;
    path.resize(slash);
  }
}

int ProcessorsByAffinity() {
  cpu_set_t allowed;
  // Fails if the computer has more processors than the set can hold.
  if (sched_getaffinity(0, sizeof(allowed), &allowed) == 0) return CPU_COUNT(&allowed);
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

// Lines have the form number:controllers:path; version 2 names no controllers.
double ProcessorQuota(const std::string& membership, const std::string& root) {
  double least = kNoQuota;
  std::istringstream lines(membership);
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find(':');
    const size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string path = line.substr(second + 1);
    if (controllers.empty()) {
      least = std::min({least, LeastQuota(root, path), LeastQuota(root + "/unified", path)});
    } else if (absl::StrCat(",", controllers, ",").find(",cpu,") != std::string::npos) {
      least = std::min({least, LeastQuota(absl::StrCat(root, "/", controllers), path),
                        LeastQuota(root + "/cpu", path)});
    }
  }
  return least;
}

int AvailableProcessors() {
  std::ifstream file("/proc/self/cgroup");
  const std::string membership{std::istreambuf_iterator<char>(file), {}};
  const double quota = std::ceil(ProcessorQuota(membership, "/sys/fs/cgroup"));
  const int processors = ProcessorsByAffinity();
  return std::max(1, quota < processors ? static_cast<int>(quota) : processors);
}

}  // namespace egosieve::kernels
