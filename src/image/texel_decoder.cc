#include "image/texel_decoder.h"

#include <Imath/half.h>

#include <cmath>
#include <cstring>

namespace glowworm {

TransferFunction resolve_encoding(const TextureOptions& options, const TransferFunction& of_file) {
  using Kind = TransferFunction::Kind;
  switch (options.encoding) {
    case TextureEncoding::srgb:
      return {Kind::srgb, 1};
    case TextureEncoding::linear:
      return {};
    case TextureEncoding::power:
      return {Kind::power, options.exponent};
    case TextureEncoding::automatic:
      break;
  }
  return of_file;
}

TexelDecoder::TexelDecoder(SampleType type, const TransferFunction& transfer) : type_(type), transfer_(transfer) {
  const bool is_integer = type == SampleType::uint8 || type == SampleType::uint16;
  if (!is_integer || transfer.kind == TransferFunction::Kind::linear) return;
  table_.resize(type == SampleType::uint8 ? 256 : 65536);
  const float largest = static_cast<float>(table_.size() - 1);
  for (std::size_t code = 0; code < table_.size(); ++code) {
    table_[code] = transfer.decode(static_cast<float>(code) / largest);
  }
}

float TexelDecoder::plain(const std::byte* samples, std::size_t index) const {
  switch (type_) {
    case SampleType::uint8:
      return static_cast<float>(std::to_integer<std::uint8_t>(samples[index])) / 255.0f;
    case SampleType::uint16: {
      std::uint16_t code;
      std::memcpy(&code, samples + index * sizeof code, sizeof code);
      return static_cast<float>(code) / 65535.0f;
    }
    case SampleType::half: {
      std::uint16_t bits;
      std::memcpy(&bits, samples + index * sizeof bits, sizeof bits);
      Imath::half half;
      half.setBits(bits);
      return half;
    }
    case SampleType::single:
      break;
  }
  float value;
  std::memcpy(&value, samples + index * sizeof value, sizeof value);
  return value;
}

float TexelDecoder::color(const std::byte* samples, std::size_t index) const {
  if (table_.empty()) {
    const float value = transfer_.decode(plain(samples, index));
    return std::isfinite(value) ? value : 0;
  }
  if (type_ == SampleType::uint8) return table_[std::to_integer<std::uint8_t>(samples[index])];
  std::uint16_t code;
  std::memcpy(&code, samples + index * sizeof code, sizeof code);
  return table_[code];
}

float TexelDecoder::alpha(const std::byte* samples, std::size_t index) const { return plain(samples, index); }

int kept_channels(const ImageFileHeader& header) {
  return (header.channels >= 3 ? 3 : 1) + (header.alpha_channel >= 0 ? 1 : 0);
}

void keep_channels(const ImageFileHeader& header, std::span<const std::byte> samples, std::byte* to) {
  const bool has_alpha = header.alpha_channel >= 0;
  const int kept = kept_channels(header);
  if (kept == header.channels && (!has_alpha || header.alpha_channel == kept - 1)) {
    std::memcpy(to, samples.data(), samples.size());
    return;
  }
  const std::size_t bytes = size_of(header.type), texel_bytes = bytes * static_cast<std::size_t>(header.channels);
  const std::size_t color_bytes = bytes * static_cast<std::size_t>(kept - (has_alpha ? 1 : 0));
  for (std::size_t first = 0; first < samples.size(); first += texel_bytes) {
    const std::byte* from = samples.data() + first;
    std::memcpy(to, from, color_bytes);
    to += color_bytes;
    if (!has_alpha) continue;
    std::memcpy(to, from + bytes * static_cast<std::size_t>(header.alpha_channel), bytes);
    to += bytes;
  }
}

bool is_opaque(const ImageFileHeader& header, const std::vector<std::byte>& samples) {
  if (header.alpha_channel < 0) return true;
  const TexelDecoder decoder(header.type, {});
  const std::size_t count = samples.size() / size_of(header.type);
  for (auto i = static_cast<std::size_t>(header.alpha_channel); i < count;
       i += static_cast<std::size_t>(header.channels)) {
    if (decoder.alpha(samples.data(), i) != 1) return false;
  }
  return true;
}

}  // namespace glowworm
