#include "haptic_server/device/usb/falcon_boot.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "haptic_server/device/usb/falcon_frame.h"

namespace haptics {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::uint64_t kMaxDrain_ns = 200 * kMillisecond_ns;  // of a device that babbles
constexpr std::size_t kPayload_bytes = 62;                     // of a packet of 64 with two bytes of modem status
constexpr int kGreetings = 100;                                // the loader needs some before it listens
constexpr int kRunningTries = 5;                               // frames sent to a device that may be running

// Requests of the FT232R serial converter.
constexpr std::uint8_t kReset = 0, kModemControl = 1, kFlowControl = 2, kBaud = 3, kData = 4, kEventChar = 6,
                       kLatency = 9;
constexpr std::uint16_t kPurgeReceived = 1, kPurgeSent = 2;
constexpr std::uint16_t kDtrLow = 0x0100, kDtrHigh = 0x0101, kRtsLow = 0x0200;
constexpr std::uint16_t kBaudGreeting = 0x4138, kBaudLoader = 0x0015, kBaudRunning = 0x0002;  // divisors
constexpr std::uint16_t kEightBitsNoParity = 0x0008;
/// Send at once what ends in '>', rather than wait for the latency timer.
constexpr std::uint16_t kFlushAtFrameEnd = 0x0100 | '>';

constexpr std::array<std::uint8_t, 3> kGreeting{0x0A, 0x43, 0x0D};
constexpr std::array<std::uint8_t, 4> kGreeted{0x0A, 0x44, 0x2C, 0x0D};
constexpr std::array<std::uint8_t, 1> kLoad{0x41};

[[nodiscard]] UsbRefusal refusal(DeviceFault fault, std::string reason) {
  return {fault, {"Falcon", std::move(reason)}};
}

class Boot {
 public:
  Boot(UsbPort& port, UsbBus& bus) : port_(port), bus_(bus) {}

  [[nodiscard]] std::optional<UsbRefusal> run(const std::optional<FalconFirmware>& firmware) {
    if (answersCommands()) return std::nullopt;
    if (gone_) return refusal(DeviceFault::kUnplugged, "went away");
    if (!firmware) {
      return refusal(DeviceFault::kFirmware,
                     "has no firmware yet and none was given: --firmware FILE names the file that its maker's driver "
                     "loads (this program may not bring it)");
    }
    if (!greet()) return refusal(DeviceFault::kNotAnswering, "does not answer its boot loader's greeting");
    if (auto refused = load(*firmware)) return refused;
    if (answersCommands()) return std::nullopt;
    return refusal(DeviceFault::kNotAnswering, "took the firmware and does not answer commands");
  }

 private:
  bool request(std::uint8_t code, std::uint16_t value) {
    const UsbOutcome outcome = port_.control({.type = 0x40, .request = code, .value = value});
    gone_ = gone_ || outcome == UsbOutcome::kGone;
    return outcome == UsbOutcome::kDone;
  }
  void purge() {
    request(kReset, kPurgeReceived);
    request(kReset, kPurgeSent);
  }

  /// Bytes without the modem status, until there are `count` or the time is over.
  [[nodiscard]] std::vector<std::uint8_t> receive(std::size_t count, std::uint64_t patience_ns) {
    std::vector<std::uint8_t> received;
    const std::uint64_t deadline_ns = bus_.clock_ns() + patience_ns;
    while (received.size() < count && !gone_) {
      const UsbArrival arrival = port_.next(deadline_ns);
      if (arrival.kind == UsbArrival::Kind::kGone) gone_ = true;
      if (arrival.kind != UsbArrival::Kind::kBytes) break;
      if (arrival.bytes.size() > 2) received.insert(received.end(), arrival.bytes.begin() + 2, arrival.bytes.end());
    }
    return received;
  }

  /// Whatever is still on its way from before.
  void drain() {
    const std::uint64_t end_ns = bus_.clock_ns() + kMaxDrain_ns;
    while (!gone_ && bus_.clock_ns() < end_ns && !receive(1, 3 * kMillisecond_ns).empty()) {
    }
  }

  [[nodiscard]] bool answersCommands() {
    request(kEventChar, kFlushAtFrameEnd);
    request(kLatency, 1);
    request(kBaud, kBaudRunning);
    purge();
    drain();
    FalconReplyReader reader;
    for (int i = 0; i < kRunningTries && !gone_; ++i) {
      if (port_.send(encode(FalconCommand{.homing = true})) != UsbOutcome::kDone) return false;
      for (const std::uint8_t byte : receive(kFalconFrame_bytes, 20 * kMillisecond_ns)) {
        if (reader.take(byte)) {
          drain();
          return true;
        }
      }
    }
    return false;
  }

  [[nodiscard]] bool greet() {
    purge();
    request(kEventChar, 0);
    request(kLatency, 16);
    request(kBaud, kBaudGreeting);
    request(kData, kEightBitsNoParity);
    request(kFlowControl, 0);
    request(kModemControl, kRtsLow);
    request(kModemControl, kDtrLow);
    request(kModemControl, kDtrHigh);
    drain();
    for (int i = 0; i < kGreetings && !gone_; ++i) {
      if (port_.send(kGreeting) != UsbOutcome::kDone) return false;
      auto answer = receive(kGreeted.size(), 40 * kMillisecond_ns);
      if (!answer.empty() && answer.front() == 0) answer.erase(answer.begin());
      if (answer.size() + 1 == kGreeted.size()) {  // a leading zero took a place
        const auto rest = receive(1, 40 * kMillisecond_ns);
        answer.insert(answer.end(), rest.begin(), rest.end());
      }
      if (std::ranges::equal(answer, kGreeted)) return true;
    }
    return false;
  }

  [[nodiscard]] std::optional<UsbRefusal> load(const FalconFirmware& firmware) {
    request(kModemControl, kDtrLow);
    request(kBaud, kBaudLoader);
    if (port_.send(kLoad) != UsbOutcome::kDone || !std::ranges::equal(receive(1, 100 * kMillisecond_ns), kLoad)) {
      return refusal(DeviceFault::kFirmware, "does not begin to load firmware");
    }
    const std::span<const std::uint8_t> all(firmware);
    for (std::size_t at = 0; at < all.size(); at += kPayload_bytes) {
      const auto piece = all.subspan(at, std::min(kPayload_bytes, all.size() - at));
      if (port_.send(piece) != UsbOutcome::kDone)
        return refusal(DeviceFault::kFirmware, "took no firmware" + place(at));
      const auto echo = receive(piece.size(), 200 * kMillisecond_ns);
      if (gone_) return refusal(DeviceFault::kUnplugged, "went away while its firmware was loaded");
      if (!std::ranges::equal(echo, piece)) {
        const auto wrong = std::ranges::mismatch(echo, piece).in1 - echo.begin();
        return refusal(DeviceFault::kFirmware, "the firmware arrived damaged: its echo differs" +
                                                   place(at + static_cast<std::size_t>(wrong)) +
                                                   "; switch the Falcon off and on if this comes again");
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] static std::string place(std::size_t byte) { return " at byte " + std::to_string(byte); }

  UsbPort& port_;
  UsbBus& bus_;
  bool gone_ = false;
};

}  // namespace

std::optional<UsbRefusal> bootFalcon(UsbPort& port, UsbBus& bus, const std::optional<FalconFirmware>& firmware) {
  return Boot(port, bus).run(firmware);
}

}  // namespace haptics
