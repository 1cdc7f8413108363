// glowworm-reader: reads pictures by OpenImageIO and giflib, which may crash on damaged or malicious files, so this is
// a separate process with limits. It serves the requests of image/reader_messages.h until its parent closes the socket.
// usage: glowworm-reader, with the socket as descriptor kChildDescriptor
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "core/confine.h"
#include "image/reader/gif_reader.h"
#include "image/reader/openimageio_reader.h"
#include "image/reader_messages.h"

namespace glowworm {
namespace {

/// Address space that this process takes, bytes.
std::uint64_t own_bytes() {
  unsigned long pages = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "r");  // proc(5): the first number
  if (!file || std::fscanf(file, "%lu", &pages) != 1) end_child(ChildExit::misused);
  std::fclose(file);
  return std::uint64_t{pages} * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// Waits for a request; returns its descriptor, or -1. Ends the process if the parent has ended.
int receive(ReaderRequest& request) {
  iovec data{&request, sizeof request};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t got = recvmsg(kChildDescriptor, &message, MSG_WAITALL | MSG_CMSG_CLOEXEC);
  if (got <= 0) end_child(ChildExit{0});
  if (got != sizeof request) end_child(ChildExit::misused);
  int descriptor = -1;
  if (const cmsghdr* header = CMSG_FIRSTHDR(&message)) std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
  return descriptor;
}

class Server {
 public:
  void serve() {
    const std::uint64_t own = own_bytes();
    for (;;) {
      ReaderRequest request;
      const int descriptor = receive(request);
      if (request.kind == ReaderRequest::Kind::close) {
        reader_.reset();
        continue;
      }
      limit_child(own + mapped_bytes_ + request.memory_bytes, request.cpu_seconds);
      ReaderAnswer answer;
      try {
        if (request.kind == ReaderRequest::Kind::open)
          open(request, descriptor, answer);
        else
          read(request, descriptor, answer);
      } catch (const std::bad_alloc&) {
        end_child(ChildExit::out_of_memory);
      } catch (const std::exception& error) {
        answer = {};
        answer.message = error.what();
      }
      ::close(descriptor);
      // The parent names the file.
      if (const std::size_t at = answer.message.find(path_); at != std::string::npos)
        answer.message.replace(at, path_.size(), "the file");
      const std::string bytes = encode_answer(answer);
      const auto size = static_cast<std::uint32_t>(bytes.size());
      send_to_parent(&size, sizeof size);
      send_to_parent(bytes.data(), bytes.size());
    }
  }

 private:
  void open(const ReaderRequest& request, int descriptor, ReaderAnswer& answer) {
    path_ = "/proc/self/fd/" + std::to_string(descriptor);
    const std::string plugin = request.plugin;
    reader_ =
        plugin == "gif" ? open_gif(path_.c_str(), answer.message) : open_by_openimageio(path_, plugin, answer.message);
    if (!reader_) return;
    answer.done = true;
    answer.header = reader_->header();
    answer.depth = reader_->depth();
    answer.tile_height = reader_->tile_height();
    answer.unpacks_whole = reader_->unpacks_whole();
  }

  void read(const ReaderRequest& request, int descriptor, ReaderAnswer& answer) {
    // The descriptor always names the same memory.
    if (request.bytes > mapped_bytes_) {
      if (samples_) munmap(samples_, mapped_bytes_);
      samples_ = mmap(nullptr, request.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
      if (samples_ == MAP_FAILED) end_child(ChildExit::out_of_memory);
      mapped_bytes_ = request.bytes;
    }
    answer.done = reader_->read_rows(request.first, request.last, request.type, samples_);
    answer.message = reader_->report();
  }

  void* samples_ = nullptr;  // shared with the parent
  std::uint64_t mapped_bytes_ = 0;
  std::string path_ = "/proc/self/fd/";  // of the open picture
  std::unique_ptr<ImageReader> reader_;
};

}  // namespace
}  // namespace glowworm

int main() {
  glowworm::confine();
  glowworm::Server().serve();
}
