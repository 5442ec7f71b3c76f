#include "tests/eval/report.h"

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace haptics::eval {

void makeFolder(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!std::filesystem::is_directory(directory))
    throw std::runtime_error("--out " + directory.string() +
                             ": cannot be made; give a folder, or where one can be made");
  if (access(directory.c_str(), W_OK) != 0)
    throw std::runtime_error("--out " + directory.string() + ": must not be written to; give another folder");
}

void writeRecords(const std::filesystem::path& directory, std::string_view verb, const std::vector<Record>& records) {
  writeRecord(directory, verb, Record(records));
}

void writeRecord(const std::filesystem::path& directory, std::string_view name, const Record& record) {
  const std::filesystem::path path = directory / (std::string(name) + ".json");
  std::filesystem::path unfinished = path;  // what is there stays whole whenever this ends
  unfinished += ".part";
  std::ofstream file(unfinished);
  file << record.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(unfinished, path, error);
  if (!file || error) throw std::runtime_error(path.string() + ": cannot be written");
}

std::vector<Record> readRecords(const std::filesystem::path& file) {
  std::ifstream text(file);
  try {
    return Record::parse(text).get<std::vector<Record>>();
  } catch (const Record::exception& error) {
    throw std::runtime_error(file.string() + ": holds no records: " + error.what());
  }
}

void showFinding(const Record& finding) {
  std::printf("  %s\n", measuresText(finding).c_str());
  std::fflush(stdout);
}

void showProgress(std::uint64_t done, std::uint64_t all, std::uint64_t each, std::size_t failed) {
  if (done % each != 0) return;
  std::fprintf(stderr, "%llu of %llu worlds, %zu failed\n", static_cast<unsigned long long>(done),
               static_cast<unsigned long long>(all), failed);
}

std::string measuresText(const Record& measures) {
  std::ostringstream text;
  text.precision(3);
  for (const auto& [key, value] : measures.items()) {
    if (text.tellp() > 0) text << ", ";
    text << key << ' ';
    if (value.is_number_float()) {
      text << value.get<double>();
    } else {
      text << value;
    }
  }
  return text.str();
}

}  // namespace haptics::eval
