// The public header glowworm/picture.h.
#include "glowworm/picture.h"

#include <algorithm>

#include "api/picture_implementation.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "core/names.h"
#include "core/text.h"
#include "image/metrics.h"
#include "image/picture_memory.h"
#include "settings/settings.h"

namespace glowworm::api {

namespace {

constexpr const char* kAlphaLayer = "alpha";

/// A channel's name in two parts: "albedo.R" is R of albedo, "R" is R of the image, "A" is A of alpha.
struct ChannelName {
  std::string layer, letter;
};

ChannelName split(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  if (dot != std::string::npos) return {channel.substr(0, dot), channel.substr(dot + 1)};
  return {channel == "A" ? kAlphaLayer : kImageLayer, channel};
}

std::string join(const std::string& layer, char letter) {
  const bool is_beauty = layer == kImageLayer || (layer == kAlphaLayer && letter == 'A');
  return is_beauty ? std::string(1, letter) : layer + "." + letter;
}

void check_size(const Picture& picture, const Picture::Layer& layer) {
  const std::size_t wanted = static_cast<std::size_t>(std::max(picture.width, 0)) *
                             static_cast<std::size_t>(std::max(picture.height, 0)) * layer.channels.size();
  if (layer.samples.size() != wanted || wanted == 0)
    throw Error("layer '" + layer.name + "' has " + std::to_string(layer.samples.size()) + " samples; a picture of " +
                    std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels with " +
                    std::to_string(layer.channels.size()) + " channels has " + std::to_string(wanted),
                "");
}

/// A picture with one layer as its image.
Image image_of(const Picture& picture, const std::string& name) {
  const Picture::Layer& layer = picture.layer(name);
  check_size(picture, layer);
  Picture only;
  only.width = picture.width;
  only.height = picture.height;
  only.layers.push_back(layer);
  // The channels of the image and of alpha are not named after their layer.
  only.layers.back().name = "layer";
  return layer_of(inner(only), "layer");
}

}  // namespace

Picture outer(const Image& image) {
  Picture out;
  out.width = image.width();
  out.height = image.height();
  const PicturePlace& place = image.place;
  if (place.whole_width != out.width || place.whole_height != out.height) {
    out.x0 = place.x0;
    out.y0 = place.y0;
    out.whole_width = place.whole_width;
    out.whole_height = place.whole_height;
  }
  out.metadata = image.metadata;
  // Channels of a layer follow one another in pictures of renders, but not in all files. A letter that stands for
  // nothing by itself is a layer.
  std::vector<std::vector<const ImageChannel*>> sources;
  for (const ImageChannel& channel : image.channels()) {
    const ChannelName name = split(channel.name);
    const bool has_letter = name.letter.size() == 1;
    const std::string layer = has_letter ? name.layer : channel.name;
    auto at = std::find_if(out.layers.begin(), out.layers.end(), [&](const auto& l) { return l.name == layer; });
    if (at == out.layers.end()) {
      out.layers.push_back({layer, "", {}});
      sources.emplace_back();
      at = out.layers.end() - 1;
    }
    at->channels += has_letter ? name.letter : "Y";
    sources[static_cast<std::size_t>(at - out.layers.begin())].push_back(&channel);
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::size_t count = sources[i].size();
    out.layers[i].samples.resize(count * image.pixel_count());
    for (std::size_t c = 0; c < count; ++c)
      for (std::size_t p = 0; p < image.pixel_count(); ++p)
        out.layers[i].samples[p * count + c] = sources[i][c]->samples[p];
  }
  return out;
}

Image inner(const Picture& picture) {
  Image image(picture.width, picture.height);
  for (const Picture::Layer& layer : picture.layers) {
    check_size(picture, layer);
    const std::size_t count = layer.channels.size();
    std::vector<float> plane(image.pixel_count());
    for (std::size_t c = 0; c < count; ++c) {
      for (std::size_t p = 0; p < plane.size(); ++p) plane[p] = layer.samples[p * count + c];
      image.add_scalar(join(layer.name, layer.channels[c]), plane);
    }
  }
  image.metadata = picture.metadata;
  if (picture.whole_width > 0) image.place = {picture.x0, picture.y0, picture.whole_width, picture.whole_height};
  return image;
}

const Picture::Layer& Picture::layer(const std::string& name) const {
  std::vector<std::string> names;
  for (const Layer& layer : layers) names.push_back(layer.name);
  return layers[name_index("the layer", name, names)];
}

Picture read_picture(const std::string& path) {
  MemoryBudget budget(default_memory_bytes(), "Reduce the picture.");
  Reservation held(budget, "picture", 0);
  const Image image = read_image(path, held);
  held.grow(image.pixel_count() * image.channels().size() * sizeof(float));  // the layers
  return outer(image);
}

void write_picture(const std::string& path, const Picture& picture, float exposure, Precision precision) {
  if (lower_ending(path) == ".exr") return write_exr(path, inner(picture), precision);
  write_image(path, inner(picture), ToneCurve::filmic, exposure);
}

std::string png_of(const Picture& picture, const std::string& layer, float exposure) {
  return png_bytes("", image_of(picture, layer), ToneCurve::filmic, exposure);
}

float automatic_exposure(const Picture& picture) {
  return glowworm::automatic_exposure(image_of(picture, kImageLayer).rgb());
}

Comparison compare(const Picture& picture, const Picture& reference, const std::string& layer, double leave_out) {
  const ImageComparison c = compare_images(image_of(picture, layer), image_of(reference, layer), leave_out);
  return {c.mse,
          c.relative_mse,
          c.relative_rmse,
          c.psnr,
          c.luminance_ratio,
          {c.mean_ratio[0], c.mean_ratio[1], c.mean_ratio[2]},
          c.largest_difference,
          c.pixels,
          c.non_finite_pixels};
}

}  // namespace glowworm::api
