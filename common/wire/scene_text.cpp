#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/text/plain_text.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"

namespace haptics {
namespace {

namespace pb = google::protobuf;

/// Keeps the first error: those that follow mostly follow from it.
class FirstError final : public pb::io::ErrorCollector {
 public:
  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    if (!message_.empty()) return;
    line_ = line;
    column_ = column;
    message_ = message;
  }

  [[nodiscard]] const std::string& message() const { return message_; }
  [[nodiscard]] int line() const { return line_; }  // from 0; -1 for the whole text
  [[nodiscard]] int column() const { return column_; }
  /// ":3:24", counted from 1 as editors do; empty for the whole text.
  [[nodiscard]] std::string place() const {
    if (line_ < 0) return {};
    return std::string(1, ':').append(std::to_string(line_ + 1)).append(1, ':').append(std::to_string(column_ + 1));
  }

 private:
  int line_ = -1, column_ = 0;
  std::string message_;
};

std::string fieldNames(const pb::Descriptor& message) {
  std::string names;
  for (int i = 0; i < message.field_count(); ++i) names += (i == 0 ? "" : ", ") + message.field(i)->name();
  return names;
}

/// Protobuf's message, and for an unknown field the fields that there are.
std::string explain(const std::string& message) {
  if (message.ends_with(", got: ")) return "ends too early";
  constexpr std::string_view kBeforeType = "Message type \"";
  constexpr std::string_view kBeforeField = "\" has no field named \"";
  const std::size_t typeEnd = message.find(kBeforeField);
  if (!message.starts_with(kBeforeType) || typeEnd == std::string::npos) return message;
  const std::string type = message.substr(kBeforeType.size(), typeEnd - kBeforeType.size());
  const std::size_t field = typeEnd + kBeforeField.size();
  const pb::Descriptor* known = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(type);
  if (known == nullptr) return message;
  return known->name() + " has no field \"" + message.substr(field, message.find('"', field) - field) +
         "\"; its fields are " + fieldNames(*known);
}

std::string lineOf(const std::string& text, int number) {
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i <= number; ++i) {
    if (!std::getline(lines, line)) return {};
  }
  return line;
}

std::string shown(const std::string& line) {
  constexpr std::size_t kShown = 80;
  const std::size_t start = line.find_first_not_of(" \t");
  return start == std::string::npos ? std::string() : line.substr(start, kShown);
}

/// What is at a column, if it is not ASCII, which protobuf reads in strings and comments only; else empty.
std::string strangeCharacter(std::string_view line, int column) {
  constexpr int kTab = 8;  // as protobuf counts
  for (int at = 0; at < column && !line.empty(); line.remove_prefix(1)) at += line[0] == '\t' ? kTab - at % kTab : 1;
  if (line.empty() || static_cast<unsigned char>(line[0]) < 0x80) return {};
  const Utf8Character character = firstCharacterOf(line);
  char text[80];
  if (character.bytes == 0) {
    std::snprintf(text, sizeof text, "holds the byte 0x%02x, which is no UTF-8; save it in UTF-8",
                  static_cast<unsigned char>(line[0]));
    return text;
  }
  std::snprintf(text, sizeof text, "holds U+%04X", static_cast<unsigned>(character.code));
  const auto isIn = [&](char32_t first, char32_t last) { return character.code >= first && character.code <= last; };
  const bool isBlank = character.code == 0xa0 || character.code == 0x202f || character.code == 0x3000 ||
                       character.code == 0xfeff || isIn(0x2000, 0x200b);
  const char* const instead = isBlank                ? ", a special blank; type a plain one"
                              : isIn(0x2018, 0x201f) ? ", a typographic quotation mark; type a plain one"
                                                     : "; only strings and comments may have other than ASCII";
  return std::string(text) + instead;
}

/// The '{' that the text leaves open, in words; empty if each has its '}'.
std::string openBrace(const std::string& text) {
  struct Brace {
    int line;
    std::size_t indent;
  };
  std::vector<Brace> open;
  std::optional<Brace> closedElsewhere;
  std::istringstream lines(text);
  std::string line;
  for (int number = 0; std::getline(lines, line); ++number) {
    const std::size_t indent = line.find_first_not_of(" \t");
    char quote = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (quote != 0) {
        if (c == '\\') ++i;
        if (c == quote) quote = 0;
      } else if (c == '#') {
        break;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '{') {
        open.push_back({number, indent});
      } else if (c == '}' && !open.empty()) {
        const bool isOutOfLine = i == indent && indent != open.back().indent;
        if (isOutOfLine && !closedElsewhere) closedElsewhere = open.back();
        open.pop_back();
      }
    }
  }
  if (open.empty()) return {};
  const auto named = [&text](const Brace& brace) {
    return "the \"{\" of line " + std::to_string(brace.line + 1) + " (" + shown(lineOf(text, brace.line)) + ")";
  };
  std::string said = "; " + named(open.back()) + " is still open at the end";
  if (closedElsewhere && closedElsewhere->line != open.back().line) {
    said += ", perhaps because " + named(*closedElsewhere) + " is not closed where its line begins";
  }
  return said;
}

std::optional<std::string> readLimited(std::istream& in) {
  std::string text(kMaxSceneTextBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) return std::nullopt;
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

}  // namespace

Result<void> parseMessageText(const std::string& file, const std::string& origin, pb::Message& message) {
  if (file.size() > kMaxSceneTextBytes) {
    return refused(origin, "is larger than " + std::to_string(kMaxSceneTextBytes >> 20) + " MiB; split it");
  }
  const auto lines = plainLines(file);
  if (!lines) return refused(origin, lines.error().reason);
  const std::string& text = *lines;
  FirstError error;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  parser.SetRecursionLimit(pb::io::CodedInputStream::GetDefaultRecursionLimit());  // fields may be layers of fields
  if (parser.ParseFromString(text, &message)) return {};
  const std::string line = lineOf(text, error.line());
  std::string reason = strangeCharacter(line, error.column());
  if (reason.empty()) reason = explain(error.message()) + openBrace(text);
  if (!shown(line).empty()) reason += "; the line reads: " + shown(line);
  return refused(origin + error.place(), std::move(reason));
}

Result<void> readMessageFile(const std::string& path, pb::Message& message) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return refused(path, "there is no such file");
  if (std::filesystem::is_directory(path, ignored)) return refused(path, "is a directory; give a file");
  std::ifstream file(path, std::ios::binary);
  const auto text = file ? readLimited(file) : std::nullopt;
  if (!text) return refused(path, "cannot be read; check its permissions");
  return parseMessageText(*text, path, message);
}

Result<v1::Transaction> parseSceneText(const std::string& text, const std::string& origin) {
  v1::Transaction transaction;
  if (auto parsed = parseMessageText(text, origin, transaction); !parsed) return tl::unexpected(parsed.error());
  return transaction;
}

Result<v1::Transaction> readSceneFile(const std::string& path) {
  if (path == "-") {
    const auto text = readLimited(std::cin);
    if (!text) return refused("standard input", "cannot be read");
    return parseSceneText(*text, "standard input");
  }
  v1::Transaction transaction;
  if (auto read = readMessageFile(path, transaction); !read) return tl::unexpected(read.error());
  return transaction;
}

}  // namespace haptics
