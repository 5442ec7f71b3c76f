#pragma once

#include <string>

#include "tests/eval/adapters/adapter_process.h"
#include "tests/eval/methods.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// Is it the file of a shared library, or a command, and no method's name?
[[nodiscard]] bool isOutside(std::string_view name);

/// 1 to 40 letters, digits, '_', '-' and '.'.
[[nodiscard]] bool isMethodName(std::string_view text);

/// A renderer in another process.
class OutsideRenderer : public Renderer {
 public:
  /// What the last tick took the method, without the way there and back; nothing where it was not measured.
  [[nodiscard]] virtual std::optional<double> ownTime_ns() const = 0;
  /// It says that bodies left the IHIP no way in the last tick.
  [[nodiscard]] virtual bool putOutside() const = 0;
};
[[nodiscard]] inline bool isOutside(const Renderer& renderer) {
  return dynamic_cast<const OutsideRenderer*>(&renderer) != nullptr;
}
/// Of any renderer; nothing of one in this process.
[[nodiscard]] inline std::optional<double> ownTime_ns(const Renderer& renderer) {
  const auto* const outside = dynamic_cast<const OutsideRenderer*>(&renderer);
  return outside != nullptr ? outside->ownTime_ns() : std::nullopt;
}

/// A method that README.md tells how to write, each of whose renderers has a process of its own. They throw MethodFault
/// and NotApplicable. Stays until the program ends. Throws std::invalid_argument when it cannot be started.
[[nodiscard]] const Method& outsideMethod(const std::string& command);

/// What fills a row of a method where it was not measured: adds `fault` or `not_applicable` to the record, and `pass`, false
/// or null. @return Whether `run` came to its end.
template <class Run>
bool runOrExplain(Record& record, Run run) {
  try {
    run();
    return true;
  } catch (const MethodFault& fault) {
    record["fault"] = fault.what();
    record["pass"] = false;
  } catch (const NotApplicable& reason) {
    record["not_applicable"] = reason.what();
    record["pass"] = nullptr;
  }
  return false;
}

}  // namespace haptics::eval
