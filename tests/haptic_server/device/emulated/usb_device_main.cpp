// emulated_usb_device falcon|wooden NODE CONTROL: a device on USB as a process of its own, which outlives the programs that
// open it. NODE is the Unix socket of its usbfs node (usbfs_wire.h), CONTROL one on which a test breaks it, line by line.
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/process/passed_descriptor.h"
#include "tests/haptic_server/device/emulated/falcon_model.h"
#include "tests/haptic_server/device/emulated/usbfs_node.h"
#include "tests/haptic_server/device/emulated/wooden_model.h"

namespace haptics::test {
namespace {

/// Hardware is not delayed by what runs on the processor: above watchdog and servo, where that is permitted.
constexpr int kHardwarePriority = 90;
constexpr int kWaiting = 8;

int listenAt(const char* path, int type) {
  const int listening = socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
  if (bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listening, kWaiting) != 0) {
    std::perror(path);
    std::exit(1);
  }
  return listening;
}

void answer(int program, const NodeReply& reply, const FileHandle& descriptor = FileHandle()) {
  (void)sendWith(program, &reply, sizeof reply, descriptor.descriptor(), MSG_DONTWAIT);
}

class Hardware {
 public:
  Hardware(std::unique_ptr<EmulatedUsb> device, const char* node, const char* control)
      : node_(std::move(device)), programs_(listenAt(node, SOCK_SEQPACKET)), tests_(listenAt(control, SOCK_STREAM)) {}

  [[noreturn]] void run() {
    for (;;) {
      const std::uint64_t now_ns = monotonicNow_ns();
      const std::uint64_t next_ns = std::max(node_.work(now_ns), now_ns + 1);
      wait(next_ns - now_ns);
    }
  }

 private:
  struct Test {
    int socket;
    std::string heard;
  };

  void wait(std::uint64_t time_ns) {
    std::vector<pollfd> polled{{programs_, POLLIN, 0}, {tests_, POLLIN, 0}};
    for (const int program : openedBy_) polled.push_back({program, POLLIN, 0});
    for (const Test& test : testedBy_) polled.push_back({test.socket, POLLIN, 0});
    const timespec left{static_cast<time_t>(time_ns / 1'000'000'000), static_cast<long>(time_ns % 1'000'000'000)};
    if (ppoll(polled.data(), polled.size(), &left, nullptr) <= 0) return;
    const std::size_t programs = openedBy_.size(), tests = testedBy_.size();
    for (std::size_t i = 0; i < programs; ++i) {
      if (polled[2 + i].revents != 0 && !serve(openedBy_[i])) close(std::exchange(openedBy_[i], -1));
    }
    for (std::size_t i = 0; i < tests; ++i) {
      if (polled[2 + programs + i].revents != 0 && !serve(testedBy_[i])) close(std::exchange(testedBy_[i].socket, -1));
    }
    std::erase(openedBy_, -1);
    std::erase_if(testedBy_, [](const Test& test) { return test.socket < 0; });
    if (polled[0].revents != 0) openedBy_.push_back(accept4(programs_, nullptr, nullptr, SOCK_CLOEXEC));
    if (polled[1].revents != 0) testedBy_.push_back({accept4(tests_, nullptr, nullptr, SOCK_CLOEXEC), {}});
  }

  [[nodiscard]] bool serve(int program) {
    NodeRequest request;
    if (recv(program, &request, sizeof request, 0) != sizeof request) return false;
    if (request.node != 0) {
      answer(program, node_.ioctl(request));
      return true;
    }
    const int opened = node_.open();
    NodeReply reply{.result = std::min(opened, 0)};
    const auto descriptors = node_.descriptors();
    std::ranges::copy(descriptors, reply.data.begin());
    reply.length = static_cast<std::uint32_t>(descriptors.size());
    answer(program, reply, FileHandle(opened));
    return true;
  }

  [[nodiscard]] bool serve(Test& test) {
    char bytes[200];
    const ssize_t count = recv(test.socket, bytes, sizeof bytes, 0);
    if (count <= 0) return false;
    test.heard.append(bytes, static_cast<std::size_t>(count));
    for (std::size_t end = 0; (end = test.heard.find('\n')) != std::string::npos;) {
      const std::string said = node_.command(test.heard.substr(0, end)) + '\n';
      test.heard.erase(0, end + 1);
      if (send(test.socket, said.data(), said.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0) return false;
    }
    return true;
  }

  UsbfsNode node_;
  int programs_, tests_;
  std::vector<int> openedBy_;
  std::vector<Test> testedBy_;
};

}  // namespace
}  // namespace haptics::test

int main(int argc, char** argv) {
  using namespace haptics::test;
  if (argc != 4) {
    std::fputs("emulated_usb_device falcon|wooden NODE CONTROL\n", stderr);
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // it goes with the test
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param priority{.sched_priority = kHardwarePriority};
  sched_setscheduler(0, SCHED_FIFO, &priority);
  std::unique_ptr<EmulatedUsb> device;
  if (std::strcmp(argv[1], "wooden") == 0) {
    device = std::make_unique<WoodenModel>();
  } else {
    device = std::make_unique<FalconModel>();
  }
  Hardware hardware(std::move(device), argv[2], argv[3]);
  std::puts("ready");
  std::fflush(stdout);
  hardware.run();
}
