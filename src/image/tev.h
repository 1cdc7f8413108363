// Shows pictures in a running tev (github.com/Tom94/tev) over its network protocol.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"

namespace glowworm {

/// One packet of tev's protocol, little-endian: its length in bytes, including these four (uint32), the kind of packet
/// (uint8), then the fields; strings end with a zero byte. As written by tev's own Python client (tev.py, ipc.py).
using TevPacket = std::vector<char>;
/// A blank picture with these channels (CreateImage, kind 4).
TevPacket tev_create_image(std::string_view name, const Image& image);
/// Rows [first, last) of all channels, channel by channel (UpdateImage, version 3, kind 6).
TevPacket tev_update_image(std::string_view name, const Image& image, int first, int last);

/// Throws Error if the address is not HOST:PORT, or HOST.
void check_tev_address(const std::string& address);

/// A connection to a tev.
class TevConnection {
 public:
  /// @param address HOST:PORT, or HOST for tev's own port 14158; an IPv6 address in brackets. Throws Error if it is
  /// invalid, or if nothing answers within `patience_s` seconds.
  explicit TevConnection(const std::string& address, double patience_s = 5);
  ~TevConnection();
  TevConnection(const TevConnection&) = delete;
  TevConnection& operator=(const TevConnection&) = delete;

  /// Shows all channels of a picture under a name, replacing an earlier picture of that name. Throws Error if the
  /// connection was closed, or if tev does not accept the whole picture within `patience_s` seconds.
  void show(const std::string& name, const Image& image);

 private:
  using Clock = std::chrono::steady_clock;
  void send(const TevPacket& packet, Clock::time_point deadline);
  Clock::time_point deadline() const;

  std::string address_;
  double patience_s_;
  int socket_ = -1;
  std::string shown_;  // name, size and channels of the picture shown in tev
};

}  // namespace glowworm
