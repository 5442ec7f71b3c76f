#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

// The state of the step as a list of fields. Each of its structs names its members once, in order, by HAPTICS_FIELDS(self.a,
// self.b); from that come copies of what is in use, images and their validation, and the first field in which two states
// differ. Every field is an arithmetic type, or an array or struct of such; isListed() fails where a member is not named, or
// where a byte lies between two.
namespace haptics {

#define HAPTICS_FIELDS(...)                                                                                            \
  [[nodiscard]] static constexpr auto fieldsOf([[maybe_unused]] auto& self) noexcept { return std::tie(__VA_ARGS__); } \
  static constexpr std::string_view kFieldNames = #__VA_ARGS__

/// A flag, a small number, or an enumerator of those up to lastOf(T) in eight bytes.
template <class T>
class Word {
 public:
  constexpr Word(T value = T{}) noexcept : value_(static_cast<std::uint64_t>(value)) {}
  constexpr operator T() const noexcept { return static_cast<T>(value_); }

  [[nodiscard]] constexpr bool isValid() const noexcept {
    if constexpr (std::is_enum_v<T>) {
      return value_ <= static_cast<std::uint64_t>(lastOf(T{}));
    } else {
      return value_ == static_cast<std::uint64_t>(static_cast<T>(value_));
    }
  }

 private:
  std::uint64_t value_;
};

/// Up to N items, of which those beyond the count are neither copied nor recorded.
template <class T, std::size_t N>
struct Sequence {
  std::uint64_t count = 0;
  std::array<T, N> items;

  [[nodiscard]] std::span<T> all() noexcept { return {items.data(), count}; }
  [[nodiscard]] std::span<const T> all() const noexcept { return {items.data(), count}; }
  [[nodiscard]] T& operator[](std::size_t i) noexcept { return items[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return items[i]; }
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return N; }
};

namespace fields {

template <class T>
struct Kind {
  static constexpr bool isLeaf = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
};
template <class T>
struct Kind<Word<T>> {
  static constexpr bool isLeaf = true;
};
template <glm::length_t L, class T, glm::qualifier Q>
struct Kind<glm::vec<L, T, Q>> {
  static constexpr bool isLeaf = sizeof(glm::vec<L, T, Q>) == L * sizeof(T);
};
template <class T, glm::qualifier Q>
struct Kind<glm::qua<T, Q>> {
  static constexpr bool isLeaf = sizeof(glm::qua<T, Q>) == 4 * sizeof(T);
};

template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsSequence : std::false_type {};
template <class T, std::size_t N>
struct IsSequence<Sequence<T, N>> : std::true_type {};
template <class T>
struct IsWord : std::false_type {};
template <class T>
struct IsWord<Word<T>> : std::true_type {};

template <class T>
inline constexpr bool kIsList = IsArray<T>::value || IsSequence<T>::value;

/// The items in use.
[[nodiscard]] constexpr auto itemsOf(auto& list) noexcept {
  if constexpr (IsSequence<std::remove_cvref_t<decltype(list)>>::value) {
    return list.all();
  } else {
    return std::span(list);
  }
}

[[nodiscard]] constexpr auto fieldsOf(auto& value) noexcept {
  return std::remove_cvref_t<decltype(value)>::fieldsOf(value);
}

template <class T>
[[nodiscard]] consteval bool isListed();

template <class... Field>
[[nodiscard]] consteval bool areListed(std::type_identity<std::tuple<Field&...>>, std::size_t size) {
  return (isListed<std::remove_const_t<Field>>() && ...) && (sizeof(Field) + ...) == size;
}

/// Every member is named, and no byte lies between them.
template <class T>
[[nodiscard]] consteval bool isListed() {
  if constexpr (Kind<T>::isLeaf) {
    return true;
  } else if constexpr (IsSequence<T>::value) {
    using Item = typename decltype(T::items)::value_type;
    return isListed<Item>() && sizeof(T) == sizeof(std::uint64_t) + T::capacity() * sizeof(Item);
  } else if constexpr (IsArray<T>::value) {
    return isListed<typename T::value_type>();
  } else {
    return areListed(std::type_identity<decltype(fieldsOf(std::declval<T&>()))>(), sizeof(T));
  }
}

template <class T>
[[nodiscard]] consteval bool hasSequence() {
  if constexpr (Kind<T>::isLeaf) {
    return false;
  } else if constexpr (IsSequence<T>::value) {
    return true;
  } else if constexpr (IsArray<T>::value) {
    return hasSequence<typename T::value_type>();
  } else {
    return []<class... Field>(std::type_identity<std::tuple<Field&...>>) {
      return (hasSequence<std::remove_const_t<Field>>() || ...);
    }(std::type_identity<decltype(fieldsOf(std::declval<T&>()))>());
  }
}

/// Calls visit(a, b...) for the members of structs of one type.
template <class Visit, class... T>
constexpr void forEachMember(Visit&& visit, T&... values) {
  const auto lists = std::make_tuple(fieldsOf(values)...);
  constexpr std::size_t kCount = std::tuple_size_v<std::tuple_element_t<0, std::remove_const_t<decltype(lists)>>>;
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    const auto at = [&]<std::size_t i>(std::integral_constant<std::size_t, i>) {
      std::apply([&](const auto&... list) { visit(i, std::get<i>(list)...); }, lists);
    };
    (at(std::integral_constant<std::size_t, I>()), ...);
  }
  (std::make_index_sequence<kCount>());
}

/// " 0.1 -0 3"
template <class T>
[[nodiscard]] std::string valueOf(const T& value) {
  if constexpr (IsWord<T>::value) {
    return ' ' + std::to_string(std::bit_cast<std::uint64_t>(value));
  } else if constexpr (std::is_arithmetic_v<T>) {
    std::array<char, 32> text{};
    std::to_chars(text.data(), text.data() + text.size() - 1, value);
    return ' ' + std::string(text.data());
  } else {
    std::string all;
    for (glm::length_t i = 0; i < T::length(); ++i) all += valueOf(value[i]);
    return all;
  }
}

/// The i-th name of a list that HAPTICS_FIELDS has: "self.a, self.b".
[[nodiscard]] constexpr std::string_view nameOf(std::string_view names, std::size_t i) noexcept {
  constexpr std::string_view kSelf = "self.";
  for (; i > 0; --i) names.remove_prefix(names.find(',') + 1);
  names.remove_prefix(names.find(kSelf) + kSelf.size());
  return names.substr(0, names.find_first_of(", "));
}

}  // namespace fields

/// Becomes a copy of another as far as that is in use.
template <class T>
void copyInUse(T& to, const T& from) noexcept {
  if constexpr (!fields::hasSequence<T>()) {
    to = from;
  } else if constexpr (fields::kIsList<T>) {
    if constexpr (fields::IsSequence<T>::value) to.count = from.count;
    const auto items = fields::itemsOf(from);
    for (std::size_t i = 0; i < items.size(); ++i) copyInUse(to[i], items[i]);
  } else {
    fields::forEachMember([](std::size_t, auto& a, const auto& b) { copyInUse(a, b); }, to, from);
  }
}

/// Appends the bytes of what is in use.
template <class T>
void putFields(std::string& image, const T& value) {
  static_assert(fields::isListed<T>());
  if constexpr (!fields::hasSequence<T>()) {
    image.append(reinterpret_cast<const char*>(&value), sizeof value);
  } else if constexpr (fields::kIsList<T>) {
    if constexpr (fields::IsSequence<T>::value) putFields(image, value.count);
    for (const auto& item : fields::itemsOf(value)) putFields(image, item);
  } else {
    fields::forEachMember([&](std::size_t, const auto& field) { putFields(image, field); }, value);
  }
}

/// Whether flags and enumerators are such.
template <class T>
[[nodiscard]] bool areValid(const T& value) noexcept {
  if constexpr (fields::IsWord<T>::value) {
    return value.isValid();
  } else if constexpr (fields::Kind<T>::isLeaf) {
    return true;
  } else if constexpr (fields::kIsList<T>) {
    return std::ranges::all_of(fields::itemsOf(value), [](const auto& item) { return areValid(item); });
  } else {
    bool valid = true;
    fields::forEachMember([&](std::size_t, const auto& field) { valid = valid && areValid(field); }, value);
    return valid;
  }
}

/// Takes them from the image's front. False: it ends before, or holds what no state has.
template <class T>
[[nodiscard]] bool takeFields(std::string_view& image, T& value) noexcept {
  if constexpr (!fields::hasSequence<T>()) {
    if (image.size() < sizeof value) return false;
    std::memcpy(static_cast<void*>(&value), image.data(), sizeof value);
    image.remove_prefix(sizeof value);
    return areValid(value);
  } else if constexpr (fields::kIsList<T>) {
    if constexpr (fields::IsSequence<T>::value) {
      if (!takeFields(image, value.count) || value.count > value.capacity()) return false;
    }
    return std::ranges::all_of(fields::itemsOf(value), [&](auto& item) { return takeFields(image, item); });
  } else {
    bool taken = true;
    fields::forEachMember([&](std::size_t, auto& field) { taken = taken && takeFields(image, field); }, value);
    return taken;
  }
}

/// The first field of which two states have other bits, with its values: ".contact.ihip 0 0 0.1, 0 0 0.2"; empty: there is
/// none.
template <class T>
[[nodiscard]] std::string firstDifference(const T& a, const T& b) {
  if constexpr (fields::Kind<T>::isLeaf) {
    return std::memcmp(&a, &b, sizeof a) == 0 ? "" : fields::valueOf(a) + ',' + fields::valueOf(b);
  } else if constexpr (fields::kIsList<T>) {
    const auto x = fields::itemsOf(a), y = fields::itemsOf(b);
    if (x.size() != y.size()) return ".count";
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (const std::string in = firstDifference(x[i], y[i]); !in.empty()) return '[' + std::to_string(i) + ']' + in;
    }
    return "";
  } else {
    std::string first;
    fields::forEachMember(
        [&](std::size_t i, const auto& x, const auto& y) {
          if (!first.empty()) return;
          const std::string in = firstDifference(x, y);
          if (in.empty()) return;
          first = '.' + std::string(fields::nameOf(T::kFieldNames, i)) + in;
        },
        a, b);
    return first;
  }
}

/// Of what tells builds apart: sizes and names of all fields.
template <class T>
[[nodiscard]] constexpr std::uint64_t layoutOf(std::uint64_t seed = 14695981039346656037U) noexcept {
  constexpr std::uint64_t kPrime = 1099511628211U;
  const auto mix = [&](std::uint64_t value) { seed = (seed ^ value) * kPrime; };
  mix(sizeof(T));
  if constexpr (fields::IsSequence<T>::value) {
    return layoutOf<typename decltype(T::items)::value_type>(seed);
  } else if constexpr (fields::IsArray<T>::value) {
    return layoutOf<typename T::value_type>(seed);
  } else if constexpr (!fields::Kind<T>::isLeaf) {
    for (const char c : T::kFieldNames) mix(static_cast<unsigned char>(c));
    return [&]<class... Field>(std::type_identity<std::tuple<Field&...>>) {
      ((seed = layoutOf<std::remove_const_t<Field>>(seed)), ...);
      return seed;
    }(std::type_identity<decltype(fields::fieldsOf(std::declval<T&>()))>());
  }
  return seed;
}

}  // namespace haptics
