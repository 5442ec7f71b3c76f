#include "common/wire/tls.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <array>
#include <new>
#include <utility>

#include "common/credentials/openssl_handles.h"

namespace haptics {
namespace {

using openssl::Bio, openssl::Certificate, openssl::Key;
using Context = Handle<SSL_CTX, &SSL_CTX_free>;
using Session = Handle<SSL, &SSL_free>;

constexpr std::size_t kMaxInARecord_bytes = 16U << 10;
/// First byte of TLS records: a handshake is what a client begins with; a server may also answer with an alert.
constexpr char kHandshakeRecord = 22, kAlertRecord = 21;

Bio memory(const std::string& text = {}) {
  Bio bio(BIO_new(BIO_s_mem()));
  if (!bio) throw std::bad_alloc();
  if (!text.empty()) BIO_write(bio.get(), text.data(), static_cast<int>(text.size()));
  return bio;
}

Certificate certificateFrom(const std::string& pem) {
  return Certificate(PEM_read_bio_X509(memory(pem).get(), nullptr, nullptr, nullptr));
}

Context newContext(const SSL_METHOD* method) {
  Context context(SSL_CTX_new(method));
  if (!context) throw std::bad_alloc();
  SSL_CTX_set_min_proto_version(context.get(), TLS1_3_VERSION);
  SSL_CTX_set_max_proto_version(context.get(), TLS1_3_VERSION);
  SSL_CTX_set_num_tickets(context.get(), 0);  // a session is resumed by the protocol above, never by TLS
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context.get(), SSL_MODE_RELEASE_BUFFERS);  // an idle connection keeps no buffers
  return context;
}

}  // namespace

struct TlsContext::State {
  Context context;
  bool isServer;
  std::string plainAnswer;
};

namespace {

/// One secured connection. Kept alive while it calls back; the TlsTransport is the handle that the session owns.
class Line : public std::enable_shared_from_this<Line> {
 public:
  Line(std::unique_ptr<Transport> below, std::shared_ptr<const TlsContext::State> context)
      : below_(std::move(below)), context_(std::move(context)), ssl_(SSL_new(context_->context.get())) {
    if (!ssl_) throw std::bad_alloc();
    in_ = memory().release();
    out_ = memory().release();
    SSL_set_bio(ssl_.get(), in_, out_);
    context_->isServer ? SSL_set_accept_state(ssl_.get()) : SSL_set_connect_state(ssl_.get());
  }

  void start(Transport::Events events) {
    events_ = std::make_shared<Transport::Events>(std::move(events));
    const auto self = [weak = weak_from_this()](auto then) {
      if (const auto line = weak.lock()) then(*line);
    };
    below_->start({.received = [self](std::span<const char> bytes) { self([=](Line& l) { l.onReceived(bytes); }); },
                   .drained = [self] { self([](Line& l) { l.onDrained(); }); },
                   .closed = [self](const std::string& why) { self([&](Line& l) { l.onClosed(why); }); }});
    if (!context_->isServer) shakeHands();
  }

  void send(std::string&& bytes) {
    if (phase_ == Phase::kOver || bytes.empty()) return;
    if (phase_ == Phase::kHandshake) {
      waiting_ += bytes;
      return;
    }
    encrypt(bytes);
  }

  void close(const std::string& why) {
    if (phase_ == Phase::kOver) return;
    if (phase_ == Phase::kOpen) SSL_shutdown(ssl_.get());  // the peer can tell this end from a cut
    phase_ = Phase::kOver;
    flush();
    below_->close(why);
  }

  [[nodiscard]] std::size_t backlog() const noexcept { return below_->backlog() + waiting_.size(); }
  [[nodiscard]] std::string peer() const { return below_->peer(); }
  void preferThroughput() { below_->preferThroughput(); }

  /// The handle is gone: nobody is to be called any more. What close() began goes on below.
  void release() {
    events_ = nullptr;
    below_ = nullptr;
  }

 private:
  enum class Phase { kHandshake, kOpen, kOver };

  void onReceived(std::span<const char> bytes) {
    if (phase_ == Phase::kOver || bytes.empty()) return;
    if (!std::exchange(heard_, true) && !beginsARecord(bytes)) return peerIsPlain();
    BIO_write(in_, bytes.data(), static_cast<int>(bytes.size()));
    if (phase_ == Phase::kHandshake) shakeHands();
    if (phase_ == Phase::kOpen) decrypt();
  }

  /// Type and version (RFC 8446, 5.1), as far as they are there. A plain frame whose length looks like a type has 0 for the
  /// minor version, unless it is of 64 KiB or more.
  [[nodiscard]] bool beginsARecord(std::span<const char> bytes) const noexcept {
    constexpr char kMajorVersion = 3;
    const bool type = bytes[0] == kHandshakeRecord || (!context_->isServer && bytes[0] == kAlertRecord);
    return type && (bytes.size() < 3 || (bytes[1] == kMajorVersion && bytes[2] != 0));
  }

  void onDrained() {
    if (const auto events = events_; phase_ == Phase::kOpen && events && events->drained) events->drained();
  }

  void onClosed(const std::string& why) {
    const bool unfinished = phase_ == Phase::kHandshake;
    phase_ = Phase::kOver;
    const auto events = std::exchange(events_, nullptr);
    if (events && events->closed) events->closed(unfinished ? "cut short during the TLS handshake: " + why : why);
  }

  void peerIsPlain() {
    phase_ = Phase::kOver;
    if (!context_->isServer) {
      return below_->close(std::string(kTlsFailure) +
                           "the server does not speak TLS; start it with --credentials, or leave them out here");
    }
    below_->send(context_->plainAnswer);
    below_->close(std::string(kTlsFailure) + "the client does not speak TLS");
  }

  void shakeHands() {
    ERR_clear_error();
    const int outcome = SSL_do_handshake(ssl_.get());
    if (outcome != 1 && SSL_get_error(ssl_.get(), outcome) == SSL_ERROR_WANT_READ) return flush();
    if (outcome != 1) return fail(handshakeFailure());
    phase_ = Phase::kOpen;
    flush();
    if (!waiting_.empty()) encrypt(std::exchange(waiting_, {}));
  }

  void encrypt(const std::string& bytes) {
    ERR_clear_error();
    std::size_t taken = 0;  // all of it: the queue below takes everything
    if (SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &taken) != 1) return fail(reasonOf(ERR_peek_last_error()));
    flush();
  }

  void decrypt() {
    std::array<char, kMaxInARecord_bytes> plain;
    while (phase_ == Phase::kOpen) {
      ERR_clear_error();
      std::size_t size = 0;
      if (SSL_read_ex(ssl_.get(), plain.data(), plain.size(), &size) == 1) {
        if (const auto events = events_; events && events->received) events->received({plain.data(), size});
        if (!below_) return;
        continue;
      }
      const int error = SSL_get_error(ssl_.get(), 0);
      if (error == SSL_ERROR_WANT_READ) return flush();
      if (error == SSL_ERROR_ZERO_RETURN) {  // OpenSSL reads nothing after that: what comes would pile up
        phase_ = Phase::kOver;
        flush();
        return below_->close("closed by the peer");
      }
      return fail(reasonOf(ERR_peek_last_error()));
    }
  }

  /// Hands what OpenSSL has produced to the line: records, handshake messages, alerts.
  void flush() {
    char* data = nullptr;
    const long size = BIO_get_mem_data(out_, &data);
    if (size <= 0) return;
    below_->send(std::string(data, static_cast<std::size_t>(size)));
    BIO_reset(out_);
  }

  void fail(const std::string& why) {
    phase_ = Phase::kOver;
    flush();  // the alert
    below_->close(std::string(kTlsFailure) + why);
  }

  [[nodiscard]] std::string handshakeFailure() const {
    if (!context_->isServer) {
      const long verdict = SSL_get_verify_result(ssl_.get());
      if (verdict == X509_V_ERR_CERT_HAS_EXPIRED || verdict == X509_V_ERR_CERT_NOT_YET_VALID) {
        return std::string("the server's ") + X509_verify_cert_error_string(verdict) +
               "; compare the clocks, or make new credentials";
      }
      if (verdict != X509_V_OK) {
        return "this server is not the one that the credentials are of: it has another certificate";
      }
    }
    return reasonOf(ERR_peek_last_error());
  }

  [[nodiscard]] std::string reasonOf(unsigned long error) const {
    const std::string peer = context_->isServer ? "the client" : "the server";
    switch (ERR_GET_REASON(error)) {
      case SSL_R_UNSUPPORTED_PROTOCOL:
      case SSL_R_TLSV1_ALERT_PROTOCOL_VERSION:
        return peer + " does not speak TLS 1.3";
      case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
      case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
      case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
        return peer + " takes this for another server: its credentials are not of this one";
      default:
        const char* reason = ERR_reason_error_string(error);
        return reason != nullptr ? peer + " failed: " + reason : peer + " does not keep to TLS";
    }
  }

  std::unique_ptr<Transport> below_;
  std::shared_ptr<const TlsContext::State> context_;
  Session ssl_;
  BIO* in_ = nullptr;   // of ssl_: what the peer sent
  BIO* out_ = nullptr;  // of ssl_: what is to be sent
  Phase phase_ = Phase::kHandshake;
  bool heard_ = false;  // anything from the peer
  std::string waiting_;
  std::shared_ptr<Transport::Events> events_;
};

class TlsTransport final : public Transport {
 public:
  explicit TlsTransport(std::shared_ptr<Line> line) : line_(std::move(line)) {}
  ~TlsTransport() override { line_->release(); }

  void start(Events events) override { line_->start(std::move(events)); }
  void send(std::string bytes) override { line_->send(std::move(bytes)); }
  [[nodiscard]] std::size_t backlog() const noexcept override { return line_->backlog(); }
  void close(const std::string& why) override { line_->close(why); }
  [[nodiscard]] std::string peer() const override { return line_->peer(); }
  void preferThroughput() override { line_->preferThroughput(); }

 private:
  std::shared_ptr<Line> line_;
};

}  // namespace

TlsContext::TlsContext(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Result<TlsContext> TlsContext::server(const std::string& certificatePem, const std::string& privateKeyPem,
                                      std::string plainAnswer) {
  Context context = newContext(TLS_server_method());
  const Certificate certificate = certificateFrom(certificatePem);
  const Key key(PEM_read_bio_PrivateKey(memory(privateKeyPem).get(), nullptr, nullptr, nullptr));
  if (!certificate || !key) return refused(certificate ? "key" : "certificate", "is not in PEM form");
  if (SSL_CTX_use_certificate(context.get(), certificate.get()) != 1 ||
      SSL_CTX_use_PrivateKey(context.get(), key.get()) != 1) {
    return refused("key", "is not the certificate's");
  }
  return TlsContext(std::make_shared<const State>(State{std::move(context), true, std::move(plainAnswer)}));
}

Result<TlsContext> TlsContext::client(const std::string& serverCertificatePem) {
  Context context = newContext(TLS_client_method());
  const Certificate certificate = certificateFrom(serverCertificatePem);
  if (!certificate) return refused("certificate", "is not in PEM form");
  X509_STORE_add_cert(SSL_CTX_get_cert_store(context.get()), certificate.get());
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  return TlsContext(std::make_shared<const State>(State{std::move(context), false, {}}));
}

std::unique_ptr<Transport> TlsContext::secure(std::unique_ptr<Transport> line) const {
  return std::make_unique<TlsTransport>(std::make_shared<Line>(std::move(line), state_));
}

}  // namespace haptics
