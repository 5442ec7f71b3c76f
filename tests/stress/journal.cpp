#include "tests/stress/journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>

namespace haptics::stress {

Journal::Journal(const std::filesystem::path& file)
    : file_(open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (file_ < 0) throw std::runtime_error("cannot write " + file.string());
}
Journal::~Journal() { close(file_); }

void Journal::write(const Record& record) const {
  if (::write(file_, &record, sizeof record) != static_cast<ssize_t>(sizeof record)) {
    throw std::runtime_error("a journal cannot be written: is the disk full?");
  }
}

std::vector<Record> readJournal(const std::filesystem::path& file) {
  std::vector<Record> records;
  std::ifstream in(file, std::ios::binary);
  for (Record record; in.read(reinterpret_cast<char*>(&record), sizeof record);) records.push_back(record);
  return records;
}

}  // namespace haptics::stress
