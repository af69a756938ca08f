// Reuse of memory that a program has freed.
#pragma once

namespace egosieve::kernels {

// Keeps freed blocks of up to 32 MiB in the process, up to 256 MiB at the end of a heap. Large
// arrays reuse the memory of earlier ones, and the system need not return and clear pages again.
// The allocator's environment variables (MALLOC_MMAP_THRESHOLD_, MALLOC_TRIM_THRESHOLD_) have
// precedence. For programs, before they start threads. Without glibc it does nothing.
void KeepFreedMemory();

}  // namespace egosieve::kernels
