#include "common/importer/fbx_records.h"

#include <libdeflate.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "common/importer/inflater.h"

namespace haptics {
namespace {

constexpr std::string_view kBinaryHead = "Kaydara FBX Binary  ";
constexpr std::string_view kBlanksOfFbx = " \t\r\n";
constexpr std::size_t kMaxValues = 8;
constexpr int kDeepest = 100;

using Take = std::function<void(const FbxRecord&)>;

template <class T>
T valueIn(std::string_view bytes) {
  T value{};
  std::memcpy(&value, bytes.data(), std::min(bytes.size(), sizeof value));
  return value;
}

class BinaryRecords {
 public:
  BinaryRecords(std::string_view file, const Take& take) : file_(file), take_(take) {}

  std::optional<std::string_view> read() {
    constexpr std::size_t kVersionAt = 23;
    if (file_.size() < kVersionAt + 4) return kDamaged;
    isLarge_ = valueIn<std::uint32_t>(file_.substr(kVersionAt)) >= 7500;
    std::size_t at = kVersionAt + 4;
    for (bool isLast = false; !isLast;) {
      if (!record(at, file_.size(), 0, isLast)) return kDamaged;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::string_view kDamaged = "is a binary FBX that is cut off or damaged";

  const std::string_view file_;
  const Take& take_;
  bool isLarge_ = false;

  [[nodiscard]] std::uint64_t wide(std::size_t at) const {
    return isLarge_ ? valueIn<std::uint64_t>(file_.substr(at)) : valueIn<std::uint32_t>(file_.substr(at));
  }

  /// One, or the empty one after the last. @param at  Where it begins; afterwards, where it ended.
  bool record(std::size_t& at, std::size_t end, int depth, bool& isLast) {
    const std::size_t width = isLarge_ ? 8 : 4, head = 3 * width + 1;
    if (depth > kDeepest || end - at < head) return false;
    const std::uint64_t recordEnd = wide(at), valuesSize = wide(at + 2 * width);
    const std::size_t nameSize = static_cast<unsigned char>(file_[at + 3 * width]);
    isLast = recordEnd == 0;
    if (isLast) {
      at += head;
      return true;
    }
    if (recordEnd > end || recordEnd < at + head + nameSize || valuesSize > recordEnd - at - head - nameSize)
      return false;
    FbxRecord found{.name = file_.substr(at + head, nameSize), .values = {}, .list = {}, .depth = depth};
    at += head + nameSize;
    std::string_view values = file_.substr(at, valuesSize);
    while (!values.empty() && found.values.size() < kMaxValues) {
      if (!value(values, found)) return false;
    }
    take_(found);
    at += valuesSize;
    for (bool last = false; at < recordEnd && !last;) {
      if (!record(at, recordEnd, depth + 1, last)) return false;
    }
    return at == recordEnd;
  }

  static bool value(std::string_view& left, FbxRecord& record) {
    FbxValue value{.bytes = {}, .type = left.front()};
    left.remove_prefix(1);
    const auto take = [&](std::size_t size) {
      if (size > left.size()) return false;
      value.bytes = left.substr(0, size);
      left.remove_prefix(size);
      return true;
    };
    const auto isWhole = [&](std::size_t head) { return left.size() >= head; };
    bool isThere = false;
    switch (value.type) {
      case 'C':
        if ((isThere = take(1))) value.number = valueIn<std::uint8_t>(value.bytes);
        break;
      case 'Y':
        if ((isThere = take(2))) value.number = valueIn<std::int16_t>(value.bytes);
        break;
      case 'I':
        if ((isThere = take(4))) value.number = valueIn<std::int32_t>(value.bytes);
        break;
      case 'L':
        if ((isThere = take(8))) value.number = valueIn<std::int64_t>(value.bytes);
        break;
      case 'F':
        if ((isThere = take(4))) value.number = valueIn<float>(value.bytes) != 0 ? 1 : 0;
        break;
      case 'D':
        if ((isThere = take(8))) value.number = valueIn<double>(value.bytes) != 0 ? 1 : 0;
        break;
      case 'S':
      case 'R':
        if (isWhole(4)) {
          const auto size = valueIn<std::uint32_t>(left);
          left.remove_prefix(4);
          isThere = take(size);
        }
        break;
      case 'f':
      case 'd':
      case 'l':
      case 'i':
      case 'b':
      case 'c':
        if (isWhole(12)) {
          value.count = valueIn<std::uint32_t>(left);
          value.isPacked = valueIn<std::uint32_t>(left.substr(4)) != 0;
          const auto size = valueIn<std::uint32_t>(left.substr(8));
          left.remove_prefix(12);
          isThere = take(size);
        }
        break;
      default:
        break;
    }
    if (isThere) record.values.push_back(value);
    return isThere;
  }
};

class TextRecords {
 public:
  TextRecords(std::string_view text, const Take& take) : text_(text), take_(take) {}

  std::optional<std::string_view> read() {
    int depth = 0;
    for (skipBlanks(); at_ < text_.size(); skipBlanks()) {
      if (text_[at_] == '{' || text_[at_] == '}') {
        depth += text_[at_] == '{' ? 1 : -1;
        ++at_;
        continue;
      }
      const std::string_view word = next();
      skipBlanks();
      if (at_ < text_.size() && text_[at_] == ':') {
        ++at_;
        take_(record(word, depth));
      }
    }
    if (depth > 0) return "is cut off: a brace is open at its end";
    return std::nullopt;
  }

 private:
  const std::string_view text_;
  const Take& take_;
  std::size_t at_ = 0;

  void skipBlanks() {
    while ((at_ = std::min(text_.find_first_not_of(kBlanksOfFbx, at_), text_.size())) < text_.size() &&
           text_[at_] == ';')
      at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
  }

  /// With its quotes; one character at least.
  std::string_view next() {
    const std::size_t from = at_;
    if (text_[at_] == '"') {
      at_ = std::min(text_.find('"', at_ + 1), text_.size() - 1) + 1;
    } else {
      at_ = std::min(text_.find_first_of(" \t\r\n,:;{}\"", at_ + 1), text_.size());
    }
    return text_.substr(from, at_ - from);
  }

  FbxRecord record(std::string_view name, int depth) {
    FbxRecord found{.name = name, .values = {}, .list = {}, .depth = depth};
    const std::size_t from = at_;
    for (bool more = true; more;) {
      skipBlanks();
      if (at_ == text_.size() || text_[at_] == '{' || text_[at_] == '}') break;
      const std::size_t before = at_;
      const std::string_view word = next();
      skipBlanks();
      if (at_ < text_.size() && text_[at_] == ':') {  // the name of the next, after a record of no values
        at_ = before;
        break;
      }
      if (found.values.size() < kMaxValues) found.values.push_back(valueOf(word));
      more = at_ < text_.size() && text_[at_] == ',';
      if (more) ++at_;
    }
    found.list = text_.substr(from, at_ - from);
    return found;
  }

  static FbxValue valueOf(std::string_view word) {
    if (word.starts_with('"')) {
      word.remove_prefix(1);
      if (word.ends_with('"')) word.remove_suffix(1);
      return {.bytes = word, .type = 'S'};
    }
    FbxValue value{.bytes = word, .type = 'D'};
    const char* const last = word.data() + word.size();
    double number = 0;
    if (std::from_chars(word.data(), last, value.number).ptr != last) {
      std::from_chars(word.data(), last, number);
      value.number = number != 0 ? 1 : 0;
    }
    return value;
  }
};

std::vector<std::int64_t> numbersInArray(const FbxValue& array) {
  const std::size_t each = array.type == 'l' ? 8 : 4, size = array.count * each;
  std::string_view bytes = array.bytes;
  std::vector<char> unpacked;
  if (array.isPacked) {
    if (size / kMaxInflation > bytes.size()) return {};
    unpacked.resize(size);
    if (libdeflate_zlib_decompress(makeInflater().get(), bytes.data(), bytes.size(), unpacked.data(), size, nullptr) !=
        LIBDEFLATE_SUCCESS) {
      return {};
    }
    bytes = {unpacked.data(), size};
  }
  std::vector<std::int64_t> numbers(std::min<std::size_t>(array.count, bytes.size() / each));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string_view own = bytes.substr(i * each, each);
    numbers[i] = each == 8 ? valueIn<std::int64_t>(own) : valueIn<std::int32_t>(own);
  }
  return numbers;
}

}  // namespace

std::string_view FbxRecord::textAt(std::size_t index) const {
  return index < values.size() && values[index].type == 'S' ? values[index].bytes : std::string_view();
}

std::int64_t FbxRecord::numberAt(std::size_t index) const { return index < values.size() ? values[index].number : 0; }

double FbxRecord::realAt(std::size_t index) const {
  if (index >= values.size()) return 0;
  const auto& [bytes, number, type, count, isPacked] = values[index];
  if (!list.empty()) {
    double real = 0;
    std::from_chars(bytes.data(), bytes.data() + bytes.size(), real);
    return real;
  }
  if (type == 'F') return static_cast<double>(valueIn<float>(bytes));
  return type == 'D' ? valueIn<double>(bytes) : static_cast<double>(number);
}

std::optional<std::string_view> eachFbxRecord(std::string_view file, const Take& take) {
  return file.starts_with(kBinaryHead) ? BinaryRecords(file, take).read() : TextRecords(file, take).read();
}

std::vector<std::int64_t> wholeNumbersOf(const FbxRecord& record) {
  if (!record.values.empty() && (record.values[0].type == 'i' || record.values[0].type == 'l'))
    return numbersInArray(record.values[0]);
  std::vector<std::int64_t> numbers;
  const std::string_view list = record.list;
  for (std::size_t at = 0; (at = list.find_first_not_of(" \t\r\n,", at)) != list.npos;) {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(list.data() + at, list.data() + list.size(), number);
    if (error != std::errc()) break;
    numbers.push_back(number);
    at = static_cast<std::size_t>(end - list.data());
  }
  return numbers;
}

}  // namespace haptics
