#include "tools/run_folder/line_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::tools {

using kernels::ReadFile;
using kernels::WriteError;

absl::StatusOr<LineLog> LineLog::OpenWithSize(const std::string& path, int64_t size) {
  const int descriptor =
      open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return WriteError(path, errno);
  }
  LineLog log(path, descriptor, size);
  if (ftruncate(descriptor, size) != 0 || fsync(descriptor) != 0) {
    return WriteError(path, errno);
  }
  EGOSIEVE_RETURN_IF_ERROR(kernels::SyncFolderOf(path));
  return log;
}

absl::StatusOr<LineLog> LineLog::Open(const std::string& path) {
  int64_t size = 0;
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (text.ok()) {
    const size_t last = text->rfind('\n');
    size = last == std::string::npos ? 0 : static_cast<int64_t>(last) + 1;
  } else if (!absl::IsNotFound(text.status())) {
    return text.status();
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
  absl::Status status = kernels::WriteAll(descriptor_, bytes, path_);
  if (status.ok() && fsync(descriptor_) != 0) {
    status = WriteError(path_, errno);
  }
  if (!status.ok()) {
    // Cuts off the rest of a failed write; if that fails, too, the next Open does it.
    [[maybe_unused]] const int ignored = ftruncate(descriptor_, size_);
    return status;
  }
  size_ += static_cast<int64_t>(bytes.size());
  return absl::OkStatus();
}

}  // namespace egosieve::tools
