#include "core/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/descriptor.h"
#include "core/error.h"

namespace glowworm {

namespace {

/// Throws Error if the file is not a regular file.
void check_kind(const struct stat& status, const std::string& path) {
  if (S_ISDIR(status.st_mode)) throw Error({path}, "is a folder, not a file", "Give the name of a file.");
  if (!S_ISREG(status.st_mode))
    throw Error({path}, "is not a regular file", "Pipes and devices cannot be read: give the name of a file.");
}

thread_local InputRecord* innermost = nullptr;

}  // namespace

InputRecord::InputRecord() : outer_(innermost) { innermost = this; }
InputRecord::~InputRecord() { innermost = outer_; }

void record_input_file(const std::string& path) {
  for (InputRecord* record = innermost; record; record = record->outer_) record->names_.insert(path);
}

bool is_outside(const std::string& file, const std::string& named_by) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path real = fs::weakly_canonical(fs::absolute(file, error), error);
  if (error) return true;
  // A symbolic link to a scene file names two folders. Both are its own.
  const fs::path given = fs::absolute(named_by, error);
  for (const fs::path& folder :
       {fs::weakly_canonical(given.parent_path(), error), fs::weakly_canonical(given, error).parent_path()}) {
    const auto [end_of_folder, rest] = std::mismatch(folder.begin(), folder.end(), real.begin(), real.end());
    if (end_of_folder == folder.end() && rest != real.end()) return false;
  }
  return true;
}

void check_input_file(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) throw Error({path}, "no such file", "Check the name and the path.");
    throw Error({path}, "cannot be opened", "Check that you may read it.");
  }
  check_kind(status, path);
  // A file in memory has no name that lasts.
  if (status.st_nlink > 0) record_input_file(path);
}

namespace {

/// @param held null: nothing is reserved
template <typename Bytes>
Bytes read_whole(const std::string& path, Reservation* held) {
  check_input_file(path);
  // Non-blocking: the name may have become a FIFO since it was checked.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status {};
  if (file.number() < 0 || fstat(file.number(), &status) != 0)
    throw Error({path}, "cannot be opened", "Check that you may read it.");
  check_kind(status, path);
  if (static_cast<std::uint64_t>(status.st_size) > physical_memory_bytes())
    throw Error({path}, "is larger than the machine's memory", "Simplify the scene, or split the file.");
  if (held) held->grow(static_cast<std::uint64_t>(status.st_size));
  Bytes bytes;
  bytes.resize(static_cast<std::size_t>(status.st_size));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = read(file.number(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Error({path}, "reading stopped half-way", "Check the disk the file is on.");
    filled += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace

std::string read_input_file(const std::string& path) { return read_whole<std::string>(path, nullptr); }

std::string read_input_file(const std::string& path, Reservation& held) { return read_whole<std::string>(path, &held); }

std::vector<std::uint8_t> read_input_bytes(const std::string& path, Reservation& held) {
  return read_whole<std::vector<std::uint8_t>>(path, &held);
}

}  // namespace glowworm
