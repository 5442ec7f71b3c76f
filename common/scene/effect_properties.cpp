#include "common/scene/effect_properties.h"

#include <algorithm>
#include <type_traits>

namespace haptics {

void addTo(Hasher& h, const std::vector<Effect>& effects) {
  constexpr std::uint64_t kEffects = 14, kTriggers = 15;  // beyond the numbers of all other properties
  if (effects.empty()) return;
  h.add(kEffects).add(static_cast<std::uint64_t>(effects.size()));
  const auto add = [&h]<class T>(std::size_t, const T& value) {
    if constexpr (std::is_same_v<T, Effect::Trigger>) {
      return;
    } else if constexpr (std::is_enum_v<T>) {
      h.add(static_cast<std::uint64_t>(value));
    } else if constexpr (std::is_same_v<T, std::vector<Vec3>>) {
      h.add(static_cast<std::uint64_t>(3 * value.size()));
      for (const Vec3& point : value) h.add(point);
    } else {
      h.add(value);
    }
  };
  for (const Effect& effect : effects) fields::forEachMember(add, effect);
  const auto waits = [](const Effect& effect) { return effect.trigger != Effect::Trigger::kAlways; };
  if (std::ranges::none_of(effects, waits)) return;
  h.add(kTriggers);
  for (const Effect& effect : effects) h.add(static_cast<std::uint64_t>(effect.trigger));
}

}  // namespace haptics
