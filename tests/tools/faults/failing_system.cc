// A library for LD_PRELOAD: one call of the system fails when a test wants it to.
//
//   EGOSIEVE_FAULT_KIND    read, write, fsync, rename, open, allocate or thread
//   EGOSIEVE_FAULT_NUMBER  which call of that kind fails, from 0; with those of child processes
//   EGOSIEVE_FAULT_ROOT    files below this folder alone count
//   EGOSIEVE_FAULT_COUNTS  a file of kKinds 64-bit numbers that counts the calls, shared by
//   processes
//
// Allocations under 64 KiB never fail: the system refuses large ones. A write that fails has
// written half of its bytes, as on a full disk.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>

#include "tests/tools/faults/fault_kinds.h"

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace {

using egosieve::tools::FaultKind;
using egosieve::tools::kFaultKinds;
using egosieve::tools::kFaultNames;

constexpr size_t kLargeBytes = 64 << 10;

std::atomic<int64_t>* counts = nullptr;  // null: nothing counts, nothing fails
int failing_kind = -1;
int64_t failing_number = -1;
char root[4096];
size_t root_length = 0;

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

__attribute__((constructor)) void Begin() {
  const char* file = getenv("EGOSIEVE_FAULT_COUNTS");
  const char* folder = getenv("EGOSIEVE_FAULT_ROOT");
  if (file == nullptr || folder == nullptr) return;
  const int descriptor = Next<int(const char*, int, ...)>("open")(file, O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return;
  void* memory = mmap(nullptr, kFaultKinds * sizeof(int64_t), PROT_READ | PROT_WRITE, MAP_SHARED,
                      descriptor, 0);
  close(descriptor);
  if (memory == MAP_FAILED) return;
  root_length = strlen(folder);
  if (root_length >= sizeof(root)) return;
  memcpy(root, folder, root_length + 1);
  const char* kind = getenv("EGOSIEVE_FAULT_KIND");
  const char* number = getenv("EGOSIEVE_FAULT_NUMBER");
  for (int i = 0; kind != nullptr && number != nullptr && i < kFaultKinds; ++i) {
    if (strcmp(kind, kFaultNames[i]) != 0) continue;
    failing_kind = i;
    failing_number = atoll(number);
  }
  counts = static_cast<std::atomic<int64_t>*>(memory);
}

bool Fails(FaultKind kind) {
  if (counts == nullptr) return false;
  const int index = static_cast<int>(kind);
  const int64_t number = counts[index]++;
  return index == failing_kind && number == failing_number;
}

bool Below(const char* path) {
  if (counts == nullptr || path == nullptr) return false;
  return strncmp(path, root, root_length) == 0;
}

bool Below(int descriptor) {
  if (counts == nullptr) return false;
  char link[64], path[4096];
  snprintf(link, sizeof(link), "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof(path) - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return Below(path);
}

int Refuse(int error) {
  errno = error;
  return -1;
}

bool AllocationFails(size_t size) {
  if (size < kLargeBytes || !Fails(FaultKind::kAllocate)) return false;
  errno = ENOMEM;
  return true;
}

int Open(const char* name, const char* path, int flags, va_list arguments) {
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  if (Below(path) && Fails(FaultKind::kOpen)) return Refuse(EMFILE);
  return Next<decltype(open)>(name)(path, flags, mode);
}

FILE* OpenStream(const char* name, const char* path, const char* mode) {
  if (!Below(path) || !Fails(FaultKind::kOpen)) return Next<decltype(fopen)>(name)(path, mode);
  errno = EMFILE;
  return nullptr;
}

}  // namespace

extern "C" {

ssize_t read(int descriptor, void* bytes, size_t size) {
  if (Below(descriptor) && Fails(FaultKind::kRead)) return Refuse(EIO);
  return Next<decltype(read)>("read")(descriptor, bytes, size);
}

ssize_t pread(int descriptor, void* bytes, size_t size, off_t offset) {
  if (Below(descriptor) && Fails(FaultKind::kRead)) return Refuse(EIO);
  return Next<decltype(pread)>("pread")(descriptor, bytes, size, offset);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  const auto next = Next<decltype(write)>("write");
  if (Below(descriptor) && Fails(FaultKind::kWrite)) {
    [[maybe_unused]] const ssize_t half = next(descriptor, bytes, size / 2);
    return Refuse(ENOSPC);
  }
  return next(descriptor, bytes, size);
}

ssize_t writev(int descriptor, const struct iovec* pieces, int count) {
  if (Below(descriptor) && Fails(FaultKind::kWrite)) return Refuse(ENOSPC);
  return Next<decltype(writev)>("writev")(descriptor, pieces, count);
}

int fsync(int descriptor) {
  if (Below(descriptor) && Fails(FaultKind::kFsync)) return Refuse(EIO);
  return Next<decltype(fsync)>("fsync")(descriptor);
}

// A link is what merge does instead of a rename.
int link(const char* from, const char* to) {
  if (Below(to) && Fails(FaultKind::kRename)) return Refuse(EIO);
  return Next<decltype(link)>("link")(from, to);
}

int rename(const char* from, const char* to) {
  if (Below(to) && Fails(FaultKind::kRename)) return Refuse(EIO);
  return Next<decltype(rename)>("rename")(from, to);
}

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int descriptor = Open("open", path, flags, arguments);
  va_end(arguments);
  return descriptor;
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int descriptor = Open("open64", path, flags, arguments);
  va_end(arguments);
  return descriptor;
}

FILE* fopen(const char* path, const char* mode) { return OpenStream("fopen", path, mode); }

FILE* fopen64(const char* path, const char* mode) { return OpenStream("fopen64", path, mode); }

int mkostemp(char* path, int flags) {
  if (Below(path) && Fails(FaultKind::kOpen)) return Refuse(EMFILE);
  return Next<decltype(mkostemp)>("mkostemp")(path, flags);
}

int mkostemps(char* path, int suffix, int flags) {
  if (Below(path) && Fails(FaultKind::kOpen)) return Refuse(EMFILE);
  return Next<decltype(mkostemps)>("mkostemps")(path, suffix, flags);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*),
                   void* argument) {
  if (Fails(FaultKind::kThread)) return EAGAIN;
  return Next<decltype(pthread_create)>("pthread_create")(thread, attributes, body, argument);
}

void* malloc(size_t size) { return AllocationFails(size) ? nullptr : __libc_malloc(size); }

void* calloc(size_t count, size_t size) {
  return AllocationFails(count * size) ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* old, size_t size) {
  return AllocationFails(size) ? nullptr : __libc_realloc(old, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
  return AllocationFails(size) ? nullptr : __libc_memalign(alignment, size);
}

void* memalign(size_t alignment, size_t size) {
  return AllocationFails(size) ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** result, size_t alignment, size_t size) {
  if (AllocationFails(size)) return ENOMEM;
  void* memory = __libc_memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *result = memory;
  return 0;
}

}  // extern "C"
