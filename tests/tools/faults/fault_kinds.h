// The kinds of calls that failing_system.cc makes fail.
#pragma once

namespace egosieve::tools {

enum class FaultKind { kRead, kWrite, kFsync, kRename, kOpen, kAllocate, kThread };

inline constexpr int kFaultKinds = 7;
inline constexpr const char* kFaultNames[kFaultKinds] = {"read", "write",    "fsync", "rename",
                                                         "open", "allocate", "thread"};

}  // namespace egosieve::tools
