#include "tests/sim/line.h"

#include <algorithm>
#include <deque>
#include <string>
#include <utility>

namespace haptics::sim {
namespace {

constexpr int kClient = 0;
constexpr int kServer = 1;
/// What the two systems hold of one direction: sent and not yet read.
constexpr std::size_t kWindow_bytes = 128U << 10;
constexpr double kLongestNotice_ms = 500;
constexpr std::uint64_t kCloseWithin_ns = kSecond_ns;

}  // namespace

struct Line::Wire : std::enable_shared_from_this<Wire> {
  struct End {
    const char* name = "";
    std::shared_ptr<Transport::Events> events;  // null before start, after closed and after destruction
    bool destroyed = false;
    bool closing = false;  // sends nothing new, receives nothing
    bool reads = true;
    std::string why;

    std::string outgoing;
    bool transmitting = false;
    std::size_t unread_bytes = 0;  // sent by this end
    std::uint64_t lastArrival_ns = 0;
    bool said_goodbye = false;

    std::deque<std::string> arrived;
    bool peerLeft = false;
  };

  Wire(VirtualTime& time_, Random& random_, const Weather& weather_) : time(time_), random(random_), weather(weather_) {
    ends[kClient].name = "client";
    ends[kServer].name = "server";
  }

  [[nodiscard]] bool dead() const { return broken || silent; }

  void transmit(int from) {
    End& end = ends[from];
    if (dead() || end.transmitting || end.outgoing.empty() || end.unread_bytes >= kWindow_bytes) return;
    const std::size_t most = std::min(end.outgoing.size(), weather.largestPiece);
    const std::size_t size = most == end.outgoing.size() && random.chance(0.5) ? most : 1 + random.below(most);
    std::string piece = end.outgoing.substr(0, size);
    end.outgoing.erase(0, size);
    end.transmitting = true;
    end.unread_bytes += size;
    const auto takes_ns = static_cast<std::uint64_t>(1e9 * static_cast<double>(size) / weather.bytesPerSecond);
    time.after(takes_ns, weak_from_this(), [this, from, piece = std::move(piece)]() mutable {
      ends[from].transmitting = false;
      carry(from, std::move(piece));
      const auto events = ends[from].events;
      if (events && ends[from].outgoing.empty() && !ends[from].closing && events->drained) events->drained();
      if (ends[from].closing) leave(from);
      transmit(from);
    });
  }

  /// The delay of what is sent now; never overtakes what was sent before.
  std::uint64_t arrival_ns(int from) {
    std::uint64_t delay_ns = random.milliseconds(weather.latency_ms, weather.latency_ms + weather.jitter_ms);
    if (random.chance(weather.stallChance)) delay_ns += random.milliseconds(0, weather.stall_ms);
    ends[from].lastArrival_ns = std::max(ends[from].lastArrival_ns, time.now_ns() + delay_ns);
    return ends[from].lastArrival_ns - time.now_ns();
  }

  void carry(int from, std::string piece) {
    if (dead()) return;
    time.after(arrival_ns(from), shared_from_this(), [this, from, piece = std::move(piece)]() mutable {
      if (dead()) return;
      ends[1 - from].arrived.push_back(std::move(piece));
      read(1 - from);
    });
  }

  void read(int at) {
    End& end = ends[at];
    while (end.reads && !end.arrived.empty()) {
      if (!end.events && !end.destroyed && !end.closing) return;  // not started yet
      const std::string piece = std::move(end.arrived.front());
      end.arrived.pop_front();
      ends[1 - at].unread_bytes -= piece.size();
      if (const auto events = end.events; events && !end.closing && events->received) events->received(piece);
    }
    if (end.reads && end.arrived.empty() && end.peerLeft) finish(at, "closed by the peer");
    transmit(1 - at);
  }

  /// Sends what is queued, then says goodbye.
  void leave(int from) {
    End& end = ends[from];
    if (end.said_goodbye || !end.outgoing.empty() || end.transmitting) return;
    end.said_goodbye = true;
    if (!dead()) {
      time.after(arrival_ns(from), shared_from_this(), [this, from] {
        if (dead()) return;
        ends[1 - from].peerLeft = true;
        read(1 - from);
      });
    }
    finish(from, end.why);
  }

  void finish(int at, const std::string& why) {
    End& end = ends[at];
    end.closing = true;
    end.outgoing.clear();
    if (const auto events = std::exchange(end.events, nullptr); events && events->closed) events->closed(why);
  }

  VirtualTime& time;
  Random& random;
  const Weather& weather;
  End ends[2];
  bool broken = false;
  bool silent = false;
};

namespace {

class SimTransport final : public Transport {
 public:
  SimTransport(std::shared_ptr<Line::Wire> wire, int end) : wire_(std::move(wire)), end_(end) {}
  ~SimTransport() override {
    self().events = nullptr;
    self().destroyed = self().closing = true;
    self().outgoing.clear();
    wire_->leave(end_);
    wire_->read(end_);
  }

  void start(Events events) override {
    self().events = std::make_shared<Events>(std::move(events));
    wire_->time.after(0, wire_, [wire = wire_.get(), end = end_] { wire->read(end); });
  }
  void send(std::string bytes) override {
    if (self().closing) return;
    self().outgoing += bytes;
    wire_->transmit(end_);
  }
  [[nodiscard]] std::size_t backlog() const noexcept override { return self().outgoing.size(); }
  void close(const std::string& why) override {
    if (self().closing) return;
    self().closing = true;
    self().why = why;
    const auto leave = [wire = wire_.get(), end = end_] { wire->leave(end); };
    wire_->time.after(0, wire_, leave);
    wire_->time.after(kCloseWithin_ns, wire_, [wire = wire_.get(), end = end_, leave] {
      wire->ends[end].outgoing.clear();
      wire->ends[end].transmitting = false;
      leave();
    });
  }
  [[nodiscard]] std::string peer() const override { return wire_->ends[1 - end_].name; }

 private:
  [[nodiscard]] Line::Wire::End& self() const { return wire_->ends[end_]; }

  std::shared_ptr<Line::Wire> wire_;
  int end_;
};

}  // namespace

Line::Line(VirtualTime& time, Random& random, const Weather& weather)
    : wire_(std::make_shared<Wire>(time, random, weather)) {}

std::unique_ptr<Transport> Line::takeClient() { return std::make_unique<SimTransport>(wire_, kClient); }
std::unique_ptr<Transport> Line::takeServer() { return std::make_unique<SimTransport>(wire_, kServer); }

void Line::cut() {
  wire_->broken = true;
  for (const int at : {kClient, kServer}) {
    wire_->time.after(wire_->random.milliseconds(0, kLongestNotice_ms), wire_,
                      [wire = wire_.get(), at] { wire->finish(at, "the line broke"); });
  }
}

void Line::fallSilent() { wire_->silent = true; }

void Line::clientReads(bool reads) {
  wire_->ends[kClient].reads = reads;
  if (reads) wire_->time.after(0, wire_, [wire = wire_.get()] { wire->read(kClient); });
}

}  // namespace haptics::sim
