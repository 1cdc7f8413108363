#include "film/aov.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/json_text.h"
#include "settings/options.h"

namespace glowworm {

namespace {

using Layer = Film::Layer;

using Source = LayerSource;

/// How a layer of aov_names() is written.
struct LayerWriter {
  const char* name;
  std::function<void(Image&, const Source&)> write;
};

std::vector<RGB> means(const Film& film, Layer layer) {
  std::vector<RGB> pixels(film.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = film.mean(layer, i);
  return pixels;
}

LayerWriter rgb_row(const char* name, Layer layer) {
  return {name, [name, layer](Image& image, const Source& from) { image.add_rgb(name, means(from.film, layer)); }};
}

/// Three channels X, Y, Z.
LayerWriter vector_row(const char* name, Layer layer) {
  return {name, [name, layer](Image& image, const Source& from) {
            std::vector<Vec3> pixels;
            for (const RGB& mean : means(from.film, layer)) pixels.push_back({mean.r, mean.g, mean.b});
            image.add_vec3(name, pixels);
          }};
}

template <typename Value>
void add_channel(Image& image, const std::string& name, const Film& film, Value&& value) {
  std::vector<float> pixels(film.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = value(i);
  image.add_scalar(name, pixels);
}

/// A row of one channel. @param value of a pixel, by its source and its index
LayerWriter scalar_row(const char* name, const char* channel, float (*value)(const Source&, std::size_t)) {
  const auto write = [channel, value](Image& image, const Source& from) {
    add_channel(image, channel, from.film, [&](std::size_t i) { return value(from, i); });
  };
  return {name, write};
}

void add_uv(Image& image, const Source& from) {
  for (const auto& [channel, at] : {std::pair{"uv.U", 0}, {"uv.V", 1}})
    add_channel(image, channel, from.film, [&, at = at](std::size_t i) { return from.film.mean(Layer::uv, i)[at]; });
}

using Ids = Film::IdCounts;

/// The ids of a pixel, those that most samples hit first; at equal counts the lower first.
Ids ranked(Ids ids) {
  std::stable_sort(ids.begin(), ids.end(), [](const Film::IdCount& a, const Film::IdCount& b) {
    return a.count != b.count ? a.count > b.count : a.id < b.id;
  });
  return ids;
}

void add_ids(Image& image, const std::string& channel, const Film& film, const std::vector<Ids>& ids) {
  add_channel(image, channel, film, [&](std::size_t i) {
    const Film::IdCount first = ranked(ids[i]).front();
    return first.count == 0 ? -1.0f : static_cast<float>(first.id);
  });
}

std::string names_json(const nlohmann::json& names) { return json_text(names); }

/// Adds a Cryptomatte: for each pixel pairs of an id and the share of samples that hit it, in descending order, two
/// pairs a layer. @param layer "CryptoObject"
void add_cryptomatte(Image& image, const std::string& layer, const Film& film, const std::vector<Ids>& ids,
                     const std::vector<std::string>& names) {
  std::vector<float> values;
  nlohmann::json manifest = nlohmann::json::object();
  for (const std::string& name : names) {
    const std::uint32_t hash = cryptomatte_hash(name);
    values.push_back(std::bit_cast<float>(hash));
    manifest[name] = fmt::format("{:08x}", hash);
  }
  std::vector<Ids> sorted;
  for (const Ids& of_pixel : ids) sorted.push_back(ranked(of_pixel));
  for (std::size_t rank = 0; rank < kMaxIdsOfPixel; ++rank) {
    const std::string channels = fmt::format("{}{:02}.", layer, rank / 2);
    const auto at = [&](std::size_t i) { return sorted[i][rank]; };
    add_channel(image, channels + (rank % 2 ? "B" : "R"), film,
                [&](std::size_t i) { return at(i).count > 0 && at(i).id < values.size() ? values[at(i).id] : 0.0f; });
    add_channel(image, channels + (rank % 2 ? "A" : "G"), film, [&](std::size_t i) {
      return at(i).count > 0 ? static_cast<float>(at(i).count) / static_cast<float>(film.sample_count(i)) : 0.0f;
    });
  }
  const std::string key = "cryptomatte/" + fmt::format("{:08x}", cryptomatte_hash(layer)).substr(0, 7) + "/";
  image.metadata[key + "name"] = layer;
  image.metadata[key + "hash"] = "MurmurHash3_32";
  image.metadata[key + "conversion"] = "uint32_to_float32";
  image.metadata[key + "manifest"] = names_json(manifest);
}

const std::vector<LayerWriter>& table() {
  static const std::vector<LayerWriter> rows = {
      rgb_row("emitted", Layer::surface_emitted),
      rgb_row("direct", Layer::direct),
      rgb_row("indirect", Layer::indirect),
      rgb_row("caustic", Layer::caustic),
      rgb_row("medium", Layer::medium),
      rgb_row("albedo", Layer::surface_albedo),
      vector_row("normal", Layer::normal),
      scalar_row("depth", "depth.Z", [](const Source& from, std::size_t i) { return from.film.depth(i); }),
      {"unfiltered",
       [](Image& image, const Source& from) {
         std::vector<RGB> pixels(from.film.pixel_count());
         for (std::size_t i = 0; i < pixels.size(); ++i)
           pixels[i] = from.film.radiance(i, from.info.settings.indirect_only) * from.info.scale;
         image.add_rgb("unfiltered", pixels);
       }},
      scalar_row(
          "noise", "noise.Y",
          [](const Source& from, std::size_t i) { return std::sqrt(from.picture.variance[i]) * from.info.scale; }),
      scalar_row("samples", "samples.Y",
                 [](const Source& from, std::size_t i) { return static_cast<float>(from.film.sample_count(i)); }),
      scalar_row("radius", "radius.Y",
                 [](const Source& from, std::size_t i) { return from.film.value(SlotValue::radius, i); }),
      scalar_row(
          "bias", "bias.Y",
          [](const Source& from, std::size_t i) { return from.film.value(SlotValue::bias, i) * from.info.scale; }),
      scalar_row("alpha", "A", [](const Source& from, std::size_t i) { return from.film.coverage(i); }),
      vector_row("position", Layer::position),
      {"uv", add_uv},
      {"object-id",
       [](Image& image, const Source& from) {
         add_ids(image, "object-id.I", from.film, from.film.objects());
         image.metadata["glowworm:objects"] = names_json(from.info.objects);
       }},
      {"material-id",
       [](Image& image, const Source& from) {
         add_ids(image, "material-id.I", from.film, from.film.materials());
         image.metadata["glowworm:materials"] = names_json(from.info.materials);
       }},
      {"cryptomatte",
       [](Image& image, const Source& from) {
         add_cryptomatte(image, "CryptoObject", from.film, from.film.objects(), from.info.objects);
         add_cryptomatte(image, "CryptoMaterial", from.film, from.film.materials(), from.info.materials);
       }},
  };
  return rows;
}

}  // namespace

void add_layer(Image& image, const LayerSource& source, const std::string& name) {
  std::vector<std::string> names;
  for (const LayerWriter& writer : table()) names.emplace_back(writer.name);
  table()[name_index("AOV", name, names)].write(image, source);
}

void add_light_group(Image& image, const LayerSource& source, std::size_t group) {
  std::string layer = "light." + source.info.light_groups[group];
  for (std::size_t i = 6; i < layer.size(); ++i)
    if (!std::isalnum(static_cast<unsigned char>(layer[i])) && layer[i] != '-') layer[i] = '_';
  std::vector<RGB> pixels(source.film.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = source.film.light_of_group(group, i) * source.info.scale;
  image.add_rgb(layer, pixels);
}

std::uint32_t cryptomatte_hash(std::string_view name) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(name[i])); };
  const auto mixed = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
  std::uint32_t h = 0, tail = 0;
  std::size_t i = 0;
  for (; i + 4 <= name.size(); i += 4) {
    h ^= mixed(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
    h = std::rotl(h, 13) * 5 + 0xe6546b64u;
  }
  for (std::size_t j = name.size(); j > i; --j) tail = tail << 8 | byte(j - 1);
  if (i < name.size()) h ^= mixed(tail);
  h ^= static_cast<std::uint32_t>(name.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;
  const std::uint32_t exponent = h >> 23 & 255;
  return exponent == 0 || exponent == 255 ? h ^ 1u << 23 : h;
}

}  // namespace glowworm
