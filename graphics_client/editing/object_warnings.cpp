#include "graphics_client/editing/object_warnings.h"

#include <string_view>

namespace haptics {
namespace {

std::string propertiesOf(v1::ObjectState object) {
  object.clear_id();
  object.clear_revision();
  object.clear_pose();
  object.clear_color();
  return object.SerializeAsString();
}

}  // namespace

void ObjectWarnings::add(const v1::Accepted& accepted) {
  constexpr std::string_view kWarning = ": warning: ";  // after the name, which has no colon
  for (const v1::ObjectState& object : accepted.object()) {
    Known& known = known_[object.name()];
    std::string properties = propertiesOf(object);
    if (properties == known.warnedOf) continue;
    known = {std::move(properties), {}};
    const std::string prefix = object.name() + std::string(kWarning);
    for (const std::string& line : accepted.report()) {
      if (line.starts_with(prefix)) known.warnings.push_back(line.substr(prefix.size()));
    }
  }
}

const std::vector<std::string>& ObjectWarnings::of(const std::string& object) const {
  static const std::vector<std::string> kNone;
  const auto known = known_.find(object);
  return known == known_.end() ? kNone : known->second.warnings;
}

}  // namespace haptics
