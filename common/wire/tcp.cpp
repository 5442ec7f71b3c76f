#include "common/wire/tcp.h"

#include <netinet/tcp.h>

#include <array>
#include <asio/buffer.hpp>
#include <asio/connect.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <utility>

#include "common/wire/event_loop_context.h"

namespace haptics {
namespace {

using asio::ip::tcp;
using std::chrono::milliseconds;

/// Most that one read delivers; bounds what a connection holds beside its frame in hand.
constexpr std::size_t kReadBuffer_bytes = 64U << 10;
/// Unsent bytes that the kernel takes before it calls the socket full. Larger: newest-only messages queue up behind a
/// slow link, out of backlog()'s sight (at 300 bytes a sample, 1 kB is three samples). Smaller: more wake-ups.
constexpr int kUnsentLimit_bytes = 1024;
/// How long close() waits for a peer that does not take what is queued, and how long it then still reads what the peer
/// sends, unheard: closing a socket with unread input resets the connection and can destroy the last message.
constexpr milliseconds kCloseGrace{1000};
/// Closed connections of one listener that may wait for their peers at a time: whoever opens connections to be refused
/// does not use up the descriptors.
constexpr std::size_t kMaxLingering = 64;
/// Between attempts to accept while the system has no file descriptor left.
constexpr milliseconds kAcceptRetry{100};

Endpoint endpointOf(const tcp::endpoint& e) { return {e.address().to_string(), e.port()}; }

/// One socket. Kept alive by its pending operations; the TcpTransport is the handle that the session owns.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  /// `lingering` counts those that are closing, here and elsewhere; null: nobody counts.
  Connection(tcp::socket socket, std::shared_ptr<std::size_t> lingering)
      : socket_(std::move(socket)), graceTimer_(socket_.get_executor()), lingering_(std::move(lingering)) {
    std::error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    socket_.set_option(asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>(kUnsentLimit_bytes),
                       ignored);
    const tcp::endpoint remote = socket_.remote_endpoint(ignored);
    peer_ = ignored ? "peer that has left" : endpointOf(remote).text();
  }

  void start(Transport::Events events) {
    events_ = std::make_shared<Transport::Events>(std::move(events));
    read();
  }

  void send(std::string&& bytes) {
    if (state_ != State::kOpen || bytes.empty()) return;
    if (queued_.empty()) {
      queued_ = std::move(bytes);
    } else {
      queued_ += bytes;
    }
    if (sending_.empty()) writeQueued();
  }

  [[nodiscard]] std::size_t backlog() const noexcept { return sending_.size() - sent_ + queued_.size(); }
  [[nodiscard]] const std::string& peer() const noexcept { return peer_; }
  /// What is lost on the way is no reason for BBR to send less. Where the system does not have it, all stays as it is.
  void preferThroughput() noexcept {
    static constexpr std::string_view kAlgorithm = "bbr";
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_CONGESTION, kAlgorithm.data(), kAlgorithm.size());
  }

  void close(const std::string& why) {
    if (state_ != State::kOpen) return;
    state_ = State::kFlushing;
    why_ = why;
    if (lingering_) countLingering();
    abortAfterGrace();
    if (backlog() == 0) asio::post(socket_.get_executor(), [self = shared_from_this()] { self->finishFlush(); });
  }

  /// The handle is gone: nobody is to be called any more. What close() began goes on.
  void release() {
    events_ = nullptr;
    if (state_ == State::kOpen) abort();
  }

 private:
  void countLingering() {
    counted_ = true;
    if (++*lingering_ <= kMaxLingering) return;
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->abort(); });
  }

  enum class State { kOpen, kFlushing, kLingering, kClosed };

  void abortAfterGrace() {
    graceTimer_.expires_after(kCloseGrace);
    graceTimer_.async_wait([self = shared_from_this()](const std::error_code& error) {
      if (!error) self->abort();
    });
  }

  void read() {
    reading_ = true;
    socket_.async_read_some(
        asio::buffer(input_),
        [self = shared_from_this()](const std::error_code& error, std::size_t size) { self->onRead(error, size); });
  }

  void onRead(const std::error_code& error, std::size_t size) {
    reading_ = false;
    if (state_ == State::kClosed) return;
    if (error) return abort(error == asio::error::eof ? "closed by the peer" : error.message());
    if (const auto events = events_; state_ == State::kOpen && events && events->received) {
      events->received({input_.data(), size});
    }
    if (state_ != State::kClosed) read();
  }

  void writeQueued() {
    sending_ = std::exchange(queued_, {});
    sent_ = 0;
    write();
  }

  void write() {
    socket_.async_write_some(
        asio::buffer(sending_.data() + sent_, sending_.size() - sent_),
        [self = shared_from_this()](const std::error_code& error, std::size_t size) { self->onWritten(error, size); });
  }

  void onWritten(const std::error_code& error, std::size_t size) {
    if (state_ == State::kClosed) return;
    if (error) return abort(error.message());
    sent_ += size;
    if (sent_ < sending_.size()) return write();
    sending_.clear();
    sent_ = 0;
    if (!queued_.empty()) return writeQueued();
    if (state_ == State::kFlushing) return finishFlush();
    if (const auto events = events_; events && events->drained) events->drained();
  }

  /// Everything is out: the session is done with the connection, the socket stays until the peer has left too.
  void finishFlush() {
    if (state_ != State::kFlushing) return;
    state_ = State::kLingering;
    std::error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    if (!reading_) read();
    abortAfterGrace();
    reportClosed();
  }

  /// `why`, unless close() has told another reason.
  void abort(const std::string& why = {}) {
    if (state_ == State::kClosed) return;
    state_ = State::kClosed;
    if (why_.empty()) why_ = why;
    if (counted_) --*lingering_;
    graceTimer_.cancel();
    std::error_code ignored;
    socket_.close(ignored);
    reportClosed();
  }

  void reportClosed() {
    if (const auto events = std::exchange(events_, nullptr); events && events->closed) events->closed(why_);
  }

  tcp::socket socket_;
  asio::steady_timer graceTimer_;
  State state_ = State::kOpen;
  std::shared_ptr<Transport::Events> events_;
  std::array<char, kReadBuffer_bytes> input_;  // not cleared: a connection that says nothing costs no pages
  std::string sending_, queued_;
  std::size_t sent_ = 0;
  bool reading_ = false;
  std::shared_ptr<std::size_t> lingering_;
  bool counted_ = false;
  std::string peer_, why_;
};

class TcpTransport final : public Transport {
 public:
  explicit TcpTransport(tcp::socket socket, std::shared_ptr<std::size_t> lingering = nullptr)
      : connection_(std::make_shared<Connection>(std::move(socket), std::move(lingering))) {}
  ~TcpTransport() override { connection_->release(); }

  void start(Events events) override { connection_->start(std::move(events)); }
  void send(std::string bytes) override { connection_->send(std::move(bytes)); }
  [[nodiscard]] std::size_t backlog() const noexcept override { return connection_->backlog(); }
  void close(const std::string& why) override { connection_->close(why); }
  [[nodiscard]] std::string peer() const override { return connection_->peer(); }
  void preferThroughput() override { connection_->preferThroughput(); }

 private:
  std::shared_ptr<Connection> connection_;
};

std::string listenAdvice(const std::error_code& error) {
  if (error == asio::error::address_in_use) {
    return "the port is in use by another program; stop that or choose another port";
  }
  if (error.value() == EADDRNOTAVAIL) return "is not an address of this machine";
  if (error == asio::error::access_denied) return "ports below 1024 need privilege; choose a higher one";
  return "cannot listen there: " + error.message();
}

}  // namespace

// ---- Listener ----

struct TcpListener::State : std::enable_shared_from_this<TcpListener::State> {
  State(asio::io_context& io, Accepted accepted_) : acceptor(io), retryTimer(io), accepted(std::move(accepted_)) {}

  void accept() {
    acceptor.async_accept([self = shared_from_this()](const std::error_code& error, tcp::socket socket) {
      if (!self->acceptor.is_open()) return;
      if (!error) {
        self->accept();  // first, for what follows may throw
        self->accepted(std::make_unique<TcpTransport>(std::move(socket), self->lingering));
      } else {
        self->acceptLater();
      }
    });
  }

  void acceptLater() {
    retryTimer.expires_after(kAcceptRetry);
    retryTimer.async_wait([self = shared_from_this()](const std::error_code& error) {
      if (!error && self->acceptor.is_open()) self->accept();
    });
  }

  tcp::acceptor acceptor;
  asio::steady_timer retryTimer;
  Accepted accepted;
  std::shared_ptr<std::size_t> lingering = std::make_shared<std::size_t>(0);
};

TcpListener::TcpListener(std::shared_ptr<State> state) : state_(std::move(state)) {}

TcpListener::~TcpListener() {
  std::error_code ignored;
  state_->acceptor.close(ignored);
  state_->retryTimer.cancel();
}

Result<std::unique_ptr<TcpListener>> TcpListener::open(EventLoop& loop, const Endpoint& address, Accepted accepted) {
  asio::io_context& io = loop.context().io;
  auto state = std::make_shared<State>(io, std::move(accepted));
  std::error_code error;
  tcp::resolver resolver(io);
  const auto found = resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
  if (error || found.empty()) {
    return refused(address.text(), "the host is not known: " + error.message() + "; give a numeric address");
  }
  const tcp::endpoint at = found.begin()->endpoint();
  state->acceptor.open(at.protocol(), error);
  if (!error) state->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) state->acceptor.bind(at, error);
  if (!error) state->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) return refused(address.text(), listenAdvice(error));
  state->accept();
  return std::unique_ptr<TcpListener>(new TcpListener(std::move(state)));
}

Endpoint TcpListener::local() const {
  std::error_code ignored;
  return endpointOf(state_->acceptor.local_endpoint(ignored));
}

// ---- Connector ----

struct TcpConnector::State : std::enable_shared_from_this<TcpConnector::State> {
  State(asio::io_context& io, Endpoint server_, Done done_)
      : resolver(io), socket(io), server(std::move(server_)), done(std::move(done_)) {}

  void begin() {
    std::error_code notNumeric;
    const asio::ip::address address = asio::ip::make_address(server.host, notNumeric);
    if (!notNumeric) {
      return connect(tcp::resolver::results_type::create(tcp::endpoint(address, server.port), server.host, ""));
    }
    resolver.async_resolve(
        server.host, std::to_string(server.port),
        [self = shared_from_this()](const std::error_code& error, const tcp::resolver::results_type& found) {
          if (self->abandoned) return;
          if (error) return self->fail("the host is not known: " + error.message());
          self->connect(found);
        });
  }

  void connect(const tcp::resolver::results_type& found) {
    asio::async_connect(socket, found, [self = shared_from_this()](const std::error_code& error, const tcp::endpoint&) {
      if (self->abandoned) return;
      if (error) return self->fail("cannot connect: " + error.message() + "; is haptic_server running there?");
      self->done(std::make_unique<TcpTransport>(std::move(self->socket)));
    });
  }

  void fail(std::string reason) { done(refused(server.text(), std::move(reason))); }

  tcp::resolver resolver;
  tcp::socket socket;
  Endpoint server;
  Done done;
  bool abandoned = false;
};

TcpConnector::TcpConnector(EventLoop& loop, const Endpoint& server, Done done)
    : state_(std::make_shared<State>(loop.context().io, server, std::move(done))) {
  state_->begin();
}

TcpConnector::~TcpConnector() {
  state_->abandoned = true;
  state_->resolver.cancel();
  std::error_code ignored;
  state_->socket.close(ignored);
}

}  // namespace haptics
