// Handles that are not pointers: a freed or invalid handle is detected, never dereferenced.
//
//   value = generation (32 bits) | slot (24 bits) | kind (7 bits) | 1
//
// A slot's generation is raised whenever its object is freed. The handle of a freed object
// therefore matches no slot until 2^32 objects later. The lowest bit is set because no object of
// the caller has such an address. Find gives shared ownership: if an object is freed while another
// thread uses it, it is destroyed when that thread has finished.
#ifndef EGOSIEVE_TOOLS_EMBED_C_HANDLE_TABLE_H_
#define EGOSIEVE_TOOLS_EMBED_C_HANDLE_TABLE_H_

#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "tools/embed/c/last_error.h"

namespace egosieve::embed {

enum class HandleKind : uint64_t { kGaussianProcess = 1, kPosterior = 2, kSegmenter = 3 };

// Handle: the opaque struct of the C interface. Object: the type behind it.
template <HandleKind kKind, typename Handle, typename Object>
class HandleTable {
  static_assert(sizeof(uintptr_t) == 8, "handles need 64 bits");

 public:
  // ResourceExhausted if there are already 2^24 objects.
  absl::StatusOr<Handle*> Insert(std::shared_ptr<Object> object) {
    std::unique_lock lock(mutex_);
    if (free_.empty()) {
      if (slots_.size() == kMaximumSlots) {
        return absl::ResourceExhaustedError("too many handles; free some");
      }
      free_.reserve(slots_.size() + 1);  // so that Erase cannot fail
      slots_.emplace_back();
      free_.push_back(slots_.size() - 1);
    }
    const uint64_t index = free_.back();
    free_.pop_back();
    slots_[index].object = std::move(object);
    return reinterpret_cast<Handle*>(slots_[index].generation << 32 | index << 8 |
                                     static_cast<uint64_t>(kKind) << 1 | 1);
  }

  // An error of code kInvalidHandle that names the argument `name`.
  absl::StatusOr<std::shared_ptr<Object>> Find(const char* name, const Handle* handle) const {
    std::shared_lock lock(mutex_);
    const Slot* slot = SlotOf(handle);
    if (slot == nullptr) return Refusal(name, handle);
    return slot->object;
  }

  // Frees the object's handle; errors as in Find.
  absl::Status Erase(const char* name, const Handle* handle) {
    std::shared_ptr<Object> object;  // declared first: destroyed after the lock is released
    std::unique_lock lock(mutex_);
    Slot* slot = const_cast<Slot*>(SlotOf(handle));
    if (slot == nullptr) return Refusal(name, handle);
    object = std::move(slot->object);
    slot->object = nullptr;
    slot->generation = (slot->generation + 1) & 0xffffffff;
    free_.push_back(static_cast<uint64_t>(slot - slots_.data()));
    lock.unlock();
    return absl::OkStatus();
  }

 private:
  static constexpr size_t kMaximumSlots = size_t{1} << 24;

  struct Slot {
    uint64_t generation = 1;
    std::shared_ptr<Object> object;
  };

  const Slot* SlotOf(const Handle* handle) const {
    const uint64_t value = reinterpret_cast<uintptr_t>(handle);
    const uint64_t index = value >> 8 & 0xffffff;
    if ((value & 0xff) != (static_cast<uint64_t>(kKind) << 1 | 1)) return nullptr;
    if (index >= slots_.size() || slots_[index].object == nullptr) return nullptr;
    return slots_[index].generation == value >> 32 ? &slots_[index] : nullptr;
  }

  static absl::Status Refusal(const char* name, const Handle* handle) {
    const uint64_t value = reinterpret_cast<uintptr_t>(handle);
    const char* what = "is no handle of this library";
    if (handle == nullptr) {
      what = "is null";
    } else if ((value & 0xff) == (static_cast<uint64_t>(kKind) << 1 | 1)) {
      what = "was freed, or never was a handle";
    } else if ((value & 0x81) == 1 && (value & 0xff) <= 7) {
      what = "is a handle of another type";
    }
    return absl::Status(kInvalidHandle, absl::StrCat(name, " ", what));
  }

  mutable std::shared_mutex mutex_;
  std::vector<Slot> slots_;
  std::vector<uint64_t> free_;
};

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_HANDLE_TABLE_H_
