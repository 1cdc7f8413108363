#include "image/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/names.h"

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

template <typename Pixel>
void add_three(Image& image, std::string_view layer, std::string_view letters, std::span<const Pixel> pixels) {
  check_size(pixels.size(), image, layer);
  for (int c = 0; c < 3; ++c) {
    const std::span<float> plane =
        image.add_channel(channel_name(layer, letters.substr(static_cast<std::size_t>(c), 1)));
    for (std::size_t i = 0; i < pixels.size(); ++i) plane[i] = pixels[i][c];
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
  std::vector<std::string> names;
  for (const ImageChannel& channel : channels_) {
    if (channel.name == name) return channel.samples;
    names.push_back(channel.name);
  }
  return channels_[name_index("the channel", std::string(name), names)].samples;
}

std::span<float> Image::channel(std::string_view name) {
  const std::span<const float> found = std::as_const(*this).channel(name);
  return {const_cast<float*>(found.data()), found.size()};  // this picture is not const, so its samples are not, either
}

std::span<float> Image::add_channel(const std::string& name) {
  return add_channel(name, std::vector<float>(pixel_count()));
}

std::span<float> Image::add_channel(const std::string& name, std::vector<float> samples) {
  check_size(samples.size(), *this, name);
  std::erase_if(channels_, [&](const ImageChannel& channel) { return channel.name == name; });
  channels_.push_back({name, std::move(samples)});
  return channels_.back().samples;
}

void Image::add_rgb(std::string_view layer, std::span<const RGB> pixels) { add_three(*this, layer, "RGB", pixels); }

void Image::add_vec3(std::string_view layer, std::span<const Vec3> pixels) { add_three(*this, layer, "XYZ", pixels); }

void Image::add_scalar(const std::string& name, std::span<const float> pixels) {
  add_channel(name, std::vector<float>(pixels.begin(), pixels.end()));
}

Image layer_of(const Image& image, std::string_view layer) {
  Image out(image.width(), image.height());
  out.place = image.place;
  std::vector<const ImageChannel*> found;
  std::set<std::string> layers;
  for (const ImageChannel& channel : image.channels()) {
    const std::size_t dot = channel.name.rfind('.');
    const std::string own = dot == std::string::npos ? "" : channel.name.substr(0, dot);
    if (!own.empty()) layers.insert(own);
    if (own == layer && (!layer.empty() || channel.name != "A")) found.push_back(&channel);
  }
  if (found.empty()) name_index("the layer", std::string(layer), {layers.begin(), layers.end()});
  for (const auto& [name, other, index] : {std::tuple{"R", "X", 0u}, {"G", "Y", 1u}, {"B", "Z", 2u}}) {
    const ImageChannel* taken = found[std::min<std::size_t>(index, found.size() - 1)];
    for (const ImageChannel* channel : found)
      if (channel->name.ends_with(name) || channel->name.ends_with(other)) taken = channel;
    out.add_scalar(name, found.size() == 1 ? found[0]->samples : taken->samples);
  }
  return out;
}

Image cut(const Image& image, int x0, int y0, int x1, int y1) {
  const int left = x0 - image.place.x0, top = y0 - image.place.y0, width = x1 - x0, height = y1 - y0;
  if (left < 0 || top < 0 || width <= 0 || height <= 0 || left + width > image.width() || top + height > image.height())
    throw Error(
        fmt::format("the picture has no part {},{},{},{}: its pixels are {},{},{},{}", x0, y0, x1, y1, image.place.x0,
                    image.place.y0, image.place.x0 + image.width(), image.place.y0 + image.height()),
        "Give x0,y0,x1,y1 within them.");
  Image out(width, height);
  out.place = image.place;
  out.place.x0 = x0;
  out.place.y0 = y0;
  for (const ImageChannel& channel : image.channels()) {
    const std::span<float> samples = out.add_channel(channel.name);
    for (int y = 0; y < height; ++y)
      std::copy_n(channel.samples.begin() + static_cast<std::ptrdiff_t>(top + y) * image.width() + left, width,
                  samples.begin() + static_cast<std::ptrdiff_t>(y) * width);
  }
  return out;
}

void cut_to_common_part(Image& a, Image& b) {
  const auto whole = [](const Image& i) {
    return i.place.whole_width > 0 ? std::pair{i.place.whole_width, i.place.whole_height}
                                   : std::pair{i.width(), i.height()};
  };
  if (whole(a) != whole(b)) return;
  const int x0 = std::max(a.place.x0, b.place.x0), y0 = std::max(a.place.y0, b.place.y0);
  const int x1 = std::min(a.place.x0 + a.width(), b.place.x0 + b.width());
  const int y1 = std::min(a.place.y0 + a.height(), b.place.y0 + b.height());
  a = cut(a, x0, y0, x1, y1);
  b = cut(b, x0, y0, x1, y1);
}

std::vector<RGB> Image::rgb(std::string_view layer) const {
  const std::span<const float> r = channel(channel_name(layer, "R")), g = channel(channel_name(layer, "G")),
                               b = channel(channel_name(layer, "B"));
  std::vector<RGB> pixels(pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = {r[i], g[i], b[i]};
  return pixels;
}

}  // namespace glowworm
