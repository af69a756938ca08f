// Files are whole or absent, and an error is an error: system calls fail here as on a bad disk, by
// definitions that stand before the C library's.
#include "kernels/files/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <filesystem>
#include <fstream>

#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"

namespace {

// Negative: none fails.
int reads_until_failure = -1;
int syncs_until_failure = -1;
bool folders_open = true;

}  // namespace

extern "C" ssize_t read(int descriptor, void* bytes, size_t count) {
  if (reads_until_failure >= 0 && reads_until_failure-- == 0) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_read, descriptor, bytes, count);
}

extern "C" int fsync(int descriptor) {
  if (syncs_until_failure >= 0 && syncs_until_failure-- == 0) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

extern "C" int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const int mode = (flags & O_CREAT) != 0 ? va_arg(more, int) : 0;
  va_end(more);
  if (!folders_open && (flags & O_DIRECTORY) != 0) {
    errno = EACCES;
    return -1;
  }
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class AtomicFile : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return folder_ + "/" + name; }

  const std::string folder_ = FreshFolder();
};

TEST_F(AtomicFile, WritingReplacesTheWholeFileAndLeavesNothingBeside) {
  ASSERT_TRUE(WriteFileAtomically(At("a"), "a long first content").ok());
  ASSERT_TRUE(WriteFileAtomically(At("a"), "second").ok());
  EXPECT_EQ(*ReadFile(At("a")), "second");
  EXPECT_THAT(*ListFolder(folder_), ElementsAre("a"));
  const mode_t mask = umask(0);
  umask(mask);
  EXPECT_EQ(static_cast<mode_t>(fs::status(At("a")).permissions()), 0666 & ~mask);
}

TEST_F(AtomicFile, APathThatCannotBeWrittenIsNamed) {
  const absl::Status status = WriteFileAtomically("/nowhere/at/all", "x");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("/nowhere/at/all"));
}

// A limit on the file size stands for a full disk: the write fails after a part of the bytes.
TEST_F(AtomicFile, AFullDiskLeavesTheOldFile) {
  ASSERT_TRUE(WriteFileAtomically(At("a"), "old").ok());
  const rlimit limit{1000, 1000};
  EXPECT_EXIT(
      {
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &limit);
        const absl::Status status = WriteFileAtomically(At("a"), std::string(5000, 'x'));
        _exit(absl::IsResourceExhausted(status) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
  EXPECT_EQ(*ReadFile(At("a")), "old");
  EXPECT_THAT(*ListFolder(folder_), ElementsAre("a"));
}

// All that can fail before the rename does.
TEST_F(AtomicFile, AnErrorBeforeTheRenameLeavesTheOldFile) {
  ASSERT_TRUE(WriteFileAtomically(At("a"), "old").ok());
  folders_open = false;
  absl::Status status = WriteFileAtomically(At("a"), "new");
  folders_open = true;
  EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied) << status;
  EXPECT_THAT(status.message(), HasSubstr(folder_));
  EXPECT_EQ(*ReadFile(At("a")), "old");
  syncs_until_failure = 0;  // the file's
  status = WriteFileAtomically(At("a"), "new");
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_EQ(*ReadFile(At("a")), "old");
  EXPECT_THAT(*ListFolder(folder_), ElementsAre("a"));
}

TEST_F(AtomicFile, AFolderThatIsNotSyncedIsAnErrorAndTheNewFileIsThere) {
  ASSERT_TRUE(WriteFileAtomically(At("a"), "old").ok());
  syncs_until_failure = 1;  // the folder's, after the rename
  const absl::Status status = WriteFileAtomically(At("a"), "new");
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_THAT(status.message(), HasSubstr(folder_));
  EXPECT_EQ(*ReadFile(At("a")), "new");
  EXPECT_THAT(*ListFolder(folder_), ElementsAre("a"));
}

TEST_F(AtomicFile, OnlyRegularFilesAreReplaced) {
  std::ofstream(At("file")) << "mine";
  fs::create_symlink(At("file"), At("link"));
  ASSERT_EQ(mkfifo(At("pipe").c_str(), 0600), 0);
  fs::create_directory(At("folder"));
  for (const char* name : {"link", "pipe", "folder"}) {
    const absl::Status status = WriteFileAtomically(At(name), "x");
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << name;
    EXPECT_THAT(status.message(), HasSubstr(At(name)));
  }
  EXPECT_EQ(*ReadFile(At("file")), "mine");
  EXPECT_THAT(*ListFolder(folder_), ElementsAre("file", "folder", "link", "pipe"));
}

// Names that anybody can foresee lead where somebody else wants.
TEST_F(AtomicFile, TemporariesFollowNoLink) {
  std::ofstream(At("victim")) << "theirs";
  fs::create_symlink(At("victim"), At("a.tmp"));
  ASSERT_TRUE(WriteFileAtomically(At("a"), "x").ok());
  EXPECT_EQ(*ReadFile(At("victim")), "theirs");
}

TEST_F(AtomicFile, AReadErrorIsNoEndOfTheFile) {
  ASSERT_TRUE(WriteFileAtomically(At("a"), std::string(3 << 20, 'x')).ok());
  for (const int nth : {0, 1}) {
    reads_until_failure = nth;
    const absl::StatusOr<std::string> bytes = ReadFile(At("a"));
    reads_until_failure = -1;
    EXPECT_EQ(bytes.status().code(), absl::StatusCode::kUnavailable) << nth;
    EXPECT_THAT(bytes.status().message(), HasSubstr("Input/output error"));
  }
  EXPECT_EQ(ReadFile(At("a"))->size(), size_t{3} << 20);
}

TEST_F(AtomicFile, WhatIsNoFileIsRefusedAtOnce) {
  ASSERT_EQ(mkfifo(At("pipe").c_str(), 0600), 0);
  EXPECT_EQ(ReadFile(At("pipe")).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ReadFile(folder_).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ReadFile(At("none")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(*ReadFile("/proc/self/status"), HasSubstr("VmPeak"));  // st_size is 0
}

TEST_F(AtomicFile, MoreThanTheMaximumOrTheMemoryIsAnError) {
  std::ofstream(At("a")) << "12345";
  EXPECT_EQ(*ReadFile(At("a"), 5), "12345");
  EXPECT_EQ(ReadFile(At("a"), 4).status().code(), absl::StatusCode::kFailedPrecondition);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's allocator ends the process where memory runs out";
#endif
  fs::resize_file(At("a"), std::uintmax_t{1} << 42);  // sparse: four terabytes of zeros
  const rlimit limit{rlim_t{1} << 40, rlim_t{1} << 40};
  EXPECT_EXIT(
      {
        setrlimit(RLIMIT_AS, &limit);
        _exit(absl::IsResourceExhausted(ReadFile(At("a")).status()) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST_F(AtomicFile, WhatKilledWritersLeftIsToldFromWhatIsBeingWritten) {
  EXPECT_EQ(NameOfTemporary("a.npz.abcdef.egosieve.tmp"), "a.npz");
  EXPECT_EQ(NameOfTemporary("a.mp4.abcdef.egosieve.tmp.mp4"), "a.mp4");
  for (const char* name : {"a.tmp", ".egosieve.tmp", ".abcdef.egosieve.tmp", "a.abcdef.egosieve.tm",
                           "a-abcdef.egosieve.tmp", "a.abcde1.egosieve.tmp",
                           "a.abcdef.egosieve.tmpx", "a.abcdef.tmp"}) {
    EXPECT_EQ(NameOfTemporary(name), "") << name;
  }
  for (const char* name : {"a.abcdef.egosieve.tmp", "b.ABCDEF.egosieve.tmp", "a.abcdef.tmp",
                           "film.Urlaub.tmp.mp4", "a.tmp", "a"}) {
    std::ofstream(At(name)) << "x";
  }
  RemoveAbandonedTemporaries(folder_);
  EXPECT_THAT(*ListFolder(folder_),
              ElementsAre("a", "a.abcdef.tmp", "a.tmp", "film.Urlaub.tmp.mp4"));

  // Written all the while: none is taken away from its writer.
  const pid_t writer = fork();
  if (writer == 0) {
    for (int i = 0; i < 300; ++i) {
      if (!WriteFileAtomically(At("busy"), std::string(100, 'x')).ok()) _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  while (waitpid(writer, &status, WNOHANG) == 0) RemoveAbandonedTemporaries(folder_);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace egosieve::kernels
