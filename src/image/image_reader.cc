#include "image/image_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <string.h>  // strerror
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "core/archive.h"
#include "core/child_process.h"
#include "core/confine.h"
#include "core/memory_budget.h"
#include "image/reader_messages.h"

namespace glowworm {

namespace {

constexpr const char* kProgram = "glowworm-reader";
constexpr std::uint64_t kMostAnswer = std::uint64_t{64} << 20;  // bytes; metadata of pictures is smaller
// What any picture may take beside its pixels: buffers of OpenImageIO and its libraries, bytes. Sparing, as memory that
// is not touched counts, too.
constexpr std::uint64_t kBuffers = std::uint64_t{256} << 20;
constexpr unsigned kCpuSeconds = 60, kClockPerCpu = 10;  // machines are shared

/// Throws Error that the system refuses what it should give.
void check_system(bool works, const char* what) {
  if (!works)
    throw Error(fmt::format("the system gives no {} for {}: {}", what, kProgram, strerror(errno)),
                "Close other programs.");
}

/// A process of the program and the channels to it.
class ReaderProcess {
 public:
  ReaderProcess() {
    int ends[2];
    check_system(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0, "socket");
    socket_ = Descriptor(ends[0]);
    const Descriptor other(ends[1]);
    memory_ = Descriptor(memfd_create("pictures", MFD_CLOEXEC));
    check_system(memory_.number() >= 0, "shared memory");
    try {
      // image/reader/openimageio_reader.cc says why.
      child_.emplace(program_, std::vector<std::string>(), other, "GLIBC_TUNABLES=glibc.malloc.tcache_count=0");
    } catch (const Error& error) {
      throw MissingReader(error.what());
    }
  }

  /// Whether it waits for a request.
  bool is_ready() { return !busy_ && !child_->has_ended(); }

  /// Sends a request; returns the answer, unless it has none. Throws Error about `path` if there should be one.
  ReaderAnswer ask(const std::string& path, ReaderRequest request, const Descriptor& file) try {
    const bool answered = request.kind != ReaderRequest::Kind::close;
    busy_ = true;
    limits_ = {request.memory_bytes, request.cpu_seconds, kClockPerCpu * request.cpu_seconds};
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(limits_.clock_seconds);
    if (!send_request(request, file)) fail(path);
    ReaderAnswer answer;
    if (answered) {
      std::uint32_t size = 0;
      receive(path, &size, sizeof size, end);
      if (size > kMostAnswer) fail_transfer("it is too long");
      std::string bytes(size, '\0');
      receive(path, bytes.data(), size, end);
      answer = decode_answer(bytes);
    }
    busy_ = false;
    return answer;
  } catch (const InvalidArchive& invalid) {
    fail(path, fmt::format("gave an invalid answer: {}", invalid.what()));
  }

  /// Memory that both processes see. Throws MemoryError if it cannot have `bytes` bytes.
  const Descriptor& memory(std::uint64_t bytes) {
    if (bytes > memory_bytes_) check_system(ftruncate(memory_.number(), static_cast<off_t>(bytes)) == 0, "memory");
    memory_bytes_ = std::max(memory_bytes_, bytes);
    return memory_;
  }

  /// Copies from the beginning of the shared memory.
  void take(void* to, std::uint64_t bytes) const {
    std::uint64_t at = 0;
    while (at < bytes) {
      const ssize_t got = pread(memory_.number(), static_cast<char*>(to) + at, bytes - at, static_cast<off_t>(at));
      if (got < 0 && errno == EINTR) continue;
      check_system(got > 0, "shared memory");
      at += static_cast<std::uint64_t>(got);
    }
  }

  /// Closes its picture and gives shared memory back to the system.
  void close_picture(const std::string& path) {
    ask(path, {}, Descriptor());
    if (memory_bytes_ > kKeptBytes) memory_bytes_ = ftruncate(memory_.number(), 0) == 0 ? 0 : memory_bytes_;
  }

 private:
  static constexpr std::uint64_t kKeptBytes = std::uint64_t{4} << 20;

  bool send_request(const ReaderRequest& request, const Descriptor& file) const {
    iovec data{const_cast<ReaderRequest*>(&request), sizeof request};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    if (const int number = file.number(); number >= 0) {
      message.msg_control = control;
      message.msg_controllen = sizeof control;
      cmsghdr* header = CMSG_FIRSTHDR(&message);
      header->cmsg_level = SOL_SOCKET;
      header->cmsg_type = SCM_RIGHTS;
      header->cmsg_len = CMSG_LEN(sizeof number);
      memcpy(CMSG_DATA(header), &number, sizeof number);
    }
    ssize_t sent = 0;
    do sent = sendmsg(socket_.number(), &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == sizeof request;
  }

  void receive(const std::string& path, void* to, std::size_t bytes, std::chrono::steady_clock::time_point end) {
    char* at = static_cast<char*>(to);
    while (bytes > 0) {
      if (!wait_to_read(socket_, end))
        fail(path, fmt::format("did not end within {} s, its limit", limits_.clock_seconds));
      const ssize_t got = recv(socket_.number(), at, bytes, MSG_DONTWAIT);
      if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (got <= 0) fail(path);
      at += got;
      bytes -= static_cast<std::size_t>(got);
    }
  }

  [[noreturn]] static void fail(const std::string& path, const std::string& what) {
    throw Error({path}, fmt::format("{}, which reads pictures, {}", kProgram, what), "Save or copy the file again.");
  }

  /// Says how the process ended, which it is about to do or has done.
  [[noreturn]] void fail(const std::string& path) {
    const int status = child_->end();
    constexpr int kNotLoaded = 127;  // of the dynamic linker
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotLoaded)
      throw MissingReader(fmt::format("{} does not find its libraries", program_),
                          "Install Debian's libopenimageio2.4.");
    fail(path, describe_failure(status, program_, limits_));
  }

  const std::string program_ = find_companion(kProgram);
  Descriptor socket_, memory_;
  std::optional<ChildProcess> child_;
  ChildLimits limits_;
  std::uint64_t memory_bytes_ = 0;
  bool busy_ = false;  // between a request and the end of its answer
};

/// Processes that serve no file.
class IdleProcesses {
 public:
  std::unique_ptr<ReaderProcess> take() {
    const std::lock_guard lock(mutex_);
    // After fork(), the readers still serve the parent process.
    if (std::exchange(owner_, getpid()) != getpid()) idle_.clear();
    while (!idle_.empty()) {
      std::unique_ptr<ReaderProcess> last = std::move(idle_.back());
      idle_.pop_back();
      if (last->is_ready()) return last;
    }
    return std::make_unique<ReaderProcess>();
  }
  void give_back(std::unique_ptr<ReaderProcess> process) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(process));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<ReaderProcess>> idle_;
  pid_t owner_ = getpid();
};

/// Never destroyed: files may be open until the end, and the processes end when they lose their parent.
IdleProcesses& idle_processes() {
  static IdleProcesses& processes = *new IdleProcesses;
  return processes;
}

/// A picture that is open in a process.
class ForeignReader final : public ImageReader {
 public:
  explicit ForeignReader(const std::string& path) : path_(path), process_(idle_processes().take()) {}
  ~ForeignReader() override {
    try {
      if (!process_->is_ready()) return;
      process_->close_picture(path_);
      idle_processes().give_back(std::move(process_));
    } catch (const std::exception&) {  // the process is not used again
    }
  }

  bool open(const ImageFormat& format, std::string& failure) {
    const Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.number() < 0) throw Error({path_}, "cannot be opened", "Check that you may read it.");
    ReaderRequest request;
    request.kind = ReaderRequest::Kind::open;
    std::string_view(format.plugin).copy(request.plugin, sizeof request.plugin - 1);
    std::error_code unknown;
    const std::uint64_t file_bytes = std::filesystem::file_size(path_, unknown);
    const double pixels = format.pixels_per_byte * static_cast<double>(unknown ? 0 : file_bytes);
    const auto most = static_cast<double>(physical_memory_bytes() / 2);
    opening_bytes_ = static_cast<std::uint64_t>(pixels > 0 ? std::min(pixels * kBytesOfPixel, most) : most);
    set_limits(request, 0);
    ReaderAnswer answer = process_->ask(path_, request, file);
    failure = answer.message;
    header_ = std::move(answer.header);
    depth_ = answer.depth;
    tile_height_ = answer.tile_height;
    unpacks_whole_ = answer.unpacks_whole;
    return answer.done;
  }

  bool read_rows(int first, int last, SampleType type, void* samples) override {
    ImageFileHeader asked = header_;
    asked.type = type;
    ReaderRequest request;
    request.kind = ReaderRequest::Kind::rows;
    request.type = type;
    request.first = first;
    request.last = last;
    request.bytes = asked.bytes_of_rows(last - first);
    set_limits(request, request.bytes);
    const ReaderAnswer answer = process_->ask(path_, request, process_->memory(request.bytes));
    report_ = answer.message;
    if (answer.done) process_->take(samples, request.bytes);
    return answer.done;
  }

  std::string report() override { return std::exchange(report_, std::string()); }

 private:
  static constexpr double kBytesOfPixel = 4 * sizeof(float);

  /// The whole picture as floats may be held twice, beside the rows.
  void set_limits(ReaderRequest& request, std::uint64_t bytes) const {
    const std::uint64_t whole = static_cast<std::uint64_t>(header_.width) * static_cast<std::uint64_t>(header_.height) *
                                static_cast<std::uint64_t>(header_.channels) * sizeof(float);
    request.memory_bytes = kBuffers + (bytes > 0 ? 2 * whole + bytes : opening_bytes_);
    request.cpu_seconds = kCpuSeconds + static_cast<std::uint32_t>(bytes >> 20);
  }

  std::string path_;
  std::unique_ptr<ReaderProcess> process_;
  std::uint64_t opening_bytes_ = 0;
  std::string report_;
};

}  // namespace

std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const ImageFormat& format,
                                               std::string& failure) {
  auto reader = std::make_unique<ForeignReader>(path);
  return reader->open(format, failure) ? std::move(reader) : nullptr;
}

}  // namespace glowworm
