#include "render/checkpoint.h"

#include <cstring>
#include <fstream>
#include <iterator>

#include "core/atomic_file.h"
#include "core/error.h"

namespace glowworm {

namespace {

constexpr char kMagic[8] = {'G', 'L', 'O', 'W', 'C', 'P', '0', '1'};

/// FNV-1a over 64 bits (Fowler, Noll, Vo): enough to find a damaged file.
std::uint64_t fingerprint(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

template <typename T>
void put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Takes values off the front of a file's bytes; tells where they are too few.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}
  bool take(void* to, std::size_t size) {
    if (size > bytes_.size() - at_) return false;
    std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
    return true;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

bool parse(const std::string& bytes, Checkpoint& out) {
  Reader reader(bytes);
  char magic[sizeof kMagic];
  std::uint64_t hash = 0, key_size = 0, film_size = 0;
  if (!reader.take(magic, sizeof magic) || std::memcmp(magic, kMagic, sizeof magic) != 0) return false;
  if (!reader.take(&hash, sizeof hash) || hash != fingerprint(bytes.substr(sizeof magic + sizeof hash))) return false;
  if (!reader.take(&key_size, sizeof key_size) || key_size > reader.left()) return false;
  out.key.resize(key_size);
  if (!reader.take(out.key.data(), key_size) || !reader.take(&out.passes, sizeof out.passes)) return false;
  if (!reader.take(&film_size, sizeof film_size) || film_size != reader.left() / sizeof(float)) return false;
  out.film.resize(film_size);
  return reader.take(out.film.data(), film_size * sizeof(float)) && reader.left() == 0;
}

}  // namespace

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  std::string body;
  body.reserve(checkpoint.film.size() * sizeof(float) + checkpoint.key.size() + 64);
  put(body, static_cast<std::uint64_t>(checkpoint.key.size()));
  body += checkpoint.key;
  put(body, checkpoint.passes);
  put(body, static_cast<std::uint64_t>(checkpoint.film.size()));
  body.append(reinterpret_cast<const char*>(checkpoint.film.data()), checkpoint.film.size() * sizeof(float));
  std::string head(kMagic, sizeof kMagic);
  put(head, fingerprint(body));
  AtomicFile file(path);
  file.write(head);
  file.write(body);
  file.commit();
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  Checkpoint out;
  if (!parse(bytes, out))
    throw Error({path}, "this is not a whole checkpoint of this program",
                "Remove the file, or leave --resume out, to start anew.");
  return out;
}

}  // namespace glowworm
