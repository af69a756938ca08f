// What becomes of memory that a program has freed.
#ifndef EGOSIEVE_KERNELS_BASE_KEPT_MEMORY_H_
#define EGOSIEVE_KERNELS_BASE_KEPT_MEMORY_H_

namespace egosieve::kernels {

// Freed blocks of up to 32 MiB stay with the process, up to 256 MiB at the end of a heap: pictures
// and fields of every frame take the places of those before, and the system need not give and clear
// pages again. What the environment says to the allocator (MALLOC_MMAP_THRESHOLD_,
// MALLOC_TRIM_THRESHOLD_) has precedence. For programs, before they start threads; elsewhere than
// with glibc nothing changes.
void KeepFreedMemory();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_KEPT_MEMORY_H_
