// The lock that keeps a second process out of a stage folder.
#pragma once

#include <filesystem>

namespace tetrec {

inline constexpr const char* kLockFile = ".lock";

// Held during its lifetime; the lock of a killed process is released. Throws EnvironmentError if
// another process holds it (naming its pid) or the folder cannot be written, and UsageError if the
// lock is a link.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int fd_ = -1;
};

// True if a process that runs holds the lock. False where there is none, or it cannot be read.
bool IsLocked(const std::filesystem::path& folder);

}  // namespace tetrec
