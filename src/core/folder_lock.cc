// The lock is an flock on a file that contains the process id of its holder.
#include "core/folder_lock.h"

#include "core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

struct stat StatusOf(int fd) {
  struct stat status {};
  if (fstat(fd, &status) != 0) status = {};
  return status;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path path = folder / kLockFile;
  fd_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  if (fd_ < 0 && errno != ELOOP) {
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({})", folder.string(), std::strerror(errno)));
  }
  const struct stat status = StatusOf(fd_);
  if (!S_ISREG(status.st_mode)) {
    if (fd_ >= 0) close(fd_);
    throw UsageError(fmt::format("{}: is a link or a device; remove it or choose another folder",
                                 path.string()));
  }
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    char pid[32] = {};
    [[maybe_unused]] const ssize_t n = read(fd_, pid, sizeof(pid) - 1);
    close(fd_);
    throw EnvironmentError(
        fmt::format("{} is in use by another process (pid {}); wait for it or stop it",
                    folder.string(), std::string(pid, std::strcspn(pid, "\n"))));
  }
  if (status.st_nlink > 1) return;  // its other name may be that of a file outside of the folder
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(fd_, 0) != 0 || write(fd_, pid.data(), pid.size()) != ssize_t(pid.size())) {
    const int error = errno;
    close(fd_);
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({}); free some space or choose another folder",
                    path.string(), std::strerror(error)));
  }
}

FolderLock::~FolderLock() { close(fd_); }

bool IsLocked(const fs::path& folder) {
  const int fd = open((folder / kLockFile).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return false;
  const bool is_locked =
      S_ISREG(StatusOf(fd).st_mode) && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(fd);
  return is_locked;
}

}  // namespace tetrec
