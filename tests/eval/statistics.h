#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/eval/report.h"

namespace haptics::eval {

/// Values of one quantity over a run.
class Statistics {
 public:
  void add(double value) {
    values_.push_back(value);
    last_ = value;
    sorted_ = false;
  }
  [[nodiscard]] double last() const noexcept { return last_; }  ///< Added.
  [[nodiscard]] std::size_t count() const noexcept { return values_.size(); }
  [[nodiscard]] bool empty() const noexcept { return values_.empty(); }
  [[nodiscard]] double rms() const {
    double squares = 0;
    for (const double v : values_) squares += v * v;
    return std::sqrt(squares / static_cast<double>(values_.size()));
  }
  /// The value that this part (0 to 1) of them does not exceed; 0 when there are none.
  [[nodiscard]] double quantile(double part) {
    if (values_.empty()) return 0;
    if (!sorted_) std::sort(values_.begin(), values_.end());
    sorted_ = true;
    return values_[static_cast<std::size_t>(part * static_cast<double>(values_.size() - 1))];
  }
  [[nodiscard]] double max() { return quantile(1); }

 private:
  std::vector<double> values_;
  double last_ = 0;
  bool sorted_ = false;
};

/// As <key>_rms_<unit>, _p99_ and _max_; nothing when there was nothing to measure.
inline void writeErrors(Record& record, const std::string& key, const std::string& unit, Statistics& errors) {
  if (errors.empty()) return;
  record[key + "_rms_" + unit] = errors.rms();
  record[key + "_p99_" + unit] = errors.quantile(0.99);
  record[key + "_max_" + unit] = errors.max();
}

}  // namespace haptics::eval
