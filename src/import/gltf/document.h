// Reads and checks glTF 2.0 files.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "import/gltf/light_units.h"
#include "import/import.h"

namespace tinygltf {
class Model;
}

namespace glowworm {

/// An image of a glTF file, in a file or in a buffer view.
struct GltfImage {
  std::string uri;       ///< as written: percent-encoded, or a data URI; empty if the image is in a buffer view
  int buffer_view = -1;  ///< -1: none
};

/// A property that an animation moves (KHR_animation_pointer), which tinygltf does not read.
struct GltfPointer {
  std::size_t animation = 0, sampler = 0;
  std::string property;  ///< JSON pointer
};

/// A glTF file. The buffers are read and checked here. tinygltf only converts JSON to structures: it opens no files and
/// follows no indices.
struct GltfDocument {
  std::string path;
  std::string folder;                      ///< base of relative file names
  std::unique_ptr<tinygltf::Model> model;  ///< without content of buffers and images
  std::vector<std::vector<std::uint8_t>> buffers;
  std::vector<std::vector<std::uint8_t>>
      decoded_views;  ///< decompressed buffer views by index; empty if a view is not compressed
  std::vector<GltfImage> images;
  std::vector<GltfPointer> pointers;
  GltfLightUnits light_units;
  std::shared_ptr<MemoryBudget> budget;
  std::unique_ptr<Reservation> held;  ///< memory of the model and the buffers

  GltfDocument();
  GltfDocument(GltfDocument&&) noexcept;
  GltfDocument& operator=(GltfDocument&&) noexcept;
  ~GltfDocument();

  /// The bytes of a buffer view, decompressed if necessary (EXT_meshopt_compression). The view must exist.
  std::span<const std::uint8_t> view(int index) const;
};

/// Reads a .gltf or .glb file with its buffers, and checks that all indices and ranges are valid. Otherwise throws
/// Error, which names the object ("accessors[3]"); also throws MemoryError.
/// @param whole gets all of the file's JSON, unless it is null
GltfDocument read_gltf_document(const std::string& path, const ImportOptions& options, nlohmann::json* whole = nullptr);

/// Reads a file from memory. @param path name for messages; buffers are looked up in its folder
GltfDocument read_gltf_document(std::span<const std::uint8_t> file, const std::string& path,
                                const ImportOptions& options, nlohmann::json* whole = nullptr);

/// Whether an extension is supported. Unsupported ones are ignored, with a note.
bool is_supported_extension(std::string_view name);

/// Decodes a percent-encoded URI (RFC 3986, section 2.1).
std::string decode_uri(const std::string& uri);

/// The bytes of a base64 data URI (RFC 2397); empty if it is another URI, or damaged.
std::vector<std::uint8_t> decode_data_uri(const std::string& uri);

}  // namespace glowworm
