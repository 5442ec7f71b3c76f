#include "graphics_client/export/csv_sink.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <system_error>

#include "graphics_client/export/tick_columns.h"

namespace haptics {
namespace {

constexpr std::size_t kBuffer_bytes = 1U << 20;

class CsvSink final : public SessionSink {
 public:
  explicit CsvSink(const SessionFacts& facts) : hasSecond_(!facts.secondDevice.empty()) {
    buffer_.reserve(2 * kBuffer_bytes);
  }
  ~CsvSink() override {
    if (out_ != nullptr) std::fclose(out_);
  }

  [[nodiscard]] Result<void> open(const std::filesystem::path& file) {
    file_ = file;
    out_ = std::fopen(file.c_str(), "wb");
    if (out_ == nullptr) return cannotWrite();
    std::setvbuf(out_, nullptr, _IONBF, 0);
    addHead("");
    if (hasSecond_) addHead("second_hand.");
    endLine();
    return {};
  }

  [[nodiscard]] Result<void> scene(std::uint64_t, const MirrorView&) override { return {}; }
  [[nodiscard]] Result<void> gap(const TickGap&) override { return {}; }

  [[nodiscard]] Result<void> add(const SessionTick& tick) override {
    addValues({tick.sample, tick.tool});
    if (hasSecond_) addValues({tick.second == nullptr ? TelemetrySample{} : *tick.second, ToolState{}});
    endLine();
    return buffer_.size() < kBuffer_bytes ? Result<void>() : flush();
  }

  [[nodiscard]] Result<void> finish(const SessionEnd&) override {
    if (auto written = flush(); !written) return written;
    return std::fclose(std::exchange(out_, nullptr)) == 0 ? Result<void>() : cannotWrite();
  }

 private:
  bool hasSecond_;
  std::filesystem::path file_;
  std::FILE* out_ = nullptr;
  std::string buffer_;

  [[nodiscard]] tl::unexpected<Error> cannotWrite() const {
    return refused(file_.string(), "cannot be written: " + std::generic_category().message(errno));
  }

  [[nodiscard]] Result<void> flush() {
    const bool whole = std::fwrite(buffer_.data(), 1, buffer_.size(), out_) == buffer_.size();
    buffer_.clear();
    return whole ? Result<void>() : cannotWrite();
  }

  void addHead(const std::string& hand) {
    static constexpr std::array kOfVector{".x", ".y", ".z"};
    static constexpr std::array kOfQuaternion{".w", ".x", ".y", ".z"};
    static constexpr std::array kOfEnergy{".contact", ".shading", ".friction", ".texture",
                                          ".motion",  ".edit",    ".wrench"};
    static_assert(kOfEnergy.size() == kEnergyFeatures);
    for (const TickColumn& column : tickColumns()) {
      for (std::size_t i = 0; i < column.width; ++i) {
        const char* component = column.width == 3                 ? kOfVector[i]
                                : column.width == 4               ? kOfQuaternion[i]
                                : column.width == kEnergyFeatures ? kOfEnergy[i]
                                                                  : "";
        buffer_ += hand + column.name + component;
        if (std::string_view(column.unit) != "1") buffer_ += std::string(" [") + column.unit + "]";
        buffer_ += ',';
      }
    }
  }

  void addValues(const TickValues& values) {
    std::array<double, TickColumn::kMaxWidth> reals;
    for (const TickColumn& column : tickColumns()) {
      if (column.number != nullptr) {
        add(column.number(values));
        continue;
      }
      column.reals(values, reals.data());
      for (std::size_t i = 0; i < column.width; ++i) add(reals[i]);
    }
  }

  template <class Number>
  void add(Number number) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    buffer_.append(digits.data(), end);
    buffer_ += ',';
  }

  void endLine() { buffer_.back() = '\n'; }
};

}  // namespace

Result<std::unique_ptr<SessionSink>> makeCsvSink(const std::filesystem::path& file, const SessionFacts& facts) {
  auto sink = std::make_unique<CsvSink>(facts);
  if (auto opened = sink->open(file); !opened) return tl::unexpected(std::move(opened).error());
  return sink;
}

}  // namespace haptics
