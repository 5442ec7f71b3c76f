#pragma once

namespace haptics {

/// `haptic_server doctor`: says what the machine permits a real-time servo, measures how punctually it wakes one up, and
/// what to change. @return What the program exits with: 0 when the servo can be real-time, 1 when it cannot, 2 for wrong
/// usage.
int runDoctor(int argc, char** argv);

}  // namespace haptics
