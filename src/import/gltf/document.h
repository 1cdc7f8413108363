// A glTF 2.0 file read and checked, before anything is made of it.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "import/import.h"

namespace tinygltf {
class Model;
}

namespace glowworm {

/// An image of a glTF file: by file name, or in a buffer view.
struct GltfImage {
  std::string uri;       ///< as written: percent-encoded, or a data URI; empty where a buffer view holds it
  int buffer_view = -1;  ///< -1: none
};

/// A glTF file. What lies in its buffers is read and checked here; tinygltf only maps the JSON to structures, so that
/// it opens no files and follows no index.
struct GltfDocument {
  std::string path;
  std::string folder;                      ///< that file names are relative to
  std::unique_ptr<tinygltf::Model> model;  ///< its buffers and images are empty
  std::vector<std::vector<std::uint8_t>> buffers;
  std::vector<std::vector<std::uint8_t>> decoded_views;  ///< buffer views that were compressed, by index; else empty
  std::vector<GltfImage> images;
  std::shared_ptr<MemoryBudget> budget;
  std::unique_ptr<Reservation> held;  ///< of the buffers

  GltfDocument();
  GltfDocument(GltfDocument&&) noexcept;
  GltfDocument& operator=(GltfDocument&&) noexcept;
  ~GltfDocument();

  /// The bytes of a buffer view, which must exist (decompressed where EXT_meshopt_compression says so).
  std::span<const std::uint8_t> view(int index) const;
};

/// Reads a .gltf or .glb file with its buffers and checks that every index and every range lies inside of what it
/// refers to. Throws Error, naming the object ("accessors[3]"), for what is not so, and MemoryError.
GltfDocument read_gltf_document(const std::string& path, const ImportOptions& options);

/// The same of a file that stands in memory. @param path names it in messages; buffers are looked for beside it
GltfDocument read_gltf_document(std::span<const std::uint8_t> file, const std::string& path,
                                const ImportOptions& options);

/// Whether an extension of this name is read. What an unsupported one says is left out, with a note.
bool is_supported_extension(std::string_view name);

/// A URI with its %XX turned into bytes (RFC 3986, section 2.1).
std::string decode_uri(const std::string& uri);

/// The bytes of a data URI in base64 (RFC 2397); empty where it is none, or broken.
std::vector<std::uint8_t> decode_data_uri(const std::string& uri);

}  // namespace glowworm
