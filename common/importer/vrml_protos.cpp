#include "common/importer/vrml_protos.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace haptics {
namespace {

/// What a field has where nobody says; of lists: nothing. Source: ISO/IEC 14772-1, 5 (field reference).
std::string_view defaultOf(std::string_view type) {
  for (const auto& [name, value] : {std::pair<std::string_view, std::string_view>{"SFBool", "FALSE"},
                                    {"SFColor", "0 0 0"},
                                    {"SFFloat", "0"},
                                    {"SFImage", "0 0 0"},
                                    {"SFInt32", "0"},
                                    {"SFNode", "NULL"},
                                    {"SFRotation", "0 0 1 0"},
                                    {"SFString", "\"\""},
                                    {"SFTime", "0"},
                                    {"SFVec2f", "0 0"},
                                    {"SFVec3f", "0 0 0"}}) {
    if (type == name) return value;
  }
  return "[]";
}

/// Words, strings with their quotes, and brackets, without comments.
class VrmlWords {
 public:
  explicit VrmlWords(std::string_view text) : text_(text) {}

  [[nodiscard]] std::size_t at() const { return at_; }

  /// Empty: there is no more.
  std::string_view next() {
    constexpr std::string_view kBetween = " \t\r\n,", kAlone = "[]{}";
    while ((at_ = std::min(text_.find_first_not_of(kBetween, at_), text_.size())) < text_.size() && text_[at_] == '#')
      at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
    if (at_ == text_.size()) return {};
    const std::size_t from = at_++;
    if (text_[from] == '"') {
      while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
      at_ = std::min(at_ + 1, text_.size());
    } else if (kAlone.find(text_[from]) == kAlone.npos) {
      at_ = std::min(text_.find_first_of(" \t\r\n,[]{}\"#", from), text_.size());
    }
    return text_.substr(from, at_ - from);
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

struct ExternProto {
  std::string_view name;
  std::vector<std::string_view> fields;  ///< Three words each: kind, type, name.
  std::vector<std::string> urls;         ///< As they are written, without quotes.
  std::size_t urlsAt = 0, end = 0;
};

/// @param words  Behind the keyword. Nothing: it is damaged, which the reader says.
std::optional<ExternProto> protoIn(VrmlWords& words) {
  ExternProto proto{.name = words.next(), .fields = {}, .urls = {}};
  if (words.next() != "[") return std::nullopt;
  std::string_view word;
  while ((word = words.next()) != "]" && !word.empty()) proto.fields.push_back(word);
  proto.urlsAt = words.at();
  word = words.next();
  const bool isList = word == "[";
  if (isList) word = words.next();
  while (word.size() > 1 && word.front() == '"') {
    proto.urls.emplace_back(word.substr(1, word.size() - 2));
    proto.end = words.at();
    if (!isList) break;
    word = words.next();
    if (word == "]") proto.end = words.at();
  }
  if (proto.urls.empty() || proto.fields.size() % 3 != 0) return std::nullopt;
  return proto;
}

std::string emptyOf(const ExternProto& proto) {
  std::string text = "PROTO " + std::string(proto.name) + " [";
  for (std::size_t i = 0; i + 2 < proto.fields.size(); i += 3) {
    const std::string_view kind = proto.fields[i], type = proto.fields[i + 1];
    text.append(" ").append(kind).append(" ").append(type).append(" ").append(proto.fields[i + 2]);
    if (kind == "field" || kind == "exposedField") text.append(" ").append(defaultOf(type));
  }
  return text + " ] { Group { } }";
}

}  // namespace

VrmlProtos withProtosThatAreThere(std::string_view text, const std::function<bool(const std::string&)>& isThere) {
  VrmlProtos found;
  constexpr std::string_view kKeyword = "EXTERNPROTO";
  if (text.find(kKeyword) == text.npos) return {std::string(text)};
  std::size_t taken = 0;
  VrmlWords words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word != kKeyword) continue;
    const std::size_t from = words.at() - kKeyword.size();
    const auto proto = protoIn(words);
    if (!proto) continue;
    const auto url = std::ranges::find_if(proto->urls, [&](const std::string& each) {
      const std::string file = each.substr(0, each.find('#'));
      return !file.empty() && file.find("://") == file.npos && !file.starts_with("urn:") && isThere(file);
    });
    if (url != proto->urls.end()) {
      found.text.append(text.substr(taken, proto->urlsAt - taken)).append(" \"" + *url + '"');
    } else {
      found.missing.push_back(proto->urls.back());
      found.text.append(text.substr(taken, from - taken)).append(emptyOf(*proto));
    }
    taken = proto->end;
  }
  found.text.append(text.substr(taken));
  return found;
}

}  // namespace haptics
