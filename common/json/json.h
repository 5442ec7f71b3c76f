#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace haptics {

/// A JSON value to be written (RFC 8259), kept as its text. nlohmann's library writes numbers and strings; its header, some 2 s
/// of a compilation, stays in the source file.
class Json {
 public:
  Json(bool value);
  Json(double value);  ///< Null where it is not finite.
  Json(std::string_view text);
  Json(const std::string& text) : Json(std::string_view(text)) {}
  Json(const char* text) : Json(std::string_view(text)) {}
  template <std::integral Number>
  Json(Number value) : text_(std::to_string(value)) {}
  Json(std::initializer_list<std::pair<std::string_view, Json>> members);  ///< An object; names are not repeated.

  [[nodiscard]] static Json array(std::initializer_list<Json> elements = {});

  void set(std::string_view name, const Json& value);  ///< Of an object; the name is a new one.
  void push(const Json& value);                        ///< Of an array.

  /// On one line, for a terminal too: what is not ASCII is escaped, and what is not UTF-8 replaced.
  [[nodiscard]] const std::string& line() const noexcept { return text_; }
  [[nodiscard]] std::string indented() const;

 private:
  void append(const std::string& part);

  std::string text_;
};

}  // namespace haptics
