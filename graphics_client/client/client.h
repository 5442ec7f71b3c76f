#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace haptics {

/// No answer from the server, or it has turned this client away; what() says why.
class NoConnection : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What the server was asked for and does not do; what() names the field, what is wrong, and what would be right.
class Refused : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A mirror of a running haptic server's scene, and edits of it. A thread of its own keeps the connection: it reconnects
/// for ever, and the mirror goes on where it was. SI units, right-handed world frame. Any thread.
class Client {
 public:
  using Vector = std::array<double, 3>;

  /// What the servo felt in one tick.
  struct Tick {
    std::uint64_t tick = 0;
    std::uint64_t time_ns = 0;  ///< The server's monotonic clock when the device was read.
    Vector hip_m{};             ///< Haptic interface point.
    Vector ihip_m{};            ///< Ideal haptic interface point.
    Vector force_N{};           ///< On the hand, as sent to the device.
    std::uint64_t touched = 0;  ///< The body's number; 0: none.
    std::uint64_t missed = 0;   ///< Ticks before it that the servo slept through.
    std::uint64_t lost = 0;     ///< Ticks before it that were computed, and lost: the line or this program is too slow.
  };

  struct Options {
    std::string server = "127.0.0.1:7654";  ///< HOST:PORT.
    std::string credentials = {};           ///< File that the server's credentials came with; empty: without TLS.
    std::string name = "client";            ///< For the server's log, at most 64 bytes.
    double telemetryRate_Hz = 60;           ///< How often State's motion is news; 0: never.
    std::function<void(const Tick&)> onTick = {};  ///< Gets every tick, on a thread of the client's; has to be quick.
    double timeout_s = 10;                         ///< Longest time without a connection or news of an edit.
  };

  /// A body of the scene.
  struct Body {
    std::uint64_t number = 0;
    std::string name;
    Vector position_m{};
    std::array<double, 4> rotation{1, 0, 0,
                                   0};  ///< Unit quaternion w, x, y, z: x_world = rotation * x_body + position.
  };

  /// What is known at one moment.
  struct State {
    bool connected = false;
    std::string connection;      ///< In words: "connected to ...", why not.
    std::uint64_t revision = 0;  ///< Of the scene.
    std::string device;
    std::vector<Body> bodies;  ///< In order of number, each where it is now.

    std::uint64_t tick = 0;     ///< Of what follows; 0: nothing has come yet.
    double age_s = 0;           ///< Of what follows, by the estimated difference of the two clocks.
    Vector hip_m{};             ///< Haptic interface point.
    Vector ihip_m{};            ///< Ideal haptic interface point.
    Vector force_N{};           ///< On the hand, as the device was told.
    std::uint64_t touched = 0;  ///< The body's number; 0: none.
  };

  /// An edit that was applied.
  struct Applied {
    std::uint64_t revision = 0;
    std::uint64_t tick = 0;            ///< Since when it is felt.
    std::vector<std::string> reports;  ///< What reading and making its meshes and images kept and dropped; warnings.
  };

  /// Connects, and waits until the scene is here.
  /// @throws NoConnection none within timeout_s. Refused: an option that is none.
  explicit Client(const Options& options);
  Client() : Client(Options{}) {}
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  [[nodiscard]] State state() const;

  /// One edit, all of it or none, in the text of scene files: `operations { set_pose { ... } }`. Applied exactly once,
  /// however often the connection breaks. Waits until it is felt.
  /// @throws Refused by the server, or because the scene is no longer as the edit expects. NoConnection: it is not known
  /// whether it was applied.
  Applied apply(const std::string& edit);

  /// Moves a body without a motion to a pose, as one of a stream of 50 to 1,000 a second (SetPose.kinematic): it pushes the hand on
  /// its way. Returns at once; the newest pose counts, and what comes faster than the server answers is left out.
  /// @param rotation  w, x, y, z, not 0.
  /// @throws Refused an earlier pose, whichever it was: not finite, of no body of the scene, of one that moves by itself.
  void drive(const std::string& body, const Vector& position_m, const std::array<double, 4>& rotation);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptics
