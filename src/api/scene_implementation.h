// Contents of a public scene.
#pragma once
#include <memory>

#include "glowworm/scene.h"
#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm::api {

struct Scene::Implementation {
  explicit Implementation(SceneDescription description)
      : scene(std::make_shared<const glowworm::Scene>(std::move(description))),
        tracer(std::make_shared<const Tracer>(*scene)) {}

  std::shared_ptr<const glowworm::Scene> scene;
  std::shared_ptr<const Tracer> tracer;
};

}  // namespace glowworm::api
