// --device haply[:ID][@PORT]: Haply's Inverse3 and Minverse, with a VerseGrip where there is one, through the maker's service, a
// WebSocket with JSON. haply.md, beside this file, says how it is used.
//
// The service answers each message by one state, and a force lasts until its next tick: whoever falls silent has an idle device.
#include <poll.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/clock/monotonic.h"
#include "haptic_server/device/plugin/device_plugin.h"
#include "haptic_server/device/plugin/vendors/haply_message.h"

namespace haptics {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

constexpr std::uint16_t kUsualPort = 10001;
constexpr std::chrono::seconds kConnectWithin{2};
constexpr std::size_t kLongestMessage = 64 * 1024;
/// From the instant that a state is of to its message: a tick of the service.
constexpr std::uint32_t kTick_us = 333;
/// No figure is published: assumed.
constexpr double kMaxForce_N = 5;
/// A force of at least kTold_N that the service does not tell of at all for so many states: it did not understand it.
constexpr double kTold_N = 0.5;
constexpr int kNotUnderstood = 50;
/// A force that is off what was sent by so much of it, for so many states, is worth a word: damper, gate, others' forces.
constexpr double kOff = 0.3;
constexpr int kOffFor = 200;

struct Choice {
  std::string id;
  std::uint16_t port = kUsualPort;
};

[[nodiscard]] std::optional<Choice> choiceOf(std::string_view which) {
  Choice choice;
  const std::size_t at = which.rfind('@');
  choice.id = which.substr(0, at);
  if (at == std::string_view::npos) return choice;
  const std::string_view port = which.substr(at + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), choice.port);
  if (error != std::errc() || end != port.data() + port.size() || choice.port == 0) return std::nullopt;
  return choice;
}

class Haply {
 public:
  explicit Haply(Choice choice) : choice_(std::move(choice)) {}
  ~Haply() {
    if (!socket_.is_open() || ended_) return;
    // The last word is no force; the service takes it away too once nobody speaks.
    (void)write(Vec3(0));
    run(std::chrono::milliseconds(50), [this] { return !writing_; });
  }
  Haply(const Haply&) = delete;
  Haply& operator=(const Haply&) = delete;

  /// Empty, or why not.
  [[nodiscard]] std::string open() {
    std::string reason = connect();
    if (!reason.empty()) return reason;
    receive();
    run(kConnectWithin, [this] { return received_ || ended_; });
    if (!newest_) return "Haply's service: " + (why_.empty() ? "it tells of no device" : why_);
    choice_.id = newest_->id;
    inUseBefore_ = newest_->isInUse.value_or(false);
    turns_ = newest_->rotation.has_value();
    received_ = false;
    configures_ = true;
    (void)write(Vec3(0));
    run(kConnectWithin, [this] { return received_ || ended_; });
    return received_ && newest_ ? "" : "Haply's service does not answer a command";
  }

  void describe(haptics_device_info& info) const {
    info = {};
    ("Inverse3 " + choice_.id).copy(info.name, sizeof info.name - 1);
    info.max_force_N = kMaxForce_N;
    info.max_rate_Hz = 2'000;
    info.delay_s = 1e-3;
    info.degrees = turns_ ? 6 : 3;
  }

  [[nodiscard]] int read(std::uint64_t timeout_ns, haptics_device_state& state) {
    waitForState(timeout_ns);
    if (ended_) return HAPTICS_DEVICE_GONE;
    if (!std::exchange(received_, false)) return HAPTICS_DEVICE_NOTHING;
    if (!newest_) {
      tell(state, why_);
      return -1;
    }
    const HaplyMessage& said = *newest_;
    if (turns_ && !said.rotation) {
      tell(state, "its grip is not there any more");
      return -1;
    }
    std::copy_n(&said.position.x, 3, state.position_m);
    const Quat q = said.rotation.value_or(Quat(1, 0, 0, 0));
    const double orientation[4]{q.w, q.x, q.y, q.z};
    std::copy_n(orientation, 4, state.orientation);
    state.age_us = kTick_us;
    state.buttons = said.buttons;
    state.measured = HAPTICS_DEVICE_APPLIED_FORCE;
    std::copy_n(&said.appliedForce_N.x, 3, state.applied_force_N);
    if (said.velocity) {
      std::copy_n(&said.velocity->x, 3, state.velocity_m_per_s);
      state.measured |= HAPTICS_DEVICE_VELOCITY;
    }
    isCalibrated_ = said.isCalibrated.value_or(isCalibrated_);
    isPowered_ = said.isPowered.value_or(isPowered_);
    state.homed = isCalibrated_ ? 1 : 0;
    state.force_off = isPowered_ ? 0 : 1;
    tell(state, condition());
    return HAPTICS_DEVICE_DONE;
  }

  [[nodiscard]] int write(Vec3 force_N) {
    if (ended_) return HAPTICS_DEVICE_GONE;
    force_N_ = force_N;
    hasForce_ = true;
    sendNext();
    io_.restart();
    io_.poll();
    return HAPTICS_DEVICE_DONE;
  }

 private:
  Choice choice_;
  asio::io_context io_{1};
  beast::websocket::stream<beast::tcp_stream> socket_{io_};
  beast::flat_buffer buffer_;
  std::string sent_;
  bool writing_ = false, hasForce_ = false, configures_ = false, ended_ = false, received_ = false;
  bool turns_ = false, inUseBefore_ = false, isCalibrated_ = true, isPowered_ = true;
  Vec3 force_N_{0}, sentForce_N_{0};
  HaplySpelling spelling_ = HaplySpelling::kVector;
  int silentOn_ = 0, off_ = 0;
  std::optional<HaplyMessage> newest_;
  std::string why_;

  template <class Condition>
  void run(std::chrono::nanoseconds time, Condition until) {
    const auto end = std::chrono::steady_clock::now() + time;
    io_.restart();
    while (!until() && io_.run_one_until(end) != 0) {
    }
  }

  /// As run(), which waits for whole milliseconds.
  void waitForState(std::uint64_t timeout_ns) {
    const std::uint64_t end_ns = monotonicNow_ns() + timeout_ns;
    for (;;) {
      io_.restart();
      io_.poll();
      const std::uint64_t now_ns = monotonicNow_ns();
      if (received_ || ended_ || now_ns >= end_ns) return;
      const short events = writing_ ? POLLIN | POLLOUT : POLLIN;
      pollfd ready{beast::get_lowest_layer(socket_).socket().native_handle(), events, 0};
      const timespec left{static_cast<time_t>((end_ns - now_ns) / 1'000'000'000),
                          static_cast<long>((end_ns - now_ns) % 1'000'000'000)};
      (void)::ppoll(&ready, 1, &left, nullptr);
    }
  }

  [[nodiscard]] std::string connect() {
    std::optional<error_code> done;
    const auto finish = [&](const error_code& error) { done = error; };
    const std::string where = "127.0.0.1:" + std::to_string(choice_.port);
    auto& stream = beast::get_lowest_layer(socket_);
    stream.expires_after(kConnectWithin);
    stream.async_connect(asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), choice_.port), finish);
    run(2 * kConnectWithin, [&] { return done.has_value(); });
    if (!done || *done)
      return "Haply's service does not listen at " + where + ": start it (Haply Hub, or haply-inverse-service)";
    stream.socket().set_option(asio::ip::tcp::no_delay(true));
    done.reset();
    socket_.async_handshake(where, "/", finish);
    run(2 * kConnectWithin, [&] { return done.has_value(); });
    if (!done || *done) return "what listens at " + where + " is no service of Haply's";
    stream.expires_never();
    socket_.read_message_max(kLongestMessage);
    return {};
  }

  void receive() {
    socket_.async_read(buffer_, [this](const error_code& error, std::size_t) {
      if (error) {
        ended_ = true;
        return;
      }
      const auto bytes = buffer_.cdata();
      newest_ = parseHaply({static_cast<const char*>(bytes.data()), bytes.size()}, choice_.id, why_);
      received_ = true;
      buffer_.consume(buffer_.size());
      if (newest_) judgeApplied(newest_->appliedForce_N);
      receive();
    });
  }

  /// The newest force, once the last one is on its way: there is never more than one message before it.
  void sendNext() {
    if (writing_ || !hasForce_) return;
    hasForce_ = false;
    writing_ = true;
    sentForce_N_ = force_N_;
    sent_ = haplyCommand(choice_.id, force_N_, spelling_, std::exchange(configures_, false));
    socket_.async_write(asio::buffer(sent_), [this](const error_code& error, std::size_t) {
      writing_ = false;
      if (error) ended_ = true;
      if (!ended_) sendNext();
    });
  }

  void judgeApplied(Vec3 applied_N) {
    const double sent_N = glm::length(sentForce_N_);
    if (sent_N < kTold_N) {
      silentOn_ = off_ = 0;
      return;
    }
    silentOn_ = applied_N == Vec3(0) ? silentOn_ + 1 : 0;
    off_ = glm::length(applied_N - sentForce_N_) > kOff * sent_N ? off_ + 1 : 0;
    if (silentOn_ < kNotUnderstood) return;
    silentOn_ = 0;
    spelling_ = spelling_ == HaplySpelling::kVector ? HaplySpelling::kValues : HaplySpelling::kVector;
  }

  [[nodiscard]] std::string condition() const {
    if (!isPowered_) return "its force is off: it has no power supply";
    if (!isCalibrated_) return "it is not calibrated: do as Haply Hub says";
    if (off_ > kOffFor)
      return "its service applies another force than the server's: force gate, damping, or another program";
    if (inUseBefore_) return "another program commands it too: the forces of both add up";
    return {};
  }

  static void tell(haptics_device_state& state, std::string_view words) {
    state.condition[words.copy(state.condition, sizeof state.condition - 1)] = 0;
  }
};

const char* openDevice(const char* which, void** device, haptics_device_info* info) {
  static std::string reason;
  auto choice = choiceOf(which);
  if (!choice)
    return "after the colon, the device's ID is wanted, @ and the service's port, or both, as in :049D@10001";
  auto opened = std::make_unique<Haply>(*std::move(choice));
  reason = opened->open();
  if (!reason.empty()) return reason.c_str();
  opened->describe(*info);
  *device = opened.release();
  return nullptr;
}

}  // namespace
}  // namespace haptics

extern "C" __attribute__((visibility("default"))) const haptics_device_functions* haptics_device_plugin() {
  using haptics::Haply;
  static const haptics_device_functions functions{
      HAPTICS_DEVICE_ABI,
      haptics::openDevice,
      [](void* device, std::uint64_t timeout_ns, haptics_device_state* state) {
        return static_cast<Haply*>(device)->read(timeout_ns, *state);
      },
      [](void* device, const double* f, const double*) {
        return static_cast<Haply*>(device)->write({f[0], f[1], f[2]});
      },
      [](void* device) { delete static_cast<Haply*>(device); },
      nullptr};
  return &functions;
}
