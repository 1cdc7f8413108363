#include "image/texture_file.h"

#include <algorithm>
#include <cmath>

#include "image/texel_decoder.h"

namespace glowworm {

namespace {

// The two texels on one axis that a lookup interpolates, and their weights.
struct Taps {
  int index[2];
  float weight[2];
};

// Maps a coordinate to the first copy of the texture for repeating wraps, and close to it for the others, so that later
// arithmetic keeps its precision.
float fold(float t, TextureWrap wrap) {
  if (!std::isfinite(t)) return 0;
  switch (wrap) {
    case TextureWrap::repeat:
      return t - std::floor(t);
    case TextureWrap::mirror: {
      const float in_period = t - 2 * std::floor(t / 2);
      return in_period > 1 ? 2 - in_period : in_period;
    }
    case TextureWrap::clamp:
      return std::clamp(t, 0.0f, 1.0f);
    case TextureWrap::black:
      break;
  }
  return std::clamp(t, -1.0f, 2.0f);
}

Taps taps_of(float t, int size, TextureWrap wrap, TextureFilter filter) {
  const float position = t * static_cast<float>(size);
  Taps taps;
  if (filter == TextureFilter::nearest) {
    // In a folded coordinate, 1 is the far edge, which belongs to the last texel.
    const int texel = static_cast<int>(std::floor(position));
    const int inside = wrap == TextureWrap::black ? texel : std::clamp(texel, 0, size - 1);
    taps = {{inside, inside}, {1, 0}};
  } else {
    const float first = std::floor(position - 0.5f);
    const float fraction = position - 0.5f - first;
    taps = {{static_cast<int>(first), static_cast<int>(first) + 1}, {1 - fraction, fraction}};
  }
  for (int i = 0; i < 2; ++i) {
    int& texel = taps.index[i];
    if (texel >= 0 && texel < size) continue;
    if (wrap == TextureWrap::repeat) {
      texel = texel < 0 ? size - 1 : 0;
    } else {
      if (wrap == TextureWrap::black) taps.weight[i] = 0;
      texel = std::clamp(texel, 0, size - 1);
    }
  }
  return taps;
}

class DecodedTexture final : public TextureFile {
 public:
  DecodedTexture(std::shared_ptr<const ImageFileData> texels, const TextureOptions& options)
      : TextureFile(texels->header.width, texels->header.height, texels->header.alpha_channel >= 0, options),
        texels_(std::move(texels)),
        decoder_(texels_->header.type, resolve_encoding(options, texels_->header.transfer)),
        channels_(static_cast<std::size_t>(texels_->header.channels)) {}

  std::uint64_t memory_bytes() const override { return texels_->samples.size(); }

 protected:
  void fetch(const int x[2], const int y[2], Texel out[4]) const override {
    for (int i = 0; i < 4; ++i) {
      const std::size_t texel =
          static_cast<std::size_t>(y[i / 2]) * static_cast<std::size_t>(width()) + static_cast<std::size_t>(x[i % 2]);
      const std::byte* samples = texels_->samples.data();
      const std::size_t first = texel * channels_;
      out[i].color = decoder_.color(samples, first, channels_ < 3);
      out[i].alpha = has_alpha() ? decoder_.alpha(samples, first + channels_ - 1) : 1;
    }
  }

 private:
  std::shared_ptr<const ImageFileData> texels_;
  TexelDecoder decoder_;
  std::size_t channels_;
};

}  // namespace

TextureFile::Texel TextureFile::look_up(Vec2 uv) const {
  const float u = fold(uv.x, options_.wrap_u), v = fold(uv.y, options_.wrap_v);
  const Taps across = taps_of(u, width_, options_.wrap_u, options_.filter);
  const Taps down = taps_of(1 - v, height_, options_.wrap_v, options_.filter);
  Texel texels[4];
  fetch(across.index, down.index, texels);
  Texel sum{RGB(0.0f), 0};
  for (int i = 0; i < 4; ++i) {
    const float weight = across.weight[i % 2] * down.weight[i / 2];
    if (weight == 0) continue;  // an infinite texel with weight 0 must not count
    sum.color += texels[i].color * weight;
    sum.alpha += texels[i].alpha * weight;
  }
  return sum;
}

RGB TextureFile::color(Vec2 uv) const { return look_up(uv).color; }

float TextureFile::alpha(Vec2 uv) const { return has_alpha_ ? look_up(uv).alpha : 1; }

std::shared_ptr<const ImageFileData> read_texels(const std::string& path) {
  auto texels = std::make_shared<ImageFileData>(read_image_file(path));
  ImageFileHeader& header = texels->header;
  if (is_opaque(header, texels->samples)) header.alpha_channel = -1;
  const int kept = kept_channels(header);
  if (kept == header.channels && (header.alpha_channel < 0 || header.alpha_channel == kept - 1)) return texels;
  std::vector<std::byte> samples(texels->samples.size() / static_cast<std::size_t>(header.channels) *
                                 static_cast<std::size_t>(kept));
  keep_channels(header, texels->samples, samples.data());
  texels->samples = std::move(samples);
  header.channels = kept;
  if (header.alpha_channel >= 0) header.alpha_channel = kept - 1;
  return texels;
}

std::shared_ptr<const TextureFile> make_texture(std::shared_ptr<const ImageFileData> texels,
                                                const TextureOptions& options) {
  return std::make_shared<DecodedTexture>(std::move(texels), options);
}

}  // namespace glowworm
