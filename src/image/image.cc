#include "image/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace glowworm {

namespace {
std::string channel_name(std::string_view layer, std::string_view component) {
  return layer.empty() ? std::string(component) : fmt::format("{}.{}", layer, component);
}

void check_size(std::size_t given, const Image& image, std::string_view layer) {
  if (given != image.pixel_count()) {
    throw Error(fmt::format("layer \"{}\" has {} pixels where the picture has {} ({} x {})", layer, given,
                            image.pixel_count(), image.width(), image.height()));
  }
}
}  // namespace

Image::Image(int width, int height) : width_(width), height_(height) {
  if (width <= 0 || height <= 0) {
    throw Error(fmt::format("a picture of {} x {} pixels has nothing in it", width, height),
                "Give a width and a height of at least 1.");
  }
}

bool Image::has_channel(std::string_view name) const {
  return std::any_of(channels_.begin(), channels_.end(), [&](const ImageChannel& c) { return c.name == name; });
}

std::span<const float> Image::channel(std::string_view name) const {
  for (const ImageChannel& channel : channels_) {
    if (channel.name == name) return channel.samples;
  }
  std::string names;
  for (const ImageChannel& channel : channels_) names += (names.empty() ? "" : ", ") + channel.name;
  throw Error(fmt::format("the picture has no channel \"{}\"", name), fmt::format("It has: {}.", names));
}

std::span<float> Image::channel(std::string_view name) {
  const std::span<const float> found = std::as_const(*this).channel(name);
  return {const_cast<float*>(found.data()), found.size()};  // this picture is not const, so its samples are not, either
}

std::span<float> Image::add_channel(const std::string& name) {
  std::erase_if(channels_, [&](const ImageChannel& channel) { return channel.name == name; });
  channels_.push_back({name, std::vector<float>(pixel_count())});
  return channels_.back().samples;
}

void Image::add_rgb(std::string_view layer, std::span<const RGB> pixels) {
  check_size(pixels.size(), *this, layer);
  const std::span<float> r = add_channel(channel_name(layer, "R")), g = add_channel(channel_name(layer, "G")),
                         b = add_channel(channel_name(layer, "B"));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    r[i] = pixels[i].r;
    g[i] = pixels[i].g;
    b[i] = pixels[i].b;
  }
}

void Image::add_vec3(std::string_view layer, std::span<const Vec3> pixels) {
  check_size(pixels.size(), *this, layer);
  const std::span<float> x = add_channel(channel_name(layer, "X")), y = add_channel(channel_name(layer, "Y")),
                         z = add_channel(channel_name(layer, "Z"));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    x[i] = pixels[i].x;
    y[i] = pixels[i].y;
    z[i] = pixels[i].z;
  }
}

void Image::add_scalar(const std::string& name, std::span<const float> pixels) {
  check_size(pixels.size(), *this, name);
  std::copy(pixels.begin(), pixels.end(), add_channel(name).begin());
}

std::vector<RGB> Image::rgb(std::string_view layer) const {
  const std::span<const float> r = channel(channel_name(layer, "R")), g = channel(channel_name(layer, "G")),
                               b = channel(channel_name(layer, "B"));
  std::vector<RGB> pixels(pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = {r[i], g[i], b[i]};
  return pixels;
}

}  // namespace glowworm
