#include "common/json/json.h"

#include <nlohmann/json.hpp>

namespace haptics {
namespace {

template <class Value>
[[nodiscard]] std::string written(const Value& value) {
  return nlohmann::json(value).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

Json::Json(bool value) : text_(value ? "true" : "false") {}
Json::Json(double value) : text_(written(value)) {}
Json::Json(std::string_view text) : text_(written(text)) {}

Json::Json(std::initializer_list<std::pair<std::string_view, Json>> members) : text_("{}") {
  for (const auto& [name, value] : members) set(name, value);
}

Json Json::array(std::initializer_list<Json> elements) {
  Json array{};
  array.text_ = "[]";
  for (const Json& element : elements) array.push(element);
  return array;
}

void Json::set(std::string_view name, const Json& value) { append(written(name) + ':' + value.text_); }
void Json::push(const Json& value) { append(value.text_); }

/// Before the bracket that closes it.
void Json::append(const std::string& part) {
  constexpr std::size_t kEmpty = 2;
  text_.insert(text_.size() - 1, text_.size() == kEmpty ? part : ',' + part);
}

std::string Json::indented() const { return nlohmann::ordered_json::parse(text_).dump(2, ' ', true); }

}  // namespace haptics
