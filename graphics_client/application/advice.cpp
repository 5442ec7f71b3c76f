#include "graphics_client/application/advice.h"

#include <nlohmann/json.hpp>

#include "common/text/grouped.h"

namespace haptics {
namespace {

using Json = nlohmann::json;

/// What was found of one object.
struct Found {
  std::size_t own = 0, advised = 0;  ///< Triangles; points of a tool.
  bool isTool = false, replaces = false;
  std::string verdict, notFelt, broken;

  [[nodiscard]] std::string sentence() const {
    std::string words = verdict + '.';
    if (isTool && own == advised) words = "Each of its points is needed.";
    if (replaces || (isTool && own != advised)) {
      words = grouped(own) + (isTool ? " points; " : " triangles; ") + grouped(advised) + " feel the same.";
    }
    if (!notFelt.empty()) words += " Not felt: " + notFelt + '.';
    if (!broken.empty()) words += " The IHIP gets inside: " + broken + '.';
    return words;
  }
};

void addTo(std::string& list, const std::string& item) { list += (list.empty() ? "" : ", ") + item; }

void read(const Json& record, Found& found) {
  if (record.contains("verdict")) {
    found.verdict = record.at("verdict");
    found.replaces = record.at("replaces_mesh");
  } else if (record.contains("own_mesh")) {
    if (record.at("own_mesh")) found.own = record.at("triangles");
    if (record.at("advised")) found.advised = record.at("triangles");
  } else if (record.contains("own_spacing")) {
    found.isTool = true;
    if (record.at("own_spacing")) found.own = record.at("points");
    if (record.at("advised")) found.advised = record.at("points");
  } else if (record.contains("feature")) {
    if (record.at("judged") && !record.at("felt")) addTo(found.notFelt, record.at("feature"));
  } else if (record.contains("motion")) {
    if (!record.at("pass")) addTo(found.broken, record.at("motion"));
  }
}

}  // namespace

Result<std::map<std::string, std::string>> adviceIn(const std::string& records) try {
  std::map<std::string, Found> found;
  for (const Json& record : Json::parse(records)) read(record, found[record.at("scene")]);
  std::map<std::string, std::string> sentences;
  for (const auto& [name, of] : found) {
    if (of.isTool || !of.verdict.empty()) sentences[name] = of.sentence();
  }
  return sentences;
} catch (const Json::exception& error) {
  return refused("advise.json", error.what());
}

}  // namespace haptics
