// Views by OpenColorIO. The program loads this module only for --ocio, so it runs where OpenColorIO is not installed.
#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "image/color_view.h"

namespace glowworm {

namespace {

namespace ocio = OCIO_NAMESPACE;

/// Linear Rec. 709 (D65) to ACES2065-1 (white of about D60), by rows; Bradford adaptation. From the transform
/// "Utility - Linear - Rec.709" of the ACES configs (Academy S-2014-004 for the primaries).
constexpr double kToAces[16] = {0.439632981919,
                                0.382988698152,
                                0.177378319929,
                                0,  //
                                0.089776442959,
                                0.813439428749,
                                0.096784128292,
                                0,  //
                                0.017541170383,
                                0.111546553302,
                                0.870912276314,
                                0,  //
                                0,
                                0,
                                0,
                                1};

/// The names as a list for a message.
template <typename Name>
std::string listed(int count, const Name& name) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + std::string(name(i));
  return text.empty() ? "none" : text;
}

/// Whether a list has a name.
template <typename Name>
bool has(const std::string& wanted, int count, const Name& name) {
  for (int i = 0; i < count; ++i)
    if (wanted == name(i)) return true;
  return false;
}

class ConfigView final : public ColorView {
 public:
  ConfigView(ocio::ConstCPUProcessorRcPtr processor, std::string name)
      : processor_(std::move(processor)), name_(std::move(name)) {}

  void apply(std::span<RGB> pixels) const override {
    if (pixels.empty()) return;
    ocio::PackedImageDesc image(pixels.data(), static_cast<long>(pixels.size()), 1, 3);
    processor_->apply(image);
  }
  std::string name() const override { return name_; }

 private:
  ocio::ConstCPUProcessorRcPtr processor_;
  std::string name_;
};

/// Linear Rec. 709 to the view of the display.
ocio::ConstTransformRcPtr transform_to(const ocio::Config& config, const std::string& display,
                                       const std::string& view) {
  const ocio::GroupTransformRcPtr group = ocio::GroupTransform::Create();
  const bool has_aces = config.hasRole(ocio::ROLE_INTERCHANGE_SCENE);
  if (has_aces) {
    const ocio::MatrixTransformRcPtr matrix = ocio::MatrixTransform::Create();
    matrix->setMatrix(kToAces);
    group->appendTransform(matrix);
  }
  const ocio::DisplayViewTransformRcPtr shown = ocio::DisplayViewTransform::Create();
  shown->setSrc(has_aces ? ocio::ROLE_INTERCHANGE_SCENE : ocio::ROLE_SCENE_LINEAR);
  shown->setDisplay(display.c_str());
  shown->setView(view.c_str());
  group->appendTransform(shown);
  return group;
}

ColorView* open(const ColorViewRequest& request, ColorViewFailure& failure) {
  ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);  // failures are told once, by the program
  const ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(request.config.c_str());
  const auto display_name = [&](int i) { return config->getDisplay(i); };
  const std::string display = request.display.empty() ? config->getDefaultDisplay() : request.display;
  if (!has(display, config->getNumDisplays(), display_name)) {
    failure.what = "the config has no display '" + display + "'";
    failure.advice = "Its displays: " + listed(config->getNumDisplays(), display_name) + ".";
    return nullptr;
  }
  const int views = config->getNumViews(display.c_str());
  const auto view_name = [&](int i) { return config->getView(display.c_str(), i); };
  const std::string view = request.view.empty() ? config->getDefaultView(display.c_str()) : request.view;
  if (!has(view, views, view_name)) {
    failure.what = "the display '" + display + "' of the config has no view '" + view + "'";
    failure.advice = "Its views: " + listed(views, view_name) + ".";
    return nullptr;
  }
  if (!config->hasRole(ocio::ROLE_INTERCHANGE_SCENE) && !config->hasRole(ocio::ROLE_SCENE_LINEAR)) {
    failure.what = "the config has neither the role aces_interchange nor scene_linear, by which pixels enter it";
    failure.advice = "Add 'scene_linear' to its roles, with the name of its linear space of Rec. 709 primaries.";
    return nullptr;
  }
  const ocio::ConstProcessorRcPtr processor = config->getProcessor(transform_to(*config, display, view));
  return new ConfigView(processor->getDefaultCPUProcessor(), view + " on " + display);
}

}  // namespace

}  // namespace glowworm

extern "C" __attribute__((visibility("default"))) glowworm::ColorView* glowworm_open_color_view(
    const glowworm::ColorViewRequest& request, glowworm::ColorViewFailure& failure) {
  try {
    return glowworm::open(request, failure);
  } catch (const std::exception& error) {
    failure.what = error.what();
    std::replace(failure.what.begin(), failure.what.end(), '\n', ' ');
    failure.advice = "Give --ocio a config of OpenColorIO 2.1 or older, usually named config.ocio.";
    return nullptr;
  }
}
