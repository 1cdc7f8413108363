// tev's protocol: the bytes of its packets, and a server that reads them as tev does.
#include "image/tev.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "core/error.h"

namespace glowworm {
namespace {

Image small_image(float base) {
  Image image(3, 2);
  std::vector<RGB> pixels;
  for (int i = 0; i < 6; ++i) pixels.push_back(RGB(base + static_cast<float>(i), 10, -static_cast<float>(i)));
  image.add_rgb("", pixels);
  return image;
}

/// Takes fields off the front of a packet, as tev's IStream does.
class Reader {
 public:
  explicit Reader(const std::vector<char>& bytes) : bytes_(bytes) {}
  template <typename Value>
  Value get() {
    Value value{};
    if (at_ + sizeof(Value) > bytes_.size()) {
      ADD_FAILURE() << "the packet ends early";
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(Value));
    at_ += sizeof(Value);
    return value;
  }
  std::string text() {
    std::string out;
    while (at_ < bytes_.size() && bytes_[at_]) out += bytes_[at_++];
    ++at_;
    return out;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

TEST(TevPacket, CreatesAnImageByteForByte) {
  Image image(2, 1);
  image.add_scalar("A", std::vector<float>{0, 0});
  // 4 of length, 1 of kind, 1 of focus, 2 of name, 3 x 4 of numbers, 2 of a channel's name.
  const std::vector<char> wanted = {22, 0, 0, 0, 4, 1, 'x', 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 'A', 0};
  EXPECT_EQ(tev_create_image("x", image), wanted);
}

/// What a tev would hold: the packets applied one after another.
struct FakeTev {
  std::map<std::string, std::map<std::string, std::vector<float>>> images;
  std::map<std::string, std::pair<int, int>> sizes;
  int created = 0, updated = 0;

  void apply(const std::vector<char>& packet) {
    Reader r(packet);
    ASSERT_EQ(r.get<std::uint32_t>(), packet.size());
    const int kind = r.get<std::uint8_t>();
    r.get<std::uint8_t>();
    const std::string name = r.text();
    if (kind == 4) {
      const int width = r.get<std::int32_t>(), height = r.get<std::int32_t>(), count = r.get<std::int32_t>();
      sizes[name] = {width, height};
      for (int c = 0; c < count; ++c) images[name][r.text()].assign(static_cast<std::size_t>(width * height), 0);
      ++created;
      EXPECT_EQ(r.left(), 0u);
      return;
    }
    ASSERT_EQ(kind, 6);
    ++updated;
    const int count = r.get<std::int32_t>();
    std::vector<std::string> channels;
    for (int c = 0; c < count; ++c) channels.push_back(r.text());
    const int x = r.get<std::int32_t>(), y = r.get<std::int32_t>(), w = r.get<std::int32_t>(),
              h = r.get<std::int32_t>();
    std::vector<std::int64_t> offset, stride;
    for (int c = 0; c < count; ++c) offset.push_back(r.get<std::int64_t>());
    for (int c = 0; c < count; ++c) stride.push_back(r.get<std::int64_t>());
    std::vector<float> data(r.left() / sizeof(float));
    for (float& v : data) v = r.get<float>();
    for (int c = 0; c < count; ++c)
      for (int p = 0; p < w * h; ++p) {
        const auto from =
            static_cast<std::size_t>(offset[static_cast<std::size_t>(c)] + p * stride[static_cast<std::size_t>(c)]);
        ASSERT_LT(from, data.size());
        images[name][channels[static_cast<std::size_t>(c)]]
              [static_cast<std::size_t>((y + p / w) * sizes[name].first + x + p % w)] = data[from];
      }
  }
};

/// Listens on a port of its own, and applies what one client sends.
class Listener {
 public:
  Listener() {
    socket_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    socklen_t size = sizeof(address);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    EXPECT_EQ(listen(socket_, 1), 0);
  }
  ~Listener() { close(socket_); }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  int take() const { return accept(socket_, nullptr, nullptr); }

  void serve(FakeTev& tev) const {
    const int client = take();
    std::vector<char> bytes;
    char buffer[65536];
    for (ssize_t n; (n = recv(client, buffer, sizeof(buffer), 0)) > 0;) {
      bytes.insert(bytes.end(), buffer, buffer + n);
      for (std::uint32_t length = 0; bytes.size() >= 4;) {
        std::memcpy(&length, bytes.data(), 4);
        if (length < 5 || bytes.size() < length) break;
        tev.apply({bytes.begin(), bytes.begin() + length});
        bytes.erase(bytes.begin(), bytes.begin() + length);
      }
    }
    EXPECT_TRUE(bytes.empty());
    close(client);
  }

 private:
  int socket_ = -1;
  int port_ = 0;
};

TEST(TevConnection, SendsSeveralPictures) {
  Listener listener;
  FakeTev tev;
  std::thread server([&] { listener.serve(tev); });
  Image large(700, 500);
  std::vector<RGB> pixels(large.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = RGB(static_cast<float>(i), 1, 2);
  large.add_rgb("", pixels);
  {
    TevConnection connection(listener.address());
    connection.show("small", small_image(0));
    connection.show("small", small_image(5));
    connection.show("large", large);
  }
  server.join();
  EXPECT_EQ(tev.created, 2);
  EXPECT_GT(tev.updated, 3) << "large pictures come in several packets";
  EXPECT_THAT(tev.images["small"]["R"], testing::ElementsAre(5, 6, 7, 8, 9, 10));
  EXPECT_THAT(tev.images["small"]["B"], testing::ElementsAre(0, -1, -2, -3, -4, -5));
  for (std::size_t i = 0; i < pixels.size(); i += 997) ASSERT_EQ(tev.images["large"]["R"][i], pixels[i].r);
}

TEST(TevConnection, ReportsWrongAddresses) {
  std::string unused;
  { unused = Listener().address(); }  // closed again: nothing listens there
  for (const std::string& address : {unused, std::string("127.0.0.1:port"), std::string(":1"), std::string("a:99999")})
    try {
      const TevConnection connection(address);
      FAIL() << address;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr(address), testing::HasSubstr("--tev")));
    }
}

/// A tev that takes a little now and then, so that no single send() waits for long.
TEST(TevConnection, TimesOutIfTevIsTooSlow) {
  const Listener listener;
  std::atomic<bool> done{false};
  std::thread slow([&] {
    const int client = listener.take();
    std::vector<char> buffer(1 << 16);
    while (!done) {
      if (recv(client, buffer.data(), buffer.size(), 0) <= 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    close(client);
  });
  Image image(4096, 2048);
  image.add_rgb("", std::vector<RGB>(image.pixel_count()));
  const auto start = std::chrono::steady_clock::now();
  {
    TevConnection connection(listener.address(), 0.3);
    EXPECT_THROW(connection.show("x", image), Error);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  done = true;
  slow.join();
}

TEST(TevConnection, ThrowsIfTevDisconnects) {
  auto listener = std::make_unique<Listener>();
  TevConnection connection(listener->address());
  listener.reset();  // resets the connection that nobody took
  Image image(512, 512);
  image.add_scalar("A", std::vector<float>(512 * 512));
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) connection.show("x", image);
      },
      Error);
}

}  // namespace
}  // namespace glowworm
