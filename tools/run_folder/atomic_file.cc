#include "tools/run_folder/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

absl::Status WriteError(const std::string& path, int error) {
  const std::string what = absl::StrCat("cannot write ", path, ": ", std::strerror(error), "; ");
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return absl::ResourceExhaustedError(absl::StrCat(what, "make room for it"));
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(absl::StrCat(what, "choose a folder that you may write"));
    default:
      return absl::UnavailableError(absl::StrCat(what, "choose another folder"));
  }
}

absl::Status WriteAll(int descriptor, absl::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return WriteError(path, errno);
    }
    bytes.remove_prefix(written);
  }
  return absl::OkStatus();
}

std::string FolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

absl::Status SyncFolder(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) {
    return WriteError(folder, errno);
  }
  const int result = fsync(descriptor);
  const int error = errno;
  close(descriptor);
  // Some file systems do not sync folders; their rename is as durable as they make it.
  return result == 0 || error == EINVAL ? absl::OkStatus() : WriteError(folder, error);
}

absl::Status WriteAndSync(const std::string& temporary, absl::string_view bytes,
                          const std::string& path) {
  const int descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return WriteError(path, errno);
  }
  absl::Status status = WriteAll(descriptor, bytes, path);
  if (status.ok() && fsync(descriptor) != 0) {
    status = WriteError(path, errno);
  }
  if (close(descriptor) != 0 && status.ok()) {
    status = WriteError(path, errno);
  }
  return status;
}

}  // namespace

absl::Status WriteFileAtomically(const std::string& path, absl::string_view bytes) {
  const std::string temporary = absl::StrCat(path, ".tmp");
  absl::Status status = WriteAndSync(temporary, bytes, path);
  if (status.ok() && rename(temporary.c_str(), path.c_str()) != 0) {
    status = WriteError(path, errno);
  }
  if (!status.ok()) {
    unlink(temporary.c_str());
    return status;
  }
  return SyncFolder(FolderOf(path));
}

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) {
    const bool exists = std::filesystem::exists(path);
    return exists ? absl::PermissionDeniedError(absl::StrCat(
                        "cannot read ", path, "; check that it is a file that you may read"))
                  : absl::NotFoundError(absl::StrCat("no file ", path, "; check the path"));
  }
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

absl::Status CreateFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    return WriteError(path, error.value());
  }
  return absl::OkStatus();
}

absl::StatusOr<LineLog> LineLog::OpenWithSize(const std::string& path, int64_t size) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return WriteError(path, errno);
  }
  LineLog log(path, descriptor, size);
  if (ftruncate(descriptor, size) != 0 || fsync(descriptor) != 0) {
    return WriteError(path, errno);
  }
  EGOSIEVE_RETURN_IF_ERROR(SyncFolder(FolderOf(path)));
  return log;
}

absl::StatusOr<LineLog> LineLog::Open(const std::string& path) {
  int64_t size = 0;
  if (std::filesystem::exists(path)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
    const size_t last = text.rfind('\n');
    size = last == std::string::npos ? 0 : static_cast<int64_t>(last) + 1;
  }
  return OpenWithSize(path, size);
}

absl::StatusOr<LineLog> LineLog::OpenTruncated(const std::string& path, int64_t lines) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  size_t size = 0;
  for (int64_t line = 0; line < lines; ++line) {
    const size_t end = text.find('\n', size);
    if (end == std::string::npos) {
      return absl::DataLossError(
          absl::StrCat(path, " has ", line, " lines where ", lines, " are needed"));
    }
    size = end + 1;
  }
  return OpenWithSize(path, static_cast<int64_t>(size));
}

LineLog::LineLog(LineLog&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

LineLog& LineLog::operator=(LineLog&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

LineLog::~LineLog() {
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

absl::Status LineLog::Append(absl::string_view line) {
  const std::string bytes = absl::StrCat(line, "\n");
  absl::Status status = WriteAll(descriptor_, bytes, path_);
  if (status.ok() && fsync(descriptor_) != 0) {
    status = WriteError(path_, errno);
  }
  if (!status.ok()) {
    // What a failed write left of the line; a file that cannot even shrink is cut by the next Open.
    [[maybe_unused]] const int ignored = ftruncate(descriptor_, size_);
    return status;
  }
  size_ += static_cast<int64_t>(bytes.size());
  return absl::OkStatus();
}

}  // namespace egosieve::tools
