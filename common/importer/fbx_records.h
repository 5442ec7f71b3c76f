#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

namespace haptics {

/// A value of a record: a text, a number, or in a binary file an array.
struct FbxValue {
  std::string_view bytes;   ///< Of a text: without quotes; of a number or an array: as it is in the file.
  std::int64_t number = 0;  ///< Of a whole number; of another, 1 unless it is 0.
  char type = 0;            ///< As a binary file has it; of a text file 'S', or 'D' for what has no quotes.
  std::uint32_t count = 0;  ///< Of an array.
  bool isPacked = false;    ///< Likewise.
};

/// One of the records of an FBX, each of which has a name, values and records within it.
struct FbxRecord {
  std::string_view name;
  std::vector<FbxValue> values;  ///< The first few.
  std::string_view list;         ///< In a text, all values as they are written.
  int depth = 0;                 ///< 0: within no other.

  [[nodiscard]] std::string_view textAt(std::size_t index) const;
  [[nodiscard]] std::int64_t numberAt(std::size_t index) const;
  /// Of any number.
  [[nodiscard]] double realAt(std::size_t index) const;
};

/// Calls `take` for each record of an FBX, binary or text, in the file's order; one comes before those within it. Gives why the
/// file is damaged, where it is; what came before that was given to `take`.
[[nodiscard]] std::optional<std::string_view> eachFbxRecord(std::string_view file,
                                                            const std::function<void(const FbxRecord&)>& take);

/// An array of whole numbers, up to what is none: `record` has it, or, in a text, the record "a" within it.
[[nodiscard]] std::vector<std::int64_t> wholeNumbersOf(const FbxRecord& record);

}  // namespace haptics
