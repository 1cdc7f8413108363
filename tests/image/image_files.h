// Fixture of tests that write and read picture files.
#pragma once
#include <OpenImageIO/imageio.h>

#include <fstream>

#include "core/random.h"
#include "image/image.h"
#include "support/temporary_folder.h"

namespace glowworm {

/// Test files in a temporary folder.
class ImageFiles : public FolderTest {
 protected:
  // 37 x 23: no side is a multiple of a block of any codec.
  static constexpr int kWidth = 37, kHeight = 23;
  static Image make_image() {
    Image image(kWidth, kHeight);
    Sampler sampler(SamplerKind::independent, 1, 2, 3);
    std::vector<RGB> beauty(image.pixel_count());
    std::vector<Vec3> normal(image.pixel_count());
    std::vector<float> depth(image.pixel_count());
    for (std::size_t i = 0; i < beauty.size(); ++i) {
      beauty[i] = {sampler.next1() * 10, sampler.next1(), sampler.next1() * 1e-3f};
      normal[i] = {sampler.next1() - 0.5f, sampler.next1() - 0.5f, sampler.next1() - 0.5f};
      depth[i] = 1e5f * (1 + sampler.next1());
    }
    image.add_rgb("", beauty);
    image.add_rgb("albedo", beauty);
    image.add_vec3("normal", normal);
    image.add_scalar("depth.Z", depth);
    image.metadata["glowworm:seed"] = "42";
    image.metadata["Software"] = "glowworm test";
    return image;
  }
  void write_bytes(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  std::string read_bytes(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // Writes an 8-bit file of any format through the library itself.
  void write_foreign(const std::string& name, int width, int height, int channels,
                     const std::vector<std::uint8_t>& samples) const {
    const auto output = OIIO::ImageOutput::create(name);
    ASSERT_TRUE(output);
    ASSERT_TRUE(output->open(path(name), OIIO::ImageSpec(width, height, channels, OIIO::TypeDesc::UINT8)));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, samples.data()));
    ASSERT_TRUE(output->close());
  }
};

}  // namespace glowworm
