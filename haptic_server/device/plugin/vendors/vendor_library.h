#pragma once

#include <dlfcn.h>

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace haptics {

/// A shared library of a device's maker, loaded at run time: none is needed to build, and none is shipped. It stays loaded.
class VendorLibrary {
 public:
  /// The newest of the files that match one of these patterns (of glob(7)) or names, by the first pattern that has one that loads.
  /// @param needed  Patterns of what it may need itself, loaded before it where they are: makers' packages often lack the
  ///                link of the name that it is asked for by.
  explicit VendorLibrary(std::span<const std::string> patterns, std::span<const std::string> needed = {});

  [[nodiscard]] explicit operator bool() const noexcept { return library_ != nullptr && missing_.empty(); }
  /// Why it cannot be used: where it was looked for, what the loader says, or which function it lacks.
  [[nodiscard]] std::string reason() const;
  [[nodiscard]] const std::string& file() const noexcept { return file_; }

  template <class Function>
  void find(const char* name, Function*& function) {
    if (library_ == nullptr) return;
    function = reinterpret_cast<Function*>(dlsym(library_, name));
    if (function == nullptr && missing_.empty()) missing_ = name;
  }

 private:
  void* library_ = nullptr;
  std::string file_, refusals_, missing_;
};

}  // namespace haptics
