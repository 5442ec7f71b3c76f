#include "common/wire/loop_link.h"

#include <array>
#include <mutex>
#include <string>

namespace haptics {
namespace {

/// State that both ends share. Each end's state is its own thread's; the mutex guards the loops, which the other thread posts to.
class Link : public std::enable_shared_from_this<Link> {
 public:
  Link(EventLoop& first, EventLoop& second) {
    ends_[0].loop = &first;
    ends_[1].loop = &second;
  }

  void start(std::size_t at, Transport::Events events) {
    ends_[at].events = std::make_shared<Transport::Events>(std::move(events));
    post(at, [at](Link& link) { link.deliver(at, std::exchange(link.ends_[at].early, {})); });
  }

  void send(std::size_t at, std::string bytes) {
    End& end = ends_[at];
    if (end.closing || bytes.empty()) return;
    end.backlog += bytes.size();
    post(1 - at, [at, bytes = std::move(bytes)](Link& link) mutable {
      const std::size_t size = bytes.size();
      link.deliver(1 - at, std::move(bytes));
      link.post(at, [at, size](Link& back) { back.taken(at, size); });
    });
  }

  void close(std::size_t at, const std::string& why) {
    if (std::exchange(ends_[at].closing, true)) return;
    post(1 - at, [at](Link& link) { link.finish(1 - at, "closed by the peer"); });
    post(at, [at, why](Link& link) { link.finish(at, why); });
  }

  void destroy(std::size_t at) {
    ends_[at].events = nullptr;
    ends_[at].closing = true;
    {
      const std::lock_guard lock(mutex_);
      ends_[at].loop = nullptr;
    }
    post(1 - at, [at](Link& link) { link.finish(1 - at, "closed by the peer"); });
  }

  [[nodiscard]] std::size_t backlog(std::size_t at) const noexcept { return ends_[at].backlog; }

 private:
  struct End {
    EventLoop* loop = nullptr;  // null: the end is gone
    std::shared_ptr<Transport::Events> events;
    std::string early;  // before start
    std::size_t backlog = 0;
    bool closing = false;  // sends nothing new, receives nothing
  };

  template <class Task>
  void post(std::size_t to, Task task) {
    const std::lock_guard lock(mutex_);
    if (EventLoop* loop = ends_[to].loop) {
      loop->post([self = shared_from_this(), task = std::move(task)]() mutable { task(*self); });
    }
  }

  void deliver(std::size_t at, std::string bytes) {
    End& end = ends_[at];
    if (end.closing || bytes.empty()) return;
    if (!end.events) {
      end.early += bytes;
    } else if (const auto events = end.events; events->received) {
      events->received(bytes);
    }
  }

  void taken(std::size_t at, std::size_t size) {
    End& end = ends_[at];
    end.backlog -= size;
    if (const auto events = end.events; events && end.backlog == 0 && !end.closing && events->drained)
      events->drained();
  }

  void finish(std::size_t at, const std::string& why) {
    ends_[at].closing = true;
    if (const auto events = std::exchange(ends_[at].events, nullptr); events && events->closed) events->closed(why);
  }

  std::mutex mutex_;
  std::array<End, 2> ends_;
};

class LinkEnd final : public Transport {
 public:
  LinkEnd(std::shared_ptr<Link> link, std::size_t at) : link_(std::move(link)), at_(at) {}
  ~LinkEnd() override { link_->destroy(at_); }

  void start(Events events) override { link_->start(at_, std::move(events)); }
  void send(std::string bytes) override { link_->send(at_, std::move(bytes)); }
  [[nodiscard]] std::size_t backlog() const noexcept override { return link_->backlog(at_); }
  void close(const std::string& why) override { link_->close(at_, why); }
  [[nodiscard]] std::string peer() const override { return "this process"; }

 private:
  std::shared_ptr<Link> link_;
  std::size_t at_;
};

}  // namespace

std::pair<std::unique_ptr<Transport>, std::unique_ptr<Transport>> linkLoops(EventLoop& first, EventLoop& second) {
  const auto link = std::make_shared<Link>(first, second);
  return {std::make_unique<LinkEnd>(link, 0), std::make_unique<LinkEnd>(link, 1)};
}

}  // namespace haptics
