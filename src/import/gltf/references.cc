#include "import/gltf/references.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

namespace glowworm {

void for_places(nlohmann::json& at, std::string_view place, const std::string& where,
                const std::function<void(nlohmann::json& value, const std::string& name)>& visit,
                const std::function<void(const std::string& name, const char* type)>& wrong) {
  if (place.empty()) return visit(at, where);
  const auto behind = [&](std::size_t end) { return place.substr(end + (place.substr(end).starts_with('.') ? 1 : 0)); };
  if (place.starts_with("[]")) {
    if (!at.is_array()) return wrong(where, "list");
    for (std::size_t i = 0; i < at.size(); ++i)
      for_places(at[i], behind(2), fmt::format("{}[{}]", where, i), visit, wrong);
    return;
  }
  if (!at.is_object()) return wrong(where, "object");
  const std::size_t end = std::min(place.find_first_of(".["), place.size());
  const std::string key(place.substr(0, end));
  const auto enter = [&](nlohmann::json& value, const std::string& name) {
    for_places(value, behind(end), where.empty() ? name : fmt::format("{}.{}", where, name), visit, wrong);
  };
  if (key == "*")
    for (auto member = at.begin(); member != at.end(); ++member) enter(*member, member.key());
  else if (const auto found = at.find(key); found != at.end())
    enter(*found, key);
}

}  // namespace glowworm
