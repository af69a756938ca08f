// One of N shares of a run's frames: the pieces between checkpoints are dealt out in turn.
//
//   frame i belongs to share (i / checkpoint_every) mod N
//
// Each piece therefore begins at a checkpoint, and the shares do not depend on the drive's length.
// Commands without a model deal out pieces of kPieceFrames.
#ifndef EGOSIEVE_TOOLS_INFER_SHARD_H_
#define EGOSIEVE_TOOLS_INFER_SHARD_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace egosieve::tools {

inline constexpr int64_t kPieceFrames = 32;

struct Shard {
  int64_t index = 0;  // of 0 .. count - 1
  int64_t count = 1;
  int64_t checkpoint_every = 0;  // frames

  bool Contains(int64_t frame) const {
    return count == 1 || frame / checkpoint_every % count == index;
  }
};

// Parses "K/N" with K from 1 to N; empty: all frames. InvalidArgument; FailedPrecondition without
// checkpoints.
inline absl::StatusOr<Shard> ParseShard(const std::string& text, int64_t checkpoint_every) {
  Shard shard;
  shard.checkpoint_every = checkpoint_every;
  if (text.empty()) return shard;
  const std::vector<std::string> parts = absl::StrSplit(text, '/');
  if (parts.size() != 2 || !absl::SimpleAtoi(parts[0], &shard.index) ||
      !absl::SimpleAtoi(parts[1], &shard.count) || shard.index < 1 || shard.index > shard.count) {
    return absl::InvalidArgumentError(
        absl::StrCat("--shard=", text, " is not K/N with K from 1 to N; give, say, 1/4"));
  }
  --shard.index;
  if (shard.count > 1 && checkpoint_every == 0) {
    return absl::FailedPreconditionError(
        "the run has no checkpoints to begin shards at; leave --shard away");
  }
  return shard;
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_SHARD_H_
