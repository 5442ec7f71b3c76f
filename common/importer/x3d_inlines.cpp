#include "common/importer/x3d_inlines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/unpacked.h"
#include "common/importer/x3d_classic.h"
#include "common/importer/xml_text.h"

namespace haptics {
namespace {

/// The names in a url, an MFString or one string without quotes.
std::vector<std::string> namesIn(std::string_view url) {
  const std::string text = withoutEntities(url);
  if (text.find('"') == text.npos) return {text};
  std::vector<std::string> names;
  for (std::size_t at = 0; (at = text.find('"', at)) != text.npos;) {
    const std::size_t end = text.find('"', at + 1);
    if (end == text.npos) break;
    names.push_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return names;
}

double metresOf(std::string_view file) {
  double metres = 1;
  eachTag(file, [&](const XmlTag& tag) {
    if (tag.name == "unit" && attributeIn(tag.inside, "category") == "length")
      metres = numberOf<double>(attributeIn(tag.inside, "conversionFactor")).value_or(1);
    return tag.name != "Scene";
  });
  return metres > 0 && std::isfinite(metres) ? metres : 1;
}

/// ISO/IEC 19775-1, 9.4.2.
class Inlining {
 public:
  Inlining(const IncludeReader& readIncluded, std::size_t most) : readIncluded_(readIncluded), left_(most) {}

  /// @param folder  Of the file, in that of the one that is imported.
  Result<std::string> into(const std::string& file, const std::filesystem::path& folder) {
    const double metres = metresOf(file);
    XmlRewriting rewriting(file);
    std::string endName;  // of an Inline that holds something
    eachTag(file, [&](const XmlTag& tag) {
      if (tag.name != "Inline") return true;
      if (tag.ends) {
        if (!endName.empty()) rewriting.replace(tag.name, std::exchange(endName, {}));
        return true;
      }
      const Scene* const scene = sceneOf(tag, folder);
      if (!fault_.empty()) return false;
      if (scene == nullptr) return true;
      if (scene->nodes.size() > left_) {
        fault_ = "has Inlines that make many times the files' bytes";
        return false;
      }
      left_ -= scene->nodes.size();
      rewriting.replace(tag.name, "Group");
      std::string nodes = scene->nodes;
      if (scene->metres != metres) {
        char digits[32];
        const std::string word(digits, std::to_chars(digits, digits + sizeof digits, scene->metres / metres).ptr);
        nodes = "<Transform scale=\"" + word + ' ' + word + ' ' + word + "\">" + nodes + "</Transform>";
      }
      if (tag.inside.ends_with('/')) {
        rewriting.replace(tag.inside.substr(tag.inside.size() - 1), '>' + nodes + "</Group");
      } else {
        rewriting.insertAfter(tag, nodes);
        endName = "Group";
      }
      return true;
    });
    if (!fault_.empty()) return refused("", fault_);
    return rewriting.end();
  }

  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  struct Scene {
    std::string nodes;
    double metres = 1;
  };

  /// What an Inline shows; null: nothing that is here, or what it is part of.
  const Scene* sceneOf(const XmlTag& tag, const std::filesystem::path& folder) {
    if (isFalse(tag.inside, "load")) return nullptr;
    for (std::string& name : namesIn(attributeIn(tag.inside, "url"))) {
      name.resize(std::min(name.find('#'), name.size()));
      if (name.empty() || name.find("://") != name.npos) continue;
      const std::string path = (folder / name).lexically_normal().string();
      const auto [at, isNew] = scenes_.try_emplace(path);
      if (isNew) at->second = read(path, scenes_.size());
      if (at->second) return &*at->second;
    }
    return nullptr;
  }

  std::optional<Scene> read(const std::string& path, std::size_t number) {
    auto bytes = readIncluded_(path);
    if (!bytes || deep_ >= kDeepest) return std::nullopt;
    bytes_ += bytes->size();
    ++deep_;
    auto text = unpacked(*std::move(bytes)).and_then(x3dInXml).and_then([&](const std::string& file) {
      return into(file, std::filesystem::path(path).parent_path());
    });
    --deep_;
    auto nodes = text ? nodesOf(*text, "inline" + std::to_string(number) + ".") : std::nullopt;
    if (!nodes) return std::nullopt;
    return Scene{*std::move(nodes), metresOf(*text)};
  }

  /// What is in the scene, with names of its own; nothing: there is none, or it is cut off.
  static std::optional<std::string> nodesOf(const std::string& file, const std::string& prefix) {
    std::optional<std::size_t> from, to;
    XmlRewriting rewriting(file);
    std::size_t added = 0;
    eachTag(file, [&](const XmlTag& tag) {
      if (tag.name == "Scene") {
        if (!tag.ends) from = tag.begin + rewriting.whole(tag).size();
        if (tag.ends) to = tag.begin;
        if (tag.inside.ends_with('/')) to = from;
        return !to;
      }
      if (!from) return true;
      for (const std::string_view name : {"DEF", "USE"}) {
        const std::string_view value = attributeIn(tag.inside, name);
        if (value.empty()) continue;
        rewriting.replace(value.substr(0, 0), prefix);
        added += prefix.size();
      }
      return true;
    });
    if (!from || !to) return std::nullopt;
    return rewriting.end().substr(*from, *to - *from + added);
  }

  static constexpr int kDeepest = 20;

  const IncludeReader& readIncluded_;
  std::size_t left_, bytes_ = 0;
  int deep_ = 0;
  std::string fault_;
  std::map<std::string, std::optional<Scene>> scenes_;  ///< By path; nothing: none, or it is being read.
};

}  // namespace

Result<InlinedX3d> withInlines(const std::string& file, const IncludeReader& readIncluded) {
  Inlining inlining(readIncluded, 64'000'000 + 4 * file.size());
  return inlining.into(file, {}).map([&](std::string text) { return InlinedX3d{std::move(text), inlining.bytes()}; });
}

}  // namespace haptics
