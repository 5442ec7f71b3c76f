// emulated_haply PORT [values] [before]: Haply's service with one Inverse3 and a VerseGrip, as its pages have it: all of it on
// connecting, then one state for each message. Its hand leads a mass round a circle, up and down, against the force, which ends when nobody
// has sent one for 10 ms. "values": forces are spelled so; "before": another program commands it already.
//
// A line on standard input, "FAULT MS", breaks it. Then it prints when that began, and when there was no force (CLOCK_MONOTONIC,
// ns). "watch 0" only prints the latter; "applied 0" prints the force that its motors give; "rest 1" keeps the hand in one place.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/clock/monotonic.h"
#include "common/maths/vec.h"

namespace haptics {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;
using nlohmann::json;
using Socket = beast::websocket::stream<asio::ip::tcp::socket>;

constexpr std::chrono::microseconds kTick{500};
constexpr std::uint64_t kForget_ns = 10'000'000;
constexpr std::array kFaults{"silence",   "garbage",      "null", "jump", "missing",
                             "unpowered", "uncalibrated", "weak", "drop"};

class Service {
 public:
  Service(asio::io_context& io, std::uint16_t port, std::string spelling, bool inUse)
      : io_(io),
        acceptor_(io, {asio::ip::address_v4::loopback(), port}),
        spelling_(std::move(spelling)),
        inUse_(inUse) {}

  void run() {
    accept();
    hear();
    tick();
    std::puts("ready");
    io_.run();
  }

 private:
  struct Session {
    Socket socket;
    beast::flat_buffer in{};
    std::string out{};
    explicit Session(asio::ip::tcp::socket&& accepted) : socket(std::move(accepted)) {}
  };

  asio::io_context& io_;
  asio::ip::tcp::acceptor acceptor_;
  std::string spelling_;
  bool inUse_;
  std::list<std::weak_ptr<Session>> sessions_;
  asio::steady_timer timer_{io_};
  asio::posix::stream_descriptor input_{io_, ::dup(STDIN_FILENO)};
  asio::streambuf lines_;
  Vec3 at_{0.02, 0, 0.02}, velocity_{0}, force_{0};
  std::uint64_t forced_ns_ = 0, until_ns_ = 0;
  std::string fault_;
  bool watching_ = false, resting_ = false;

  [[nodiscard]] bool broken(const char* fault) const { return fault_ == fault; }
  [[nodiscard]] Vec3 applied() const {
    const bool idle = monotonicNow_ns() > forced_ns_ + kForget_ns || broken("unpowered");
    return idle ? Vec3(0) : (broken("weak") ? 0.4 : 1) * force_;
  }

  void accept() {
    acceptor_.async_accept([this](const error_code& error, asio::ip::tcp::socket accepted) {
      if (!error) {
        accepted.set_option(asio::ip::tcp::no_delay(true));
        auto session = std::make_shared<Session>(std::move(accepted));
        session->socket.async_accept([this, session](const error_code& failed) {
          if (failed) return;
          sessions_.push_back(session);
          send(session, true);
          receive(session);
        });
      }
      accept();
    });
  }

  void receive(const std::shared_ptr<Session>& session) {
    session->socket.async_read(session->in, [this, session](const error_code& error, std::size_t) {
      if (error) return;
      const auto bytes = session->in.cdata();
      const json message =
          json::parse(std::string_view(static_cast<const char*>(bytes.data()), bytes.size()), nullptr, false);
      session->in.consume(session->in.size());
      take(message);
      if (!broken("silence")) send(session, message.contains("session"));
      receive(session);
    });
  }

  void take(const json& message) {
    try {
      const json& force = message.at("inverse3").at(0).at("commands").at("set_cursor_force").at(spelling_);
      force_ = {force.at("x").get<double>(), force.at("y").get<double>(), force.at("z").get<double>()};
      forced_ns_ = monotonicNow_ns();
    } catch (const json::exception&) {
      force_ = Vec3(0);  // what it does not understand is no force
    }
  }

  void send(const std::shared_ptr<Session>& session, bool whole) {
    const auto vector = [](Vec3 v) { return json{{"x", v.x}, {"y", v.y}, {"z", v.z}}; };
    json state{{"cursor_position", vector(at_ + Vec3(broken("jump") ? 0.05 : 0, 0, 0))},
               {"cursor_velocity", vector(velocity_)},
               {"current_cursor_force", vector(applied())}};
    if (broken("null")) state["cursor_position"]["y"] = nullptr;
    json device{{"device_id", "049D"}, {"state", state}};
    device["status"] = {
        {"calibrated", !broken("uncalibrated")}, {"in_use", inUse_}, {"power_supply", !broken("unpowered")}};
    if (whole) device["config"] = {{"type", "inverse3"}};
    const json grip{
        {"device_id", "61548"},
        {"state", {{"orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}}, {"button", false}, {"hall", 0}}}};
    const json message{{"inverse3", broken("missing") ? json::array() : json::array({device})}, {"verse_grip", {grip}}};
    session->out = broken("garbage") ? "{\"inverse3\":[" : message.dump();
    session->socket.async_write(asio::buffer(session->out), [session](const error_code&, std::size_t) {});
  }

  void tick() {
    timer_.expires_after(kTick);
    timer_.async_wait([this](const error_code&) {
      const std::uint64_t now_ns = monotonicNow_ns();
      move(1e-9 * static_cast<double>(now_ns));
      if (watching_ && applied() == Vec3(0)) {
        std::printf("zero %llu\n", static_cast<unsigned long long>(now_ns));
        watching_ = false;
      }
      if (!fault_.empty() && now_ns > until_ns_) fault_.clear();
      tick();
    });
  }

  void move(double t) {
    constexpr double kMass = 0.25, kSpring = 400, kDamper = 6, kStep = 5e-4;
    const Vec3 hand = resting_
                          ? Vec3(0)
                          : Vec3(0.02 * std::cos(1.57 * t), 0.02 * std::sin(1.57 * t), 0.012 * std::cos(5 * t) - 0.002);
    velocity_ += kStep / kMass * (applied() + kSpring * (hand - at_) - kDamper * velocity_);
    at_ += kStep * velocity_;
  }

  void hear() {
    asio::async_read_until(input_, lines_, '\n', [this](const error_code& error, std::size_t) {
      if (error) return io_.stop();
      std::istream stream(&lines_);
      std::string word;
      double value = 0;
      stream >> word >> value;
      stream.ignore(64, '\n');
      obey(word, value);
      hear();
    });
  }

  void obey(const std::string& word, double value) {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (word == "rest") resting_ = value != 0;
    if (word == "watch") watching_ = true;
    if (word == "applied") std::printf("applied %.0f\n", 1e3 * glm::length(applied()));
    if (std::ranges::find(kFaults, word) == kFaults.end()) return;
    fault_ = word;
    until_ns_ = now_ns + static_cast<std::uint64_t>(value * 1e6);
    watching_ = true;
    std::printf("%s %llu\n", word.c_str(), static_cast<unsigned long long>(now_ns));
    if (word != "drop") return;
    for (const auto& weak : sessions_) {
      if (const auto session = weak.lock()) session->socket.next_layer().close();
    }
    sessions_.clear();
  }
};

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto given = [&](const char* word) {
    return std::any_of(argv + 2, argv + argc, [&](const char* argument) { return std::string(argument) == word; });
  };
  boost::asio::io_context io{1};
  haptics::Service(io, static_cast<std::uint16_t>(std::strtoul(argv[1], nullptr, 10)),
                   given("values") ? "values" : "vector", given("before"))
      .run();
  return 0;
}
