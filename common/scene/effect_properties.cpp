#include "common/scene/effect_properties.h"

#include <algorithm>
#include <type_traits>

namespace haptics {
namespace {

void addValue(Hasher& h, const std::vector<Vec3>& points) {
  h.add(static_cast<std::uint64_t>(3 * points.size()));
  for (const Vec3& point : points) h.add(point);
}

void addValue(Hasher& h, const std::vector<float>& samples) {
  h.add(static_cast<std::uint64_t>(samples.size()));
  for (const float sample : samples) h.add(static_cast<double>(sample));
}

void addValue(Hasher& h, const std::vector<double>& numbers) {
  h.add(static_cast<std::uint64_t>(numbers.size()));
  for (const double number : numbers) h.add(number);
}

template <class T>
void addValue(Hasher& h, const T& value) {
  if constexpr (std::is_enum_v<T>) {
    h.add(static_cast<std::uint64_t>(value));
  } else {
    h.add(value);
  }
}

}  // namespace

void addTo(Hasher& h, const std::vector<Effect>& effects) {
  constexpr std::uint64_t kEffects = 14, kTriggers = 15, kLater = 16;  // beyond the numbers of all other properties
  constexpr std::size_t kTrigger = 16;                                 // place of the member; numbers count from 1
  if (effects.empty()) return;
  h.add(kEffects).add(static_cast<std::uint64_t>(effects.size()));
  for (const Effect& effect : effects) {
    fields::forEachMember(
        [&](std::size_t i, const auto& value) {
          if (i < kTrigger) addValue(h, value);
        },
        effect);
  }
  const auto waits = [](const Effect& effect) { return effect.trigger != Effect::Trigger::kAlways; };
  if (std::ranges::any_of(effects, waits)) {
    h.add(kTriggers);
    for (const Effect& effect : effects) addValue(h, effect.trigger);
  }
  for (std::size_t number = 0; number < effects.size(); ++number) {
    fields::forEachMember(
        [&]<class T>(std::size_t i, const T& value) {
          if (i <= kTrigger || value == T{}) return;
          h.add(kLater).add(static_cast<std::uint64_t>(number)).add(static_cast<std::uint64_t>(i + 1));
          addValue(h, value);
        },
        effects[number]);
  }
}

}  // namespace haptics
