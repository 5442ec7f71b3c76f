#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <fstream>
#include <queue>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "tests/stress/impairment.h"
#include "tests/stress/network.h"
#include "tests/stress/statistics.h"

namespace haptics::stress {
namespace {

constexpr const char* kServerHost = "10.99.0.1";
constexpr const char* kClientHost = "10.99.0.2";
constexpr int kMtu = 1400;
constexpr std::size_t kMaxWaiting = 20'000;  // packets; more is loss, as in a router
constexpr int kPoll_ms = 1, kIdlePoll_ms = 100;

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_;
};

void require(bool good, const char* what) {
  if (!good) throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

void setAddress(int socket, ifreq request, unsigned long which, const char* address) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  require(inet_pton(AF_INET, address, &in.sin_addr) == 1, address);
  std::memcpy(&request.ifr_addr, &in, sizeof in);
  require(ioctl(socket, which, &request) == 0, "an address of the device");
}

void bringUp(int socket, const char* device) {
  ifreq request{};
  std::strncpy(request.ifr_name, device, IFNAMSIZ - 1);
  require(ioctl(socket, SIOCGIFFLAGS, &request) == 0, device);
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  require(ioctl(socket, SIOCSIFFLAGS, &request) == 0, device);
}

/// A namespace of its own with one TUN device. It goes with the last process and descriptor that hold it.
struct Side {
  Descriptor space, tun;
};

/// In the calling thread, which it moves into the new namespace.
Side makeSide(const char* address) {
  require(unshare(CLONE_NEWNET) == 0, "a network namespace");
  Side side;
  side.space = Descriptor(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
  side.tun = Descriptor(open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC));
  require(side.tun.get() >= 0, "/dev/net/tun");
  ifreq request{};
  std::strncpy(request.ifr_name, "haptics", IFNAMSIZ - 1);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  require(ioctl(side.tun.get(), TUNSETIFF, &request) == 0, "a TUN device");
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  setAddress(socket.get(), request, SIOCSIFADDR, address);
  setAddress(socket.get(), request, SIOCSIFNETMASK, "255.255.255.0");
  request.ifr_mtu = kMtu;
  require(ioctl(socket.get(), SIOCSIFMTU, &request) == 0, "the device's MTU");
  bringUp(socket.get(), "haptics");
  bringUp(socket.get(), "lo");
  std::ofstream("/proc/sys/net/ipv4/tcp_congestion_control") << "cubic";  // whatever this machine's default is
  return side;
}

class Namespaces final : public Network {
 public:
  explicit Namespaces(const RunPlan& plan) : impairment_(plan) {
    make(server_, kServerHost);
    make(client_, kClientHost);
  }
  ~Namespaces() override { stop(); }

  [[nodiscard]] std::string kind() const override { return "network namespaces, TUN devices, TCP cubic"; }
  [[nodiscard]] std::string serverHost() const override { return kServerHost; }
  [[nodiscard]] std::string clientAddress(std::uint16_t port) override {
    return std::string(kServerHost) + ":" + std::to_string(port);
  }
  void enterServerSide() const override { require(setns(server_.space.get(), CLONE_NEWNET) == 0, "setns"); }
  void enterClientSide() const override { require(setns(client_.space.get(), CLONE_NEWNET) == 0, "setns"); }
  void start() override {
    thread_ = std::thread([this] { forward(); });
  }
  [[nodiscard]] NetworkCounts counts() override {
    stop();
    return {packets_, lost_, percentile(late_ms_, 0.99)};
  }

 private:
  struct Packet {
    std::uint64_t due_ns;
    int to;
    std::vector<char> bytes;
    bool operator>(const Packet& other) const { return due_ns > other.due_ns; }
  };

  static void make(Side& side, const char* address) {
    std::exception_ptr error;
    std::thread([&] {
      try {
        side = makeSide(address);
      } catch (...) {
        error = std::current_exception();
      }
    }).join();
    if (error) std::rethrow_exception(error);
  }

  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  void forward() {
    const sched_param leastOfTheRealTimeOnes{.sched_priority = 1};  // a network does not wait for the machine's load
    sched_setscheduler(0, SCHED_FIFO, &leastOfTheRealTimeOnes);
    const std::array<int, 2> tuns{server_.tun.get(), client_.tun.get()};
    while (!stop_) {
      std::array<pollfd, 2> ready{pollfd{tuns[0], POLLIN, 0}, pollfd{tuns[1], POLLIN, 0}};
      poll(ready.data(), ready.size(), waiting_.empty() ? kIdlePoll_ms : kPoll_ms);
      for (int from : {0, 1}) {
        if (ready[static_cast<std::size_t>(from)].revents & POLLIN)
          take(tuns[static_cast<std::size_t>(from)], 1 - from);
      }
      const std::uint64_t now_ns = monotonicNow_ns();
      while (!waiting_.empty() && waiting_.top().due_ns <= now_ns) {
        const Packet& packet = waiting_.top();
        if (write(tuns[static_cast<std::size_t>(packet.to)], packet.bytes.data(), packet.bytes.size()) < 0) ++lost_;
        late_ms_.push_back(1e-6 * static_cast<double>(now_ns - packet.due_ns));
        waiting_.pop();
      }
    }
  }

  void take(int tun, int to) {
    std::array<char, 2048> bytes;
    for (ssize_t size = 0; (size = read(tun, bytes.data(), bytes.size())) > 0;) {
      if ((bytes[0] >> 4) != 4) continue;  // IPv6's neighbour discovery
      ++packets_;
      const auto due_ns = impairment_.arrival_ns(monotonicNow_ns());
      if (!due_ns || waiting_.size() >= kMaxWaiting) {
        ++lost_;
      } else {
        waiting_.push({*due_ns, to, {bytes.data(), bytes.data() + size}});
      }
    }
  }

  Side server_, client_;
  Impairment impairment_;
  std::priority_queue<Packet, std::vector<Packet>, std::greater<>> waiting_;
  std::atomic<std::uint64_t> packets_{0}, lost_{0};
  std::vector<double> late_ms_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Network> makeNamespaces(const RunPlan& plan) {
  try {
    return std::make_unique<Namespaces>(plan);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_stress: no network namespaces here (%s); a relay in their place\n", error.what());
    return nullptr;
  }
}

}  // namespace haptics::stress
