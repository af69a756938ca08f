#include "kernels/files/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;

constexpr char kSuffix[] = ".egosieve.tmp";
constexpr size_t kRandomLetters = 6;
constexpr char kLetters[] = "abcdefghijklmnopqrstuvwxyzABCDEF";
constexpr size_t kPartBytes = size_t{1} << 20;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

absl::Status ReadError(const std::string& path, int error) {
  const std::string what = absl::StrCat("cannot read ", path, ": ", std::strerror(error), "; ");
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return absl::NotFoundError(absl::StrCat(what, "check the path"));
    case EACCES:
    case EPERM:
      return absl::PermissionDeniedError(absl::StrCat(what, "check who may read it"));
    default:
      return absl::UnavailableError(absl::StrCat(what, "check the disk"));
  }
}

absl::Status CheckReplaceable(const std::string& path) {
  struct stat status;
  if (lstat(path.c_str(), &status) != 0) {
    return errno == ENOENT || errno == ENOTDIR ? absl::OkStatus() : WriteError(path, errno);
  }
  EGOSIEVE_REQUIRE(FailedPrecondition, S_ISREG(status.st_mode),
                   "%s is %s and is not replaced; choose another path", path,
                   S_ISLNK(status.st_mode) ? "a symbolic link" : "no regular file");
  return absl::OkStatus();
}

absl::StatusOr<std::string> TemporaryName(const std::string& path, const std::string& extension) {
  unsigned char random[kRandomLetters];
  if (getrandom(random, sizeof random, 0) != static_cast<ssize_t>(sizeof random)) {
    return WriteError(path, errno);
  }
  std::string name = absl::StrCat(path, ".");
  for (const unsigned char byte : random) name += kLetters[byte % 32];
  return absl::StrCat(name, kSuffix, extension);
}

absl::Status TooLarge(const std::string& path, int64_t bytes, int64_t maximum_bytes) {
  return absl::FailedPreconditionError(
      absl::StrCat(path, " has ", bytes, " bytes or more; at most ", maximum_bytes, " are read"));
}

// Reads to the end, which may lie beyond st_size: files in /proc have none, and a log may grow.
absl::StatusOr<std::string> ReadToEnd(int descriptor, const std::string& path, int64_t expected,
                                      int64_t maximum_bytes) {
  std::string bytes;
  size_t size = 0;
  while (true) {
    if (static_cast<int64_t>(size) > maximum_bytes) return TooLarge(path, size, maximum_bytes);
    if (size == bytes.size()) {
      bytes.resize(
          std::max(size + (size == 0 ? 1 : kPartBytes), static_cast<size_t>(expected) + 1));
    }
    const ssize_t count = read(descriptor, bytes.data() + size, bytes.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ReadError(path, errno);
    if (count == 0) break;
    size += static_cast<size_t>(count);
  }
  bytes.resize(size);
  return bytes;
}

std::string FolderOf(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  return parent.empty() ? "." : parent.string();
}

Descriptor OpenFolder(const std::string& folder) {
  return Descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
}

absl::Status SyncFolder(const Descriptor& descriptor, const std::string& folder) {
  // Some file systems do not sync folders; the durability of their renames is their own.
  return fsync(descriptor.get()) == 0 || errno == EINVAL ? absl::OkStatus()
                                                         : WriteError(folder, errno);
}

}  // namespace

absl::Status WriteError(const std::string& path, int error) {
  const std::string what = absl::StrCat("cannot write ", path, ": ", std::strerror(error), "; ");
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return absl::ResourceExhaustedError(absl::StrCat(what, "free some space"));
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(absl::StrCat(what, "choose a folder that you may write"));
    default:
      return absl::UnavailableError(absl::StrCat(what, "choose another folder"));
  }
}

absl::Status WriteAll(int descriptor, std::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return WriteError(path, errno);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status SyncFolderOf(const std::string& path) {
  const std::string folder = FolderOf(path);
  const Descriptor descriptor = OpenFolder(folder);
  return descriptor.get() < 0 ? WriteError(folder, errno) : SyncFolder(descriptor, folder);
}

absl::StatusOr<TemporaryFile> TemporaryFile::Create(const std::string& path,
                                                    const std::string& extension) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplaceable(path));
  while (true) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string name, TemporaryName(path, extension));
    const int descriptor =
        open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno == EEXIST) continue;
    EGOSIEVE_REQUIRE(NotFound, descriptor >= 0 || (errno != ENOENT && errno != ENOTDIR),
                     "cannot write %s: there is no such folder; check the path", path);
    if (descriptor < 0) return WriteError(path, errno);
    TemporaryFile file(path, name, descriptor);
    // RemoveAbandonedTemporaries may run between the file's creation and its lock; then another
    // file is made.
    const bool taken = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    struct stat status;
    if (fstat(descriptor, &status) != 0) return WriteError(path, errno);
    if (!taken && status.st_nlink > 0) return file;
  }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : path_(std::move(other.path_)),
      name_(std::exchange(other.name_, "")),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(name_, other.name_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

TemporaryFile::~TemporaryFile() {
  if (!name_.empty()) unlink(name_.c_str());
  if (descriptor_ >= 0) close(descriptor_);
}

absl::Status TemporaryFile::Commit() {
  // Opened before the rename, so that a folder without read permission leaves the old file.
  const std::string folder = FolderOf(path_);
  const Descriptor descriptor = OpenFolder(folder);
  if (descriptor.get() < 0) return WriteError(folder, errno);
  if (fsync(descriptor_) != 0 || rename(name_.c_str(), path_.c_str()) != 0) {
    return WriteError(path_, errno);
  }
  name_.clear();
  return SyncFolder(descriptor, folder);
}

absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes) {
  EGOSIEVE_ASSIGN_OR_RETURN(TemporaryFile file, TemporaryFile::Create(path));
  EGOSIEVE_RETURN_IF_ERROR(WriteAll(file.descriptor(), bytes, path));
  return file.Commit();
}

absl::StatusOr<std::string> ReadFile(const std::string& path, int64_t maximum_bytes) {
  // Non-blocking, so that a pipe without a writer is refused below instead of waited for.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return ReadError(path, errno);
  struct stat status;
  if (fstat(file.get(), &status) != 0) return ReadError(path, errno);
  EGOSIEVE_REQUIRE(FailedPrecondition, S_ISREG(status.st_mode),
                   "%s is not a regular file; give one that is", path);
  if (status.st_size > maximum_bytes) return TooLarge(path, status.st_size, maximum_bytes);
  try {
    return ReadToEnd(file.get(), path, status.st_size, maximum_bytes);
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {
  }
  return absl::ResourceExhaustedError(
      absl::StrCat("no memory for the ", status.st_size, " bytes of ", path, "; free some memory"));
}

absl::Status CreateFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  return error ? WriteError(path, error.value()) : absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& path) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  if (error) return ReadError(path, error.value());
  std::sort(names.begin(), names.end());
  return names;
}

std::string_view NameOfTemporary(std::string_view name) {
  const size_t suffix = name.rfind(kSuffix);
  if (suffix == std::string_view::npos || suffix < kRandomLetters + 2) return "";
  const std::string_view extension = name.substr(suffix + sizeof kSuffix - 1);
  if (!extension.empty() && extension.front() != '.') return "";
  const size_t dot = suffix - kRandomLetters - 1;
  const bool is_ours =
      name[dot] == '.' &&
      name.substr(dot + 1, kRandomLetters).find_first_not_of(kLetters) == std::string_view::npos;
  return is_ours ? name.substr(0, dot) : "";
}

void RemoveAbandonedTemporaries(const std::string& folder) {
  const absl::StatusOr<std::vector<std::string>> names = ListFolder(folder);
  if (!names.ok()) return;
  for (const std::string& name : *names) {
    if (NameOfTemporary(name).empty()) continue;
    const std::string path = absl::StrCat(folder, "/", name);
    // For writing: NFS grants no exclusive lock to others.
    const Descriptor file(open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (file.get() >= 0 && flock(file.get(), LOCK_EX | LOCK_NB) == 0) unlink(path.c_str());
  }
}

}  // namespace egosieve::kernels
