#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/haptic_server/device/emulated/vendors/emulated_arm.h"

namespace haptics {

/// The arm in a file that is made where there is none; null where it cannot be.
[[nodiscard]] inline EmulatedArm* mapArm(const char* file) {
  const int descriptor = ::open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0 || ::ftruncate(descriptor, sizeof(EmulatedArm)) != 0) return nullptr;
  void* const memory = ::mmap(nullptr, sizeof(EmulatedArm), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  ::close(descriptor);
  return memory == MAP_FAILED ? nullptr : static_cast<EmulatedArm*>(memory);
}

}  // namespace haptics
