#include "image/tev.h"

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr std::uint8_t kCreateImage = 4, kUpdateImage = 6;
constexpr const char* kDefaultPort = "14158";
/// Approximate size of a packet's pixels in bytes: tev shows large pictures as they arrive.
constexpr std::size_t kPacketBytes = std::size_t{1} << 20;
constexpr const char* kRemedy = "Start tev, and give --tev the HOST:PORT it listens on (127.0.0.1:14158).";

static_assert(std::endian::native == std::endian::little, "tev's packets are little-endian");

struct Place {
  std::string host, port;
};

Place parse_address(const std::string& address) {
  Place place{address, kDefaultPort};
  const std::size_t bracket = address.rfind(']'), colon = address.rfind(':');
  if (colon != std::string::npos && (bracket == std::string::npos ? address.find(':') == colon : colon > bracket)) {
    place.host = address.substr(0, colon);
    place.port = address.substr(colon + 1);
  }
  if (place.host.size() > 2 && place.host.front() == '[' && place.host.back() == ']')
    place.host = place.host.substr(1, place.host.size() - 2);
  const bool digits = !place.port.empty() && place.port.find_first_not_of("0123456789") == std::string::npos;
  if (place.host.empty() || !digits || place.port.size() > 5 || std::stoul(place.port) > 65535)
    throw Error(fmt::format("--tev '{}' is not HOST:PORT", address), kRemedy);
  return place;
}

/// Waits until the socket can be written or has failed. Returns false with errno set if neither happens before the
/// deadline.
bool wait_to_write(int descriptor, std::chrono::steady_clock::time_point deadline) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    pollfd wanted{descriptor, POLLOUT, 0};
    const int ready = left > 0 ? poll(&wanted, 1, static_cast<int>(std::min<long long>(left, 60'000))) : 0;
    if (ready > 0) return true;
    if (ready == 0 && left <= 0) errno = ETIMEDOUT;
    if (left <= 0 || (ready < 0 && errno != EINTR)) return false;
  }
}

/// Connects a non-blocking socket. Returns false with errno set on failure.
bool connect_by(int descriptor, const addrinfo& to, std::chrono::steady_clock::time_point deadline) {
  if (connect(descriptor, to.ai_addr, to.ai_addrlen) == 0) return true;
  if (errno != EINPROGRESS || !wait_to_write(descriptor, deadline)) return false;
  socklen_t size = sizeof(errno);
  return getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &errno, &size) == 0 && errno == 0;
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// The result of getaddrinfo(); the list is null if the code is not 0.
struct Lookup {
  int code = 0;
  Addresses list{nullptr, freeaddrinfo};
};

Lookup look_up(const Place& place, int flags) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_NUMERICSERV | flags;
  addrinfo* found = nullptr;
  Lookup lookup;
  lookup.code = getaddrinfo(place.host.c_str(), place.port.c_str(), &wanted, &found);
  if (lookup.code == 0) lookup.list.reset(found);
  return lookup;
}

/// The addresses of a host. Names are looked up in a separate thread, which is abandoned if the name server does not
/// answer, because getaddrinfo() has no time limit. Throws Error if there are none before the deadline.
Addresses find_addresses(const Place& place, const std::string& address,
                         std::chrono::steady_clock::time_point deadline) {
  Lookup lookup = look_up(place, AI_NUMERICHOST);
  if (lookup.code == EAI_NONAME) {
    std::promise<Lookup> answer;
    std::future<Lookup> answered = answer.get_future();
    std::thread([place, answer = std::move(answer)]() mutable { answer.set_value(look_up(place, 0)); }).detach();
    if (answered.wait_until(deadline) != std::future_status::ready)
      throw Error(fmt::format("--tev '{}': no address was found in time", address), kRemedy);
    lookup = answered.get();
  }
  if (lookup.code != 0) throw Error(fmt::format("--tev '{}': {}", address, gai_strerror(lookup.code)), kRemedy);
  return std::move(lookup.list);
}

/// A non-blocking socket connected to one of the addresses; or -1 with errno of the last attempt.
int connect_to(const addrinfo* list, std::chrono::steady_clock::time_point deadline) {
  for (const addrinfo* a = list; a; a = a->ai_next) {
    const int made = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
    if (made < 0) continue;
    if (connect_by(made, *a, deadline)) return made;
    const int why = errno;
    close(made);
    errno = why;
  }
  return -1;
}

void add_bytes(TevPacket& packet, const void* data, std::size_t count) {
  const auto* const bytes = static_cast<const char*>(data);
  packet.insert(packet.end(), bytes, bytes + count);
}

template <typename... Integers>
void add(TevPacket& packet, Integers... values) {
  (add_bytes(packet, &values, sizeof values), ...);
}

void add_text(TevPacket& packet, std::string_view text) {
  // Text must not contain a zero byte.
  add_bytes(packet, text.data(), std::min(text.size(), text.find('\0')));
  add(packet, '\0');
}

void add_names(TevPacket& packet, const Image& image) {
  add(packet, static_cast<std::int32_t>(image.channels().size()));
  for (const ImageChannel& channel : image.channels()) add_text(packet, channel.name);
}

TevPacket begin_packet(std::uint8_t kind, bool takes_focus, std::string_view name) {
  TevPacket packet;
  add(packet, std::uint32_t{0}, kind, std::uint8_t{takes_focus});
  add_text(packet, name);
  return packet;
}

TevPacket with_length(TevPacket packet) {
  const auto length = static_cast<std::uint32_t>(packet.size());
  std::memcpy(packet.data(), &length, sizeof(length));
  return packet;
}

}  // namespace

void check_tev_address(const std::string& address) { parse_address(address); }

TevPacket tev_create_image(std::string_view name, const Image& image) {
  TevPacket packet = begin_packet(kCreateImage, true, name);
  add(packet, static_cast<std::int32_t>(image.width()), static_cast<std::int32_t>(image.height()));
  add_names(packet, image);
  return with_length(std::move(packet));
}

TevPacket tev_update_image(std::string_view name, const Image& image, int first, int last) {
  TevPacket packet = begin_packet(kUpdateImage, false, name);
  add_names(packet, image);
  for (const int number : {0, first, image.width(), last - first}) add(packet, static_cast<std::int32_t>(number));
  const std::int64_t pixels = static_cast<std::int64_t>(image.width()) * (last - first);
  // For each channel: offset of its first sample, and stride.
  for (std::size_t c = 0; c < image.channels().size(); ++c) add(packet, static_cast<std::int64_t>(c) * pixels);
  for (std::size_t c = 0; c < image.channels().size(); ++c) add(packet, std::int64_t{1});
  const auto offset = static_cast<std::size_t>(first) * static_cast<std::size_t>(image.width());
  for (const ImageChannel& channel : image.channels())
    add_bytes(packet, channel.samples.data() + offset, static_cast<std::size_t>(pixels) * sizeof(float));
  return with_length(std::move(packet));
}

TevConnection::TevConnection(const std::string& address, double patience_s)
    : address_(address), patience_s_(patience_s) {
  const Place place = parse_address(address);
  const Clock::time_point end = deadline();
  const Addresses list = find_addresses(place, address, end);
  socket_ = connect_to(list.get(), end);
  if (socket_ < 0) throw Error(fmt::format("--tev '{}': {}", address, std::strerror(errno)), kRemedy);
}

TevConnection::~TevConnection() { close(socket_); }

TevConnection::Clock::time_point TevConnection::deadline() const {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(patience_s_));
}

void TevConnection::send(const TevPacket& packet, Clock::time_point deadline) {
  for (std::size_t sent = 0; sent < packet.size();) {
    const ssize_t count = ::send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
    if (count >= 0) {
      sent += static_cast<std::size_t>(count);
      continue;
    }
    const bool may_go_on = errno == EINTR || (errno == EAGAIN && wait_to_write(socket_, deadline));
    if (!may_go_on)
      throw Error(fmt::format("tev at {} takes no more of the picture: {}", address_, std::strerror(errno)));
  }
}

void TevConnection::show(const std::string& name, const Image& image) {
  std::string what = fmt::format("{} {}x{}", name, image.width(), image.height());
  for (const ImageChannel& channel : image.channels()) what += " " + channel.name;
  const Clock::time_point end = deadline();
  if (what != shown_) send(tev_create_image(name, image), end);
  shown_ = what;
  const std::size_t row = static_cast<std::size_t>(image.width()) * image.channels().size() * sizeof(float);
  const int rows = static_cast<int>(std::max<std::size_t>(1, kPacketBytes / std::max<std::size_t>(row, 1)));
  for (int first = 0; first < image.height(); first += rows)
    send(tev_update_image(name, image, first, std::min(first + rows, image.height())), end);
}

}  // namespace glowworm
