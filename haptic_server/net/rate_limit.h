#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

namespace haptics {

/// A token bucket: `burst` at once, `perSecond` sustained.
class RateLimit {
 public:
  RateLimit(double perSecond, double burst) noexcept : perSecond_(perSecond), burst_(burst), tokens_(burst) {}

  /// Whether one more, or so many, may pass now. Times in ns, never going back.
  [[nodiscard]] bool allow(std::uint64_t now_ns, double count = 1) noexcept {
    tokens_ = std::min(burst_, tokens_ + static_cast<double>(now_ns - last_ns_) * 1e-9 * perSecond_);
    last_ns_ = now_ns;
    if (tokens_ < count) return false;
    tokens_ -= count;
    return true;
  }

 private:
  double perSecond_;
  double burst_;
  double tokens_;
  std::uint64_t last_ns_ = 0;
};

/// Lets one client's edits through at a bounded rate and in their order. After an edit that came too early all later
/// numbers come too early as well, until one of those that were put off comes again: a client sends them again in
/// order, once it has the answer to each.
class EditGate {
 public:
  static constexpr std::uint32_t kRetryAfter_ms = 100;  ///< How long a client is to wait.
  enum class Cause : std::uint8_t { kRate, kRoom };

  EditGate(double perSecond, double burst) noexcept : rate_(perSecond, burst) {}

  /// Whether the edit may pass now; else it is put off.
  [[nodiscard]] bool allow(std::uint64_t clientSeq, std::uint64_t now_ns) noexcept {
    if (clientSeq <= retryUpTo_) retryUpTo_ = 0;
    if (retryUpTo_ == 0 && rate_.allow(now_ns)) return true;
    if (retryUpTo_ == 0) cause_ = Cause::kRate;
    defer(clientSeq);
    return false;
  }
  /// The edit passed, and the queue had no room for it.
  void retryLater(std::uint64_t clientSeq) noexcept {
    cause_ = Cause::kRoom;
    defer(clientSeq);
  }
  /// Of the last edit that was deferred, or of one before that it may not overtake.
  [[nodiscard]] Cause cause() const noexcept { return cause_; }

 private:
  RateLimit rate_;
  std::uint64_t retryUpTo_ = 0;  // highest number that came too early, and was not let in since
  Cause cause_ = Cause::kRate;

  void defer(std::uint64_t clientSeq) noexcept { retryUpTo_ = std::max(retryUpTo_, clientSeq); }
};

/// How many TLS handshakes a host may begin: each costs the network thread about a millisecond before anyone has said who
/// they are, and telemetry to all others waits for it.
class HandshakeLimit {
 public:
  static constexpr double kPerSecond = 20;        ///< More from one host: the telemetry of others becomes uneven.
  static constexpr double kBurst = 100;           ///< More than the clients of a server that restarts.
  static constexpr std::size_t kMaxHosts = 1024;  ///< Remembered; beyond, all are forgotten.

  [[nodiscard]] bool allow(const std::string& host, std::uint64_t now_ns) {
    if (hosts_.size() >= kMaxHosts && !hosts_.contains(host)) hosts_.clear();
    return hosts_.try_emplace(host, kPerSecond, kBurst).first->second.allow(now_ns);
  }

 private:
  std::unordered_map<std::string, RateLimit> hosts_;
};

}  // namespace haptics
