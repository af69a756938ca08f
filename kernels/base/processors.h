// The number of processors that this process may use.
//
//   affinity   processors that its threads may run on (taskset, cpusets)
//   quota      processor time per second that control groups allow, rounded up: the least along the
//              path from its group to the root, by cpu.max (version 2) or cpu.cfs_quota_us over
//              cpu.cfs_period_us (version 1)
#pragma once

#include <string>

namespace egosieve::kernels {

// The lesser of the two, at least 1. Queries the system each time.
int AvailableProcessors();

// The quota of a process: `membership` is its /proc/self/cgroup, `root` the folder where control
// groups are mounted. Infinity if there is no quota.
double ProcessorQuota(const std::string& membership, const std::string& root);

}  // namespace egosieve::kernels
