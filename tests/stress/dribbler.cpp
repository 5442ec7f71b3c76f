#include "tests/stress/dribbler.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "common/wire/framing.h"

namespace haptics::stress {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPerByte{20};
constexpr double kAllTelemetry_Hz = 1000;

std::string frameOf(v1::Envelope& envelope, std::uint64_t number) {
  envelope.set_protocol_version(kProtocolVersion);
  envelope.set_message_id(number);
  std::string frame;
  (void)appendFrame(frame, envelope);
  return frame;
}

/// False when the server has closed the connection.
bool dribble(int socket, const std::string& frame) {
  for (const char& byte : frame) {
    char in = 0;
    if (send(socket, &byte, 1, MSG_NOSIGNAL) != 1) return false;
    if (recv(socket, &in, 1, MSG_DONTWAIT) == 0) return false;
    std::this_thread::sleep_for(kPerByte);
  }
  return true;
}

void dribbleOneConnection(const Endpoint& server) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int one = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(server.port);
  inet_pton(AF_INET, server.host.c_str(), &address.sin_addr);
  if (connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    v1::Envelope hello, subscribe, heartbeat;
    hello.mutable_hello()->set_session(0xD81B81E);
    hello.mutable_hello()->set_client_name("dribbler");
    subscribe.mutable_subscribe()->set_rate_hz(kAllTelemetry_Hz);
    heartbeat.mutable_heartbeat();
    bool open = dribble(socket, frameOf(hello, 1)) && dribble(socket, frameOf(subscribe, 2));
    for (std::uint64_t number = 3; open; ++number) open = dribble(socket, frameOf(heartbeat, number));
  }
  close(socket);
}

}  // namespace

void runDribbler(const Endpoint& server) {
  for (;;) {
    dribbleOneConnection(server);
    std::this_thread::sleep_for(milliseconds(500));
  }
}

}  // namespace haptics::stress
