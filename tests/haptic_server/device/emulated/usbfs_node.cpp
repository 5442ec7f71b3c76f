#include "tests/haptic_server/device/emulated/usbfs_node.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "common/clock/monotonic.h"

namespace haptics::test {
namespace {

constexpr std::uint64_t kAwait_ns = 20'000'000;
constexpr std::uint64_t kHeldUp_ns = 1'000'000;
/// Later than this a reply may miss the tick that it is for.
constexpr std::uint64_t kLate_ns = 200'000;
/// How often the device moves when nobody asks it.
constexpr std::uint64_t kIdle_ns = 20'000'000;
constexpr std::uint64_t kFrameShift_ns = 300'000;

std::vector<std::uint8_t> stringDescriptor(const EmulatedUsb& device, int index) {
  std::vector<std::uint8_t> text{4, 3, 9, 4};  // index 0: in English
  if (index != 0) {
    text = {0, 3};
    for (const char character : device.stringDescriptor(index)) {
      text.push_back(static_cast<std::uint8_t>(character));
      text.push_back(0);
    }
    text[0] = static_cast<std::uint8_t>(text.size());
  }
  return text;
}

/// @param[out] data  What the device answers.
int control(EmulatedUsb& device, std::span<const std::uint8_t, 8> setup, std::vector<std::uint8_t>& data) {
  constexpr unsigned kToHost = 0x80, kGetDescriptor = 6, kGetConfiguration = 8, kSetConfiguration = 9;
  const unsigned type = setup[0], request = setup[1], value = setup[2] | setup[3] << 8U,
                 most = setup[6] | setup[7] << 8U;
  if (type == kToHost && request == kGetDescriptor && value >> 8 == 3) {
    data = stringDescriptor(device, static_cast<int>(value & 0xFF));
  } else if (type == kToHost && request == kGetConfiguration) {
    data = {1};
  } else if (type != 0 || request != kSetConfiguration) {
    return device.control(static_cast<std::uint8_t>(type), static_cast<std::uint8_t>(request),
                          static_cast<std::uint16_t>(value), monotonicNow_ns());
  }
  data.resize(std::min<std::size_t>(data.size(), most));
  return static_cast<int>(data.size());
}

NodeReply replyOf(int result) { return {.result = result}; }

std::uint32_t fill(NodeReply& reply, std::span<const std::uint8_t> data) {
  std::ranges::copy(data, reply.data.begin());
  return reply.length = static_cast<std::uint32_t>(data.size());
}

}  // namespace

int UsbfsNode::open() {
  if (!present_) return -ENOENT;
  std::array<int, 2> ends;
  if (pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) != 0) return -errno;
  fcntl(ends[1], F_SETPIPE_SZ, 4096);
  struct stat about {};
  fstat(ends[0], &about);
  descriptions_.push_back({.inode = about.st_ino, .readEnd = ends[0]});
  signal(descriptions_.back(), false);
  return ends[1];
}

/// Lets go of descriptions that nobody has any more.
void UsbfsNode::endClosed() {
  std::erase_if(descriptions_, [](const Description& description) {
    if (description.unplugged) return true;  // all that it can still say was said by its poll
    pollfd readEnd{description.readEnd, 0, 0};
    poll(&readEnd, 1, 0);
    const bool closed = (readEnd.revents & POLLHUP) != 0;
    if (closed) ::close(description.readEnd);
    return closed;
  });
}

std::uint64_t UsbfsNode::work(std::uint64_t now_ns) {
  std::erase_if(descriptions_, [](const Description& d) { return d.unplugged && d.done.empty(); });
  std::uint64_t next_ns = now_ns + kIdle_ns;
  for (Description& description : descriptions_) {
    if (!description.unplugged) complete(description, now_ns, next_ns);
  }
  device_->advance(now_ns);
  noteMotors(now_ns);
  return next_ns;
}

void UsbfsNode::complete(Description& description, std::uint64_t now_ns, std::uint64_t& next_ns) {
  while (!description.waiting.empty()) {  // an endpoint's transfers complete in their order
    const Urb urb = description.waiting.front();
    const auto ready_ns = device_->inReadyAt(urb.posted_ns);
    if (!ready_ns || *ready_ns > now_ns) {
      next_ns = ready_ns ? std::min(next_ns, *ready_ns) : next_ns;
      return;
    }
    if (now_ns - *ready_ns > kHeldUp_ns) ++heldUp_;
    if (now_ns - *ready_ns > kLate_ns) ++late_;
    description.waiting.pop_front();
    std::array<std::uint8_t, kMaxNodeData> bytes;
    const int result = device_->in(std::span(bytes).first(std::min<std::size_t>(urb.length, bytes.size())), now_ns);
    finish(description, urb.id, result, std::span(bytes).first(static_cast<std::size_t>(std::max(result, 0))));
  }
}

void UsbfsNode::finish(Description& description, std::uint64_t urb, int result, std::span<const std::uint8_t> data) {
  NodeReply done{.result = std::max(result, 0), .urb = urb, .status = std::min(result, 0)};
  fill(done, data);
  description.done.push_back(done);
  signal(description, true);
}

void UsbfsNode::signal(Description& description, bool ready) {
  if (ready == description.signalled || description.unplugged) return;
  description.signalled = ready;
  char byte = 0;
  if (ready) {
    if (::read(description.readEnd, &byte, 1) != 1) std::abort();
    return;
  }
  const std::string again = "/proc/self/fd/" + std::to_string(description.readEnd);
  const int writeEnd = ::open(again.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (::write(writeEnd, &byte, 1) != 1) std::abort();
  ::close(writeEnd);
}

void UsbfsNode::unplug() {
  present_ = false;
  for (Description& description : descriptions_) {
    if (description.unplugged) continue;
    for (const Urb& urb : description.waiting) finish(description, urb.id, -ENODEV);
    description.waiting.clear();
    description.unplugged = true;
    ::close(description.readEnd);
  }
}

int UsbfsNode::claim(Description& description) {
  endClosed();
  const auto other = [&](const Description& d) { return d.claimed && &d != &description; };
  if (std::ranges::any_of(descriptions_, other)) return -EBUSY;
  description.claimed = true;
  return 0;
}

int UsbfsNode::out(std::span<const std::uint8_t> bytes) {
  const std::uint64_t now_ns = monotonicNow_ns();
  noteMotors(now_ns);  // as it was up to now
  const int result = device_->out(bytes, now_ns);
  noteMotors(now_ns);
  return result;
}

int UsbfsNode::submit(Description& description, const NodeRequest& request) {
  if (request.type == USBDEVFS_URB_TYPE_CONTROL) {
    std::vector<std::uint8_t> answer;
    const int result = control(*device_, request.setup, answer);
    finish(description, request.urb, result, answer);
  } else if ((request.endpoint & 0x80) == 0) {
    finish(description, request.urb, out(std::span(request.data).first(request.length)));
  } else {
    description.waiting.push_back({request.urb, request.length, monotonicNow_ns()});
  }
  return 0;
}

void UsbfsNode::noteMotors(std::uint64_t now_ns) {
  const std::uint64_t until_ns = std::min(now_ns, awaits_ns_);
  if (until_ns > awaited_ns_) {
    impulse_Ns_ += glm::length(device_->motorForce_N()) * static_cast<double>(until_ns - awaited_ns_) * 1e-9;
    awaited_ns_ = until_ns;
  }
  if (device_->motorsOn()) {
    zeroSince_ns_ = 0;
  } else if (zeroSince_ns_ == 0) {
    zeroSince_ns_ = now_ns;
  }
}

NodeReply UsbfsNode::reap(Description& description) {
  if (description.done.empty()) {
    signal(description, false);
    return replyOf(description.unplugged ? -ENODEV : -EAGAIN);
  }
  NodeReply first = description.done.front();
  description.done.pop_front();
  first.isLast = description.done.empty() && !description.unplugged;
  if (description.done.empty()) signal(description, false);
  return first;
}

int UsbfsNode::discard(Description& description, std::uint64_t urb) {
  const auto found = std::ranges::find(description.waiting, urb, &Urb::id);
  if (found == description.waiting.end()) return -EINVAL;
  description.waiting.erase(found);
  finish(description, urb, -ENOENT);
  return 0;
}

NodeReply UsbfsNode::ioctl(const NodeRequest& request) {
  const auto found = std::ranges::find(descriptions_, request.node, &Description::inode);
  if (found == descriptions_.end()) return replyOf(-ENODEV);
  Description& description = *found;
  if (description.unplugged && request.request != USBDEVFS_REAPURBNDELAY) return replyOf(-ENODEV);
  NodeReply reply;
  switch (request.request) {
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      return replyOf(claim(description));
    case USBDEVFS_RELEASEINTERFACE:
      description.claimed = false;
      return reply;
    case USBDEVFS_CLEAR_HALT:
      device_->clearHalt();
      return reply;
    case USBDEVFS_CONTROL: {
      std::vector<std::uint8_t> answer;
      reply.result = control(*device_, request.setup, answer);
      fill(reply, answer);
      return reply;
    }
    case USBDEVFS_BULK:  // of an OUT endpoint; interrupt ones too, as in the kernel
      return replyOf(description.claimed ? out(std::span(request.data).first(request.length)) : -EBUSY);
    case USBDEVFS_SUBMITURB:
      return replyOf(submit(description, request));
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(description);
    case USBDEVFS_DISCARDURB:
      return replyOf(discard(description, request.urb));
    default:
      return replyOf(-ENOTTY);
  }
}

std::string UsbfsNode::command(const std::string& line) {
  const std::uint64_t now_ns = monotonicNow_ns();
  if (line == "unplug") {
    unplug();
  } else if (line == "plug") {
    device_->powerCycle();
    present_ = true;
  } else if (line == "await") {
    awaited_ns_ = now_ns;
    awaits_ns_ = now_ns + kAwait_ns;
    impulse_Ns_ = 0;
  } else if (line.starts_with("fault ")) {
    const auto fault = emulatedFault(line.substr(6));
    if (!fault) return "unknown fault";
    device_->setFault(*fault, now_ns);
  } else if (line == "shift frames") {
    device_->shiftFrames(kFrameShift_ns);
  } else if (line != "state") {
    return "unknown command";
  }
  char answer[300];
  std::snprintf(
      answer, sizeof answer,
      R"({"now_ns": %llu, "motors_on": %s, "zero_since_ns": %llu, "impulse_Ns": %.6f, "held_up": %llu, "late": %llu, "replies": %llu})",
      static_cast<unsigned long long>(now_ns), device_->motorsOn() ? "true" : "false",
      static_cast<unsigned long long>(zeroSince_ns_), impulse_Ns_, static_cast<unsigned long long>(heldUp_),
      static_cast<unsigned long long>(late_), static_cast<unsigned long long>(device_->replies()));
  return answer;
}

}  // namespace haptics::test
