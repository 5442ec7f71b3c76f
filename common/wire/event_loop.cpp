#include "common/wire/event_loop.h"

#include <asio/post.hpp>
#include <asio/steady_timer.hpp>

#include "common/wire/event_loop_context.h"

namespace haptics {

struct Timer::State : std::enable_shared_from_this<Timer::State> {
  State(asio::io_context& io, std::chrono::nanoseconds period_, std::function<void()> task_)
      : timer(io), period(period_), task(std::move(task_)) {}

  void wait() {
    timer.async_wait([self = shared_from_this()](const std::error_code& error) {
      if (error || self->stopped) return;
      self->setNext();  // before the task: one that throws does not end the timer
      self->task();
    });
  }

  void setNext() {
    if (period.count() == 0) return;
    const auto missed = (std::chrono::steady_clock::now() - timer.expiry()) / period;
    timer.expires_at(timer.expiry() + (missed + 1) * period);
    wait();
  }

  asio::steady_timer timer;
  std::chrono::nanoseconds period;  // 0: once
  std::function<void()> task;
  bool stopped = false;
};

Timer::Timer() = default;
Timer::Timer(std::shared_ptr<State> state) : state_(std::move(state)) {}
Timer::Timer(Timer&&) noexcept = default;
Timer::~Timer() {
  if (!state_) return;
  state_->stopped = true;
  state_->timer.cancel();
}
Timer& Timer::operator=(Timer&& other) noexcept {
  Timer old(std::move(*this));
  state_ = std::move(other.state_);
  return *this;
}

EventLoop::EventLoop() : context_(std::make_unique<Context>()) {}
EventLoop::~EventLoop() = default;

void EventLoop::run() {
  {
    const auto work = asio::make_work_guard(context_->io);
    context_->io.run();
  }
  context_->io.restart();
}

void EventLoop::stop() { context_->io.stop(); }

void EventLoop::post(std::function<void()> task) { asio::post(context_->io, std::move(task)); }

Timer EventLoop::after(std::chrono::nanoseconds delay, std::function<void()> task) {
  auto state = std::make_shared<Timer::State>(context_->io, std::chrono::nanoseconds(0), std::move(task));
  state->timer.expires_after(delay);
  state->wait();
  return Timer(std::move(state));
}

Timer EventLoop::every(std::chrono::nanoseconds period, std::function<void()> task) {
  auto state = std::make_shared<Timer::State>(context_->io, period, std::move(task));
  state->timer.expires_after(period);
  state->wait();
  return Timer(std::move(state));
}

}  // namespace haptics
