// Checks that frames/ in the truth's folder or beside it, if it exists, is the scored drive;
// otherwise FailedPrecondition, naming both. `frames` and `fingerprint` are those of `whose`
// (RunDescription::Input), read from frame `from` on.
#ifndef EGOSIEVE_TOOLS_EVALUATE_SAME_DRIVE_H_
#define EGOSIEVE_TOOLS_EVALUATE_SAME_DRIVE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace egosieve::tools {

absl::Status CheckSameDrive(const std::string& whose, const std::string& frames,
                            const std::string& fingerprint, int64_t from, const std::string& truth);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_SAME_DRIVE_H_
