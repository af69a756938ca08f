// The named scenarios.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "vision/synthetic/scene.h"
#include "vision/synthetic/scene_builder.h"

namespace egosieve::vision {

struct SceneRecipe {
  std::string_view name;
  std::string_view summary;
  void (*build)(SceneBuilder& scene);
};

const std::vector<SceneRecipe>& Recipes();
// Null if there is no scenario of that name.
const SceneRecipe* FindRecipe(std::string_view name);
Scene BuildScene(const SceneRecipe& recipe, uint64_t seed, double duration_seconds);

}  // namespace egosieve::vision
