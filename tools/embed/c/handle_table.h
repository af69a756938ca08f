// Handles that are not pointers: a freed or invalid handle is detected, never dereferenced.
//
//   value = generation (32 bits) | slot (24 bits) | kind (7 bits) | 1
//
// A slot's generation is raised whenever its object is freed. The handle of a freed object
// therefore matches no slot until 2^32 objects later. The lowest bit is set because no object of
// the caller has such an address. Find gives shared ownership: if an object is freed while another
// thread uses it, it is destroyed when that thread has finished.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <utility>
#include <vector>

#include "tools/embed/c/call.h"

namespace egosieve::embed {

// Of an opaque struct of the C interface: Object, the type behind it; kKind, a number of its own;
// kName, what calls name the argument.
template <typename Handle>
struct HandleOf;

template <typename Handle>
class HandleTable {
  static_assert(sizeof(uintptr_t) == 8, "handles need 64 bits");
  using Object = typename HandleOf<Handle>::Object;

 public:
  // Never destroyed, because a program may use handles in its own destructors.
  static HandleTable& All() {
    static auto* table = new HandleTable;
    return *table;
  }

  // ResourceExhausted if there are already 2^24 objects.
  Handle* Insert(std::shared_ptr<Object> object) {
    std::unique_lock lock(mutex_);
    if (free_.empty()) {
      if (slots_.size() == kMaximumSlots) {
        Check(absl::ResourceExhaustedError("too many handles; free some"));
      }
      free_.reserve(slots_.size() + 1);  // so that Erase cannot fail
      slots_.emplace_back();
      free_.push_back(slots_.size() - 1);
    }
    const uint64_t index = free_.back();
    free_.pop_back();
    slots_[index].object = std::move(object);
    return reinterpret_cast<Handle*>(slots_[index].generation << 32 | index << 8 | kLowByte);
  }

  // An error of code kInvalidHandle that names the argument.
  std::shared_ptr<Object> Find(const Handle* handle) const {
    std::shared_lock lock(mutex_);
    return slots_[IndexOf(handle)].object;
  }

  // Frees the object's handle; errors as in Find.
  void Erase(const Handle* handle) {
    std::shared_ptr<Object> object;  // declared first: destroyed after the lock is released
    std::unique_lock lock(mutex_);
    const uint64_t index = IndexOf(handle);
    object = std::exchange(slots_[index].object, nullptr);
    slots_[index].generation = (slots_[index].generation + 1) & 0xffffffff;
    free_.push_back(index);
  }

 private:
  static constexpr size_t kMaximumSlots = size_t{1} << 24;
  static constexpr uint64_t kLowByte = HandleOf<Handle>::kKind << 1 | 1;

  struct Slot {
    uint64_t generation = 1;
    std::shared_ptr<Object> object;
  };

  uint64_t IndexOf(const Handle* handle) const {
    const uint64_t value = reinterpret_cast<uintptr_t>(handle);
    const uint64_t index = value >> 8 & 0xffffff, low = value & 0xff;
    if (low == kLowByte && index < slots_.size() && slots_[index].object != nullptr &&
        slots_[index].generation == value >> 32) {
      return index;
    }
    const char* what = handle == nullptr          ? "is null"
                       : low == kLowByte          ? "was freed, or never was a handle"
                       : low % 2 == 1 && low <= 7 ? "is a handle of another type"
                                                  : "is no handle of this library";
    throw CallError{
        absl::Status(kInvalidHandle, absl::StrFormat("%s %s", HandleOf<Handle>::kName, what))};
  }

  mutable std::shared_mutex mutex_;
  std::vector<Slot> slots_;
  std::vector<uint64_t> free_;
};

// Calls of the C interface, within Guard. With: `body` with the object behind `handle`.
template <typename Handle, typename Body>
egosieve_status With(const char* function, Handle* handle, const Body& body) {
  return Guard(function, [&] { body(*HandleTable<Handle>::All().Find(handle)); });
}

// Gives a handle of the object that `make` gives.
template <typename Handle, typename Make>
egosieve_status New(const char* function, Handle** handle, const Make& make) {
  return Guard(function, [&] {
    RequirePointer(HandleOf<Handle>::kName, handle);
    *handle = HandleTable<Handle>::All().Insert(make());
  });
}

// The same of one that `make` gives from the object behind `source`.
template <typename Source, typename Handle, typename Make>
egosieve_status NewFrom(const char* function, Source* source, Handle** handle, const Make& make) {
  return New(function, handle, [&] { return make(*HandleTable<Source>::All().Find(source)); });
}

template <typename Handle>
egosieve_status Free(const char* function, Handle* handle) {
  if (handle == nullptr) return EGOSIEVE_OK;
  return Guard(function, [&] { HandleTable<Handle>::All().Erase(handle); });
}

}  // namespace egosieve::embed
