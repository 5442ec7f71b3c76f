#include "haptic_server/device/usb/libusb_port.h"

#include <libusb-1.0/libusb.h>
#include <poll.h>

#include <algorithm>
#include <ctime>
#include <new>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

constexpr unsigned kControlTimeOut_ms = 100;
constexpr unsigned kSendTimeOut_ms = 50;  // a command that the device does not take for so long is of no use any more

[[nodiscard]] UsbOutcome outcomeOf(int error) noexcept {
  switch (error) {
    case LIBUSB_ERROR_NO_DEVICE:
      return UsbOutcome::kGone;
    case LIBUSB_ERROR_PIPE:
      return UsbOutcome::kStalled;
    case LIBUSB_ERROR_TIMEOUT:
      return UsbOutcome::kTimeOut;
    default:
      return error >= 0 ? UsbOutcome::kDone : UsbOutcome::kFailed;
  }
}

}  // namespace

LibusbPort::LibusbPort(FileHandle node, UsbContext context, libusb_device_handle* handle, const UsbModel& model)
    : node_(std::move(node)), context_(std::move(context)), handle_(handle), model_(model) {
  for (std::size_t i = 0; i < transfers_.size(); ++i) {
    Transfer& transfer = transfers_[i];
    transfer.port = this;
    transfer.in = i < kQueuedIn;
    transfer.transfer = libusb_alloc_transfer(0);
    if (transfer.transfer == nullptr) throw std::bad_alloc();
  }
  if (const libusb_pollfd** descriptors = libusb_get_pollfds(context_.get())) {
    for (const libusb_pollfd** fd = descriptors; *fd != nullptr; ++fd) polled_.push_back({(*fd)->fd, (*fd)->events, 0});
    libusb_free_pollfds(descriptors);
  }
  keepReceiving();
}

LibusbPort::~LibusbPort() {
  const auto anyUnderWay = [&] { return std::ranges::any_of(transfers_, &Transfer::underWay); };
  for (Transfer& transfer : transfers_) {
    if (transfer.underWay) libusb_cancel_transfer(transfer.transfer);
  }
  gone_ = true;  // nothing is queued again
  for (int i = 0; i < 100 && anyUnderWay(); ++i) handleEvents(monotonicNow_ns() + 10'000'000);
  for (Transfer& transfer : transfers_) {
    // One that libusb has not given back must not be freed under it.
    if (!transfer.underWay) libusb_free_transfer(transfer.transfer);
  }
  libusb_release_interface(handle_, 0);
  libusb_close(handle_);
}

UsbOutcome LibusbPort::control(const UsbRequest& request) {
  return outcomeOf(libusb_control_transfer(handle_, request.type, request.request, request.value, request.index,
                                           nullptr, 0, kControlTimeOut_ms));
}

UsbOutcome LibusbPort::send(std::span<const std::uint8_t> bytes) {
  if (gone_) return UsbOutcome::kGone;
  const auto free = std::ranges::find_if(transfers_, [](const Transfer& t) { return !t.in && !t.underWay; });
  if (free == transfers_.end()) return UsbOutcome::kBusy;
  const std::size_t length = std::min(bytes.size(), kPacket_bytes);
  std::copy_n(bytes.begin(), length, free->bytes.begin());
  if (submit(*free, length)) return UsbOutcome::kDone;
  return gone_ ? UsbOutcome::kGone : UsbOutcome::kFailed;
}

UsbArrival LibusbPort::next(std::uint64_t deadline_ns) {
  shown_ = nullptr;
  for (;;) {
    keepReceiving();
    if (!arrived_.empty()) {
      shown_ = arrived_.front();
      arrived_.pop_front();
      return {UsbArrival::Kind::kBytes,
              {shown_->bytes.data(), static_cast<std::size_t>(shown_->transfer->actual_length)}};
    }
    if (!happened_.empty()) {
      const UsbArrival::Kind kind = happened_.front();
      happened_.pop_front();
      return {kind, {}};
    }
    if (gone_) return {UsbArrival::Kind::kGone, {}};
    const std::uint64_t now_ns = monotonicNow_ns();
    handleEvents(deadline_ns);
    if (now_ns >= deadline_ns && arrived_.empty() && happened_.empty() && !gone_) return {};
  }
}

UsbOutcome LibusbPort::clearStall() {
  const UsbOutcome outcome =
      std::max(outcomeOf(libusb_clear_halt(handle_, model_.in)), outcomeOf(libusb_clear_halt(handle_, model_.out)));
  halted_ = false;
  std::erase(happened_, UsbArrival::Kind::kStalled);  // the other transfers that were queued when it happened
  return outcome;
}

bool LibusbPort::submit(Transfer& transfer, std::size_t length) {
  const std::uint8_t endpoint = transfer.in ? model_.in : model_.out;
  const unsigned timeOut_ms = transfer.in ? 0 : kSendTimeOut_ms;
  libusb_fill_bulk_transfer(transfer.transfer, handle_, endpoint, transfer.bytes.data(), static_cast<int>(length),
                            &LibusbPort::completed, &transfer, timeOut_ms);
  if (model_.interrupt) transfer.transfer->type = LIBUSB_TRANSFER_TYPE_INTERRUPT;
  const int error = libusb_submit_transfer(transfer.transfer);
  transfer.underWay = error == LIBUSB_SUCCESS;
  gone_ = gone_ || error == LIBUSB_ERROR_NO_DEVICE;
  return transfer.underWay;
}

void LibusbPort::keepReceiving() {
  if (halted_) return;
  for (Transfer& transfer : transfers_) {
    if (gone_) return;
    const bool waiting = std::ranges::find(arrived_, &transfer) != arrived_.end();
    if (transfer.in && !transfer.underWay && &transfer != shown_ && !waiting) submit(transfer, kPacket_bytes);
  }
}

void LibusbPort::completed(libusb_transfer* transfer) noexcept {
  auto& ours = *static_cast<Transfer*>(transfer->user_data);
  LibusbPort& port = *ours.port;
  ours.underWay = false;
  switch (transfer->status) {
    case LIBUSB_TRANSFER_COMPLETED:
      if (ours.in) port.arrived_.push_back(&ours);
      break;
    case LIBUSB_TRANSFER_NO_DEVICE:
      port.gone_ = true;
      break;
    case LIBUSB_TRANSFER_STALL:
      port.halted_ = true;
      port.happened_.push_back(UsbArrival::Kind::kStalled);
      break;
    case LIBUSB_TRANSFER_CANCELLED:
    case LIBUSB_TRANSFER_TIMED_OUT:
      break;
    default:
      port.happened_.push_back(UsbArrival::Kind::kFailed);
  }
}

void LibusbPort::handleEvents(std::uint64_t deadline_ns) {
  const std::uint64_t now_ns = monotonicNow_ns();
  const std::uint64_t left_ns = deadline_ns > now_ns ? deadline_ns - now_ns : 0;
  const timespec left{static_cast<time_t>(left_ns / 1'000'000'000), static_cast<long>(left_ns % 1'000'000'000)};
  ppoll(polled_.data(), polled_.size(), &left, nullptr);
  timeval none{0, 0};
  libusb_handle_events_timeout_completed(context_.get(), &none, nullptr);
}

}  // namespace haptics
