#include "core/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <limits.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/disk_memory.h"

namespace glowworm {

namespace {

std::string remedy_for(int error_number, const std::string& given) {
  std::error_code ignored;
  const std::string folder = given == "." ? std::filesystem::current_path(ignored).string() : given;
  switch (error_number) {
    case ENOENT:
    case ENOTDIR:
      return fmt::format("Create the folder \"{}\" or choose another output path.", folder);
    case EACCES:
    case EPERM:
    case EROFS:
      return fmt::format("Make \"{}\" writable for this user or choose another output path.", folder);
    case ENOSPC:
    case EDQUOT:
      return fmt::format("Free space on the disk that holds \"{}\" or choose another output path.", folder);
    case EFBIG:
      return "Raise the file size limit (ulimit -f) or choose a smaller image.";
    case ENAMETOOLONG:
      return "Choose a shorter path.";
    case ENXIO:
    case ETIMEDOUT:
      return "Start the program that reads the pipe first, let it read all, or choose another output path.";
    case ELOOP:
      return "Fix the symbolic links, which form a circle, or choose another output path.";
    default:
      return "Choose another output path.";
  }
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

// Whether another name or other permissions could fix the error. All other errors come from the disk.
bool is_mistake(int error_number) {
  switch (error_number) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case EACCES:
    case EPERM:
    case EROFS:
    case ENAMETOOLONG:
    case ELOOP:
    case ETXTBSY:
      return true;
    default:
      return false;
  }
}

// The target of `path` after following symbolic links, whether or not a file exists there. Empty, with errno ELOOP, if
// the links form a circle.
std::string follow_links(std::string path) {
  // Linux follows at most 40 links, too.
  for (int links = 0; links < 40; ++links) {
    char text[PATH_MAX];
    const ssize_t length = readlink(path.c_str(), text, sizeof text);
    if (length < 0) return path;
    const std::string_view next(text, static_cast<std::size_t>(length));
    path = next.starts_with('/') ? std::string(next) : fmt::format("{}/{}", folder_of(path), next);
  }
  errno = ELOOP;
  return {};
}

// Waits until a pipe or a device can take more bytes. Returns false with errno set if it cannot within ten seconds.
bool wait_for_reader(int descriptor) {
  pollfd wanted{descriptor, POLLOUT, 0};
  const int ready = poll(&wanted, 1, 10'000);
  if (ready == 0) errno = ETIMEDOUT;
  return ready > 0 || (ready < 0 && errno == EINTR);
}

// A name in the target's own folder, because a rename cannot cross file systems. Differs for every process and call.
std::string temporary_name(const std::string& target) {
  static std::atomic<std::uint32_t> calls{0};
  const auto now = static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  const std::size_t slash = target.rfind('/');
  const std::size_t start = slash == std::string::npos ? 0 : slash + 1;
  // Truncated, so that the temporary name fits even if the target's name has the maximum length.
  const std::string name = target.substr(start, 200);
  return fmt::format("{}.{}.{:x}-{:x}-{:x}.tmp", target.substr(0, start), name, getpid(), now & 0xffffffffu, calls++);
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path), target_(follow_links(path)) {
  if (path.empty()) throw Error("the output path is empty", "Give a file name.");
  if (path == kStandardOutput) {
    path_ = "standard output";
    descriptor_ = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) fail("cannot write", errno);
    return;
  }
  if (target_.empty()) fail("cannot write", errno);
  struct stat info {};
  const bool exists = stat(path.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) fail("the output path is a folder", EISDIR);
  if (exists && !S_ISREG(info.st_mode)) {
    // Non-blocking: a FIFO without a reader, or with a stalled reader, must not hold up all other output files.
    descriptor_ = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor_ < 0) fail(errno == ENXIO ? "nothing reads from this pipe" : "cannot write", errno);
    return;
  }
  if (exists && access(path.c_str(), W_OK) != 0) fail("the existing file cannot be overwritten", errno);
  temporary_ = temporary_name(target_);
  registered_ = std::make_unique<TemporaryName>(temporary_);
  descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot create the file", errno);
  if (exists && fchmod(descriptor_, info.st_mode & 0777) != 0) fail("cannot keep the old file's mode", errno);
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() noexcept {
  if (descriptor_ < 0) return;
  close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) unlink(temporary_.c_str());
  registered_.reset();
}

void AtomicFile::fail(const std::string& what, int error_number) {
  discard();
  registered_.reset();
  const std::string message = fmt::format("{}: {}", what, std::strerror(error_number));
  const std::string remedy = remedy_for(error_number, folder_of(target_.empty() ? path_ : target_));
  if (is_mistake(error_number)) throw Error({path_}, message, remedy);
  throw DiskError({path_}, message, remedy);
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  if (descriptor_ < 0) throw Error({path_}, "nothing can be written after the file was closed");
  const char* next = static_cast<const char*>(data);
  while (bytes > 0) {
    // Little at a time: what is written may be an array on disk.
    check_disk_memory();
    const ssize_t written = ::write(descriptor_, next, std::min<std::size_t>(bytes, std::size_t{1} << 20));
    if (written < 0) {
      if (errno == EINTR || (errno == EAGAIN && wait_for_reader(descriptor_))) continue;
      fail("cannot write", errno);
    }
    next += written;
    bytes -= static_cast<std::size_t>(written);
  }
}

void AtomicFile::commit() {
  if (descriptor_ < 0) throw Error({path_}, "the file was closed already");
  const bool direct = temporary_.empty();
  if (!direct && fsync(descriptor_) != 0) fail("cannot write to the disk", errno);
  const int closed = close(descriptor_);
  const int close_error = errno;
  descriptor_ = -1;
  if (direct) {
    if (closed != 0) fail("cannot write", close_error);
    return;
  }
  if (closed != 0 || rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int error_number = closed != 0 ? close_error : errno;
    unlink(temporary_.c_str());
    fail("cannot give the finished file its name", error_number);
  }
  registered_.reset();
  // The rename is durable only after the folder is flushed, too. If the file system cannot do that, the rename has
  // still happened.
  const int folder = open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    fsync(folder);
    close(folder);
  }
}

void write_file(const std::string& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

std::string output_identity(const std::string& path) {
  if (path == kStandardOutput) return path;
  struct stat info {};
  if (stat(path.c_str(), &info) == 0)
    return S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode) ? "" : fmt::format("{}:{}", info.st_dev, info.st_ino);
  const std::string end = follow_links(path);
  std::error_code error;
  const std::filesystem::path folder =
      std::filesystem::weakly_canonical(std::filesystem::absolute(folder_of(end)), error);
  return error ? path : (folder / end.substr(end.rfind('/') + 1)).string();
}

}  // namespace glowworm
