// Contents of a public scene.
#pragma once
#include <memory>
#include <utility>

#include "glowworm/scene.h"
#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm::api {

struct Scene::Implementation {
  explicit Implementation(SceneDescription description)
      : scene(std::make_shared<const glowworm::Scene>(std::move(description))),
        traced(scene),
        tracer(std::make_shared<const glowworm::Tracer>(*traced)) {}
  /// The scene with more cameras, which the tracer does not know of.
  Implementation(const Implementation& other, SceneEdit edit)
      : scene(std::make_shared<const glowworm::Scene>(*other.scene, std::move(edit))),
        traced(other.traced),
        tracer(other.tracer) {}

  std::shared_ptr<const glowworm::Scene> scene, traced;  ///< `traced` is the tracer's
  std::shared_ptr<const glowworm::Tracer> tracer;
};

}  // namespace glowworm::api
