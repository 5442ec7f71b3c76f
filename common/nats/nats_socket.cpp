#include "common/nats/nats_socket.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <system_error>
#include <thread>

namespace haptics {
namespace {

using Clock = std::chrono::steady_clock;

/// After which a server that has not answered is left.
constexpr std::chrono::milliseconds kServerWithin{1500};
constexpr std::chrono::milliseconds kLook{50};
constexpr std::uint16_t kDefaultPort = 4222;

std::set<std::uint16_t> portsOf(const std::string& urls) {
  std::set<std::uint16_t> ports;
  std::istringstream in(urls);
  for (std::string url; std::getline(in, url, ',');) {
    std::uint16_t port = 0;
    const char* const end = url.data() + url.size();
    const std::size_t colon = url.rfind(':');
    if (colon == std::string::npos || std::from_chars(url.data() + colon + 1, end, port).ec != std::errc()) {
      port = kDefaultPort;
    }
    ports.insert(port);
  }
  return ports;
}

/// Of the other end; 0: it is no TCP socket, or has none yet.
std::uint16_t peerPort(int descriptor) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return 0;
  if (peer.ss_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in&>(peer).sin_port);
  if (peer.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6&>(peer).sin6_port);
  return 0;
}

std::uint64_t inodeOf(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

std::set<NatsSocket> socketsTo(const std::set<std::uint16_t>& ports) {
  std::set<NatsSocket> sockets;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", failed)) {
    const std::string name = entry.path().filename();
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    if (ports.contains(peerPort(descriptor))) sockets.emplace(descriptor, inodeOf(descriptor));
  }
  return sockets;
}

}  // namespace

bool NatsSocket::isOpen() const { return descriptor_ >= 0 && inodeOf(descriptor_) == inode_; }

std::uint64_t NatsSocket::received_bytes() const {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (!isOpen() || getsockopt(descriptor_, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
  return info.tcpi_bytes_received;
}

void NatsSocket::shutDown() const {
  if (isOpen()) (void)::shutdown(descriptor_, SHUT_RDWR);
}

natsStatus connectToNats(natsConnection*& made, natsOptions& options, const std::string& urls,
                         const std::stop_token& stop, NatsSocket& socket) {
  static std::mutex connecting;  // one after the other: what is new is this one's
  const std::lock_guard lock(connecting);
  if (stop.stop_requested()) return NATS_TIMEOUT;
  const std::set<std::uint16_t> ports = portsOf(urls);
  const std::set<NatsSocket> before = socketsTo(ports);
  std::mutex mutex;
  std::condition_variable_any changed;
  const std::stop_callback onStop(stop, [&] { changed.notify_all(); });
  std::jthread watch([&](const std::stop_token& done) {
    std::map<NatsSocket, Clock::time_point> seen;
    std::unique_lock waiting(mutex);
    while (!done.stop_requested()) {
      changed.wait_for(waiting, done, kLook, [&] { return stop.stop_requested(); });
      if (done.stop_requested()) return;
      if (stop.stop_requested()) std::this_thread::sleep_for(kLook);
      for (const NatsSocket& one : socketsTo(ports)) {
        if (before.contains(one)) continue;
        const auto since = seen.emplace(one, Clock::now()).first->second;
        if (stop.stop_requested() || Clock::now() - since > kServerWithin) one.shutDown();
      }
    }
  });
  const natsStatus status = natsConnection_Connect(&made, &options);
  watch.request_stop();
  watch.join();
  if (status != NATS_OK) return status;
  for (const NatsSocket& one : socketsTo(ports)) {
    if (!before.contains(one)) socket = one;
  }
  return NATS_OK;
}

}  // namespace haptics
