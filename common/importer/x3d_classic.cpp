#include "common/importer/x3d_classic.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"
#include "common/text/plain_text.h"

namespace haptics {
namespace {

/// A word, a string with its quotes, or one of "[]{}"; empty at the end.
class ClassicTokens {
 public:
  explicit ClassicTokens(std::string_view text) : text_(text) { next(); }

  [[nodiscard]] std::string_view now() const { return now_; }
  [[nodiscard]] std::uint64_t line() const { return line_; }

  void next() {
    constexpr std::string_view kBlanks = " ,\t\r\n", kEndsWord = " ,\t\r\n[]{}\"#", kLineEnds = "\r\n";
    for (; at_ < text_.size() && (kBlanks.find(text_[at_]) != kBlanks.npos || text_[at_] == '#'); ++at_) {
      if (text_[at_] == '#') at_ = std::min(text_.find_first_of(kLineEnds, at_), text_.size() - 1);
      line_ += text_[at_] == '\n' ? 1 : 0;
    }
    std::size_t end = std::min(at_ + 1, text_.size());
    if (at_ < text_.size() && text_[at_] == '"') {
      for (; end < text_.size() && text_[end] != '"'; ++end) end += text_[end] == '\\' ? 1 : 0;
      end = std::min(end + 1, text_.size());
    } else if (at_ < text_.size() && std::string_view("[]{}").find(text_[at_]) == std::string_view::npos) {
      end = std::min(text_.find_first_of(kEndsWord, at_), text_.size());
    }
    now_ = text_.substr(at_, end - at_);
    at_ = end;
    if (now_.starts_with('"')) line_ += static_cast<std::uint64_t>(std::count(now_.begin(), now_.end(), '\n'));
  }

 private:
  std::string_view text_, now_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
};

struct ClassicNode {
  std::string_view field;  ///< Of the node that holds it; empty: none holds it.
  std::string_view name{}, definition{}, used{};
  std::vector<std::pair<std::string_view, std::string_view>> values{};  ///< Fields, and the text of their tokens.
  std::vector<ClassicNode> nodes{};
};

bool isName(std::string_view token) {
  const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto mayFollow = [&](char c) { return isLetter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; };
  return !token.empty() && isLetter(token.front()) && std::all_of(token.begin(), token.end(), mayFollow);
}

/// As fields have them; "TRUE" and "FALSE" are names too.
bool isValue(std::string_view token) {
  constexpr std::string_view kBegins = "+-.0123456789\"";
  return token == "TRUE" || token == "FALSE" || (!token.empty() && kBegins.find(token.front()) != kBegins.npos);
}

class ClassicParser {
 public:
  explicit ClassicParser(std::string_view text) : tokens_(text) {}

  Result<std::string> run() {
    std::vector<ClassicNode> scene;
    while (fault_.empty() && !tokens_.now().empty()) takeStatement(scene, {});
    if (!fault_.empty()) return refused("", fault_);
    std::string xml = "<X3D><head>" + units_ + "</head><Scene>";
    for (const ClassicNode& node : scene) write(node, xml);
    return xml + "</Scene></X3D>";
  }

 private:
  ClassicTokens tokens_;
  std::string fault_, units_;
  std::map<std::string_view, std::string_view> nodesByName_;  // of DEF
  std::set<std::string_view> prototypes_;
  int depth_ = 0;

  void fail(const std::string& expected) {
    if (!fault_.empty()) return;
    fault_ = "line " + std::to_string(tokens_.line()) + ": ";
    fault_ += tokens_.now().empty() ? "ends where " : "has " + inQuotes(tokens_.now()) + " where ";
    fault_ += expected + " should be";
  }

  std::string_view take() {
    const std::string_view token = tokens_.now();
    if (token.empty()) fail("more");
    tokens_.next();
    return token;
  }

  bool takes(std::string_view token) {
    if (tokens_.now() != token) return false;
    tokens_.next();
    return true;
  }

  std::string_view takeName(const char* of) {
    if (!isName(tokens_.now())) return fail(of), std::string_view();
    return take();
  }

  /// From its first bracket or brace to the last.
  void passOver(std::string_view opening) {
    if (tokens_.now() != opening) {
      fail("\"" + std::string(opening) + "\"");
      return;
    }
    std::size_t open = 0;
    do {
      const std::string_view token = take();
      if (token == "[" || token == "{") ++open;
      if (token == "]" || token == "}") --open;
    } while (open > 0 && fault_.empty());
  }

  /// What stands among nodes and is none.
  bool takesNoNode() {
    const std::string_view keyword = tokens_.now();
    if (keyword == "PROTO") {
      take();
      prototypes_.insert(takeName("a name"));
      passOver("[");
      passOver("{");
    } else if (keyword == "EXTERNPROTO") {
      take();
      prototypes_.insert(takeName("a name"));
      passOver("[");
      if (tokens_.now() == "[") {
        passOver("[");
      } else {
        take();
      }
    } else if (keyword == "ROUTE") {
      for (int i = 0; i < 4; ++i) take();
    } else if (keyword == "IMPORT" || keyword == "EXPORT") {
      take(), take();
      if (takes("AS")) take();
    } else if (keyword == "PROFILE" || keyword == "COMPONENT") {
      take(), take();
    } else if (keyword == "META") {
      take(), take(), take();
    } else if (keyword == "UNIT") {
      take();
      const std::string_view category = take(), name = take(), factor = take();
      units_ += "<unit";
      writeAttribute("category", category, units_);
      writeAttribute("name", name, units_);
      writeAttribute("conversionFactor", factor, units_);
      units_ += "/>";
    } else {
      return false;
    }
    return true;
  }

  void takeStatement(std::vector<ClassicNode>& into, std::string_view field) {
    if (takesNoNode() || takes("NULL")) return;
    if (takes("USE")) {
      const std::string_view used = tokens_.now();
      const auto node = nodesByName_.find(used);
      if (node == nodesByName_.end()) {
        fail("the name of a node that stands before it (DEF)");
        return;
      }
      into.push_back({.field = field, .name = node->second, .used = used});
      take();
      return;
    }
    ClassicNode node{.field = field};
    if (takes("DEF")) node.definition = take();
    node.name = takeName("a node");
    if (prototypes_.contains(node.name)) node.name = "ProtoInstance";
    if (!node.definition.empty()) nodesByName_[node.definition] = node.name;
    if (node.name == "ProtoInstance") {
      passOver("{");
    } else {
      takeFields(node);
    }
    into.push_back(std::move(node));
  }

  void takeFields(ClassicNode& node) {
    if (!takes("{")) {
      fail("\"{\"");
      return;
    }
    if (++depth_ > kDeepestNesting && fault_.empty())
      fault_ = "nests more than " + std::to_string(kDeepestNesting) + " levels deep";
    while (fault_.empty() && !takes("}")) {
      constexpr std::string_view kGivesValue[] = {"initializeOnly", "inputOutput", "field", "exposedField"};
      constexpr std::string_view kGivesNone[] = {"inputOnly", "outputOnly", "eventIn", "eventOut"};
      if (takesNoNode()) continue;
      const bool givesNone = isOneOf(kGivesNone, tokens_.now());
      if (givesNone || isOneOf(kGivesValue, tokens_.now())) take(), take();  // and the field's type
      const std::string_view field = takeName("a field or \"}\"");
      if (takes("IS")) {
        take();
      } else if (!givesNone) {
        takeValue(node, field);
      }
    }
    --depth_;
  }

  void takeValue(ClassicNode& node, std::string_view field) {
    if (tokens_.now() != "[" && !isValue(tokens_.now())) {
      takeStatement(node.nodes, field);
      return;
    }
    const bool isList = takes("[");
    if (isList && !isValue(tokens_.now())) {
      while (fault_.empty() && !takes("]")) takeStatement(node.nodes, field);
      return;
    }
    const auto isNumber = [&] { return isValue(tokens_.now()) && !isName(tokens_.now()) && tokens_.now()[0] != '"'; };
    const bool isOfNumbers = isNumber();
    const char* const from = tokens_.now().data();
    std::string_view last;
    do last = take();
    while (fault_.empty() && (isList ? isValue(tokens_.now()) : isOfNumbers && isNumber()));
    node.values.emplace_back(field, std::string_view(from, static_cast<std::size_t>(last.data() + last.size() - from)));
    if (isList && !takes("]")) fail("a value or \"]\"");
  }

  static void writeText(std::string_view text, std::string& xml) {
    for (const char c : text) {
      if (c == '&') {
        xml += "&amp;";
      } else if (c == '<') {
        xml += "&lt;";
      } else if (c == '>') {
        xml += "&gt;";
      } else if (c == '"') {
        xml += "&quot;";
      } else {
        xml += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
      }
    }
  }

  static void writeAttribute(std::string_view name, std::string_view text, std::string& xml) {
    xml.append(1, ' ').append(name).append("=\"");
    writeText(text, xml);
    xml += '"';
  }

  static void writeValues(std::string_view name, std::string_view text, std::string& xml) {
    ClassicTokens tokens(text);
    if (const std::string_view only = tokens.now(); only.size() == text.size() && only.starts_with('"')) {
      writeAttribute(name, only.substr(1, only.size() - (only.size() > 1 && only.ends_with('"') ? 2 : 1)), xml);
      return;
    }
    xml.append(1, ' ').append(name).append("=\"");
    for (; !tokens.now().empty(); tokens.next()) {
      const std::string_view value = tokens.now();
      if (value.data() != text.data()) xml += ' ';
      writeText(value == "TRUE" ? "true" : value == "FALSE" ? "false" : value, xml);
    }
    xml += '"';
  }

  static void write(const ClassicNode& node, std::string& xml) {
    xml.append(1, '<').append(node.name);
    if (!node.definition.empty()) writeAttribute("DEF", node.definition, xml);
    if (!node.used.empty()) writeAttribute("USE", node.used, xml);
    if (!node.field.empty() && node.field != "children") writeAttribute("containerField", node.field, xml);
    for (const auto& [field, values] : node.values) writeValues(field, values, xml);
    if (node.nodes.empty()) {
      xml += "/>";
      return;
    }
    xml += '>';
    for (const ClassicNode& inner : node.nodes) write(inner, xml);
    xml.append("</").append(node.name).append(1, '>');
  }
};

}  // namespace

Result<std::string> x3dInXml(std::string file) {
  const std::string_view text = withoutByteOrderMark(file);
  const bool isClassic = text.starts_with("#X3D ") || text.starts_with("#VRML V2.0");
  return isClassic ? ClassicParser(text).run() : plainXml(std::move(file));
}

}  // namespace haptics
