// A fixed number of values in memory aligned to cache lines, not initialised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

namespace egosieve::kernels {

inline constexpr size_t kCacheLineBytes = 64;

template <typename T>
class AlignedArray {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  AlignedArray() = default;
  explicit AlignedArray(int64_t size)
      : size_(size),
        data_(
            static_cast<T*>(::operator new (size * sizeof(T), std::align_val_t{kCacheLineBytes}))) {
  }

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  int64_t size() const { return size_; }
  T& operator[](int64_t i) { return data_.get()[i]; }
  const T& operator[](int64_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* data) const { ::operator delete (data, std::align_val_t{kCacheLineBytes}); }
  };
  int64_t size_ = 0;
  std::unique_ptr<T, Free> data_;
};

}  // namespace egosieve::kernels
