#include "tests/eval/report.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace haptics::eval {

void writeRecords(const std::filesystem::path& directory, std::string_view verb, const std::vector<Record>& records) {
  std::error_code ignored;  // what matters is whether the file can be written
  std::filesystem::create_directories(directory, ignored);
  const std::filesystem::path path = directory / (std::string(verb) + ".json");
  std::ofstream file(path);
  file << Record(records).dump(1) << '\n';
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
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
