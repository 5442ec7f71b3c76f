#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

namespace haptics::eval {

/// One run of one method: flat, with `method`, `scene`, each measure under its own key with its unit in the name, and
/// `pass`.
using Record = nlohmann::ordered_json;

/// Makes the folder for results where it is missing. Throws std::runtime_error when it cannot be made or written to.
void makeFolder(const std::filesystem::path& directory);

/// Writes DIR/<verb>.json, a list of records. Throws std::runtime_error naming the file that cannot be
/// written.
void writeRecords(const std::filesystem::path& directory, std::string_view verb, const std::vector<Record>& records);

/// Likewise one, as DIR/<name>.json.
void writeRecord(const std::filesystem::path& directory, std::string_view name, const Record& record);

/// What writeRecords() wrote. Throws std::runtime_error naming the file that cannot be read, or holds no records.
[[nodiscard]] std::vector<Record> readRecords(const std::filesystem::path& file);

/// A finding of a long run: prints it at once.
void showFinding(const Record& finding);
/// Every `each` of a long run's worlds a line on standard error.
void showProgress(std::uint64_t done, std::uint64_t all, std::uint64_t each, std::size_t failed);

/// One line for standard output: each key and its value.
[[nodiscard]] std::string measuresText(const Record& measures);

}  // namespace haptics::eval
