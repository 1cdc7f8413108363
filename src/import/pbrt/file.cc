#include "import/pbrt/file.h"

#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

namespace {

/// Ends an inflate stream when the scope is left.
struct Inflater {
  z_stream stream{};
  bool ready = inflateInit2(&stream, 15 + 16) == Z_OK;  // 16: expect gzip's header
  ~Inflater() {
    if (ready) inflateEnd(&stream);
  }
};

constexpr std::string_view kGzipMagic = "\x1f\x8b";

std::string inflate_gzip(const std::string& path, const std::string& packed, Reservation& held) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  Inflater inflater;
  if (!inflater.ready) throw Error({path}, "cannot be inflated: no memory", "Free some memory.");
  z_stream& stream = inflater.stream;
  const std::uint64_t max_bytes = std::max(kSmallInflatedBytes, kMaxInflation * packed.size());
  std::string out;
  std::size_t consumed = 0, filled = 0;
  int result = Z_OK;
  while (result != Z_STREAM_END) {
    if (filled >= max_bytes) {
      throw Error({path},
                  "inflates to more than " + std::to_string(max_bytes >> 20) + " MiB, " +
                      std::to_string(kMaxInflation) + " times its size",
                  "If the file is genuine, inflate it with gunzip.");
    }
    if (filled == out.size()) {
      const std::size_t room = std::min<std::uint64_t>(std::max(kPiece, filled / 2), max_bytes - filled);
      held.grow(room);
      out.resize(filled + room);
    }
    const std::size_t piece_out = std::min<std::size_t>(out.size() - filled, 1u << 30);
    const std::size_t piece_in = std::min<std::size_t>(packed.size() - consumed, 1u << 30);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + consumed));
    stream.avail_in = static_cast<uInt>(piece_in);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + filled);
    stream.avail_out = static_cast<uInt>(piece_out);
    result = inflate(&stream, Z_NO_FLUSH);
    consumed += piece_in - stream.avail_in;
    filled += piece_out - stream.avail_out;
    const bool progress = stream.avail_out < piece_out || stream.avail_in < piece_in;
    if ((result != Z_OK && result != Z_STREAM_END) || !progress) {
      throw Error({path}, "is damaged: its gzip data is truncated or invalid", "Get the file again.");
    }
    // A file may be several members one after another (RFC 1952, section 2.2). Padding after them is ignored.
    const bool another = std::string_view(packed).substr(consumed).starts_with(kGzipMagic);
    if (result == Z_STREAM_END && another) result = inflateReset(&stream);
  }
  out.resize(filled);
  return out;
}

/// Resolves a path through files that stand for symbolic links. Empty if there is no such file.
std::filesystem::path follow_link_files(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  constexpr std::uintmax_t kLongestLink = 255;
  std::error_code error;
  fs::path resolved;
  for (const fs::path& part : path) {
    resolved /= part;
    if (!fs::is_regular_file(resolved, error) || fs::file_size(resolved, error) > kLongestLink) continue;
    std::ifstream in(resolved, std::ios::binary);
    const std::string target{std::istreambuf_iterator<char>(in), {}};
    if (target.empty() || target.find_first_of(std::string("\n\0", 2)) != std::string::npos) continue;
    const fs::path folder = resolved.parent_path() / target;
    if (fs::is_directory(folder, error)) resolved = folder;
  }
  return fs::exists(resolved, error) ? resolved : fs::path();
}

}  // namespace

std::string read_pbrt_file(const std::string& path, Reservation& held) {
  std::string bytes = read_input_file(path, held);
  if (bytes.starts_with(kGzipMagic)) return inflate_gzip(path, bytes, held);
  return bytes;
}

std::string resolve_pbrt_path(const std::string& name, const std::string& main_file, const std::string& naming_file) {
  const std::filesystem::path path(name);
  if (path.is_absolute()) return name;
  const std::filesystem::path in_main = std::filesystem::path(main_file).parent_path() / path;
  std::error_code error;
  if (!std::filesystem::exists(in_main, error)) {
    const std::filesystem::path beside = std::filesystem::path(naming_file).parent_path() / path;
    if (std::filesystem::exists(beside, error)) return beside.string();
    for (const std::filesystem::path& candidate : {in_main, beside}) {
      const std::filesystem::path linked = follow_link_files(candidate);
      if (!linked.empty()) return linked.string();
    }
  }
  return in_main.string();
}

}  // namespace glowworm
