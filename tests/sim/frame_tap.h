#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "common/wire/framing.h"
#include "common/wire/transport.h"
#include "graphics_client/mirror/mirror.h"
#include "tests/sim/mutant.h"
#include "tests/sim/random.h"

namespace haptics::sim {

/// Sits between a client and its end of a line and changes what passes, frame by frame: into what a broken protocol
/// would have carried, or what bad memory makes of it.
class FrameTap final : public Transport {
 public:
  /// The mirror is the client's; all outlive the tap.
  FrameTap(std::unique_ptr<Transport> line, Mutant mutant, const Mirror& mirror, Random& random);
  ~FrameTap() override;

  /// A value in the next commit flips on its way into the client's memory; says so when it has.
  void flipNext(std::function<void()> flipped) { flipped_ = std::move(flipped); }

  void start(Events events) override;
  void send(std::string bytes) override;
  [[nodiscard]] std::size_t backlog() const noexcept override { return line_->backlog(); }
  void close(const std::string& why) override { line_->close(why); }
  [[nodiscard]] std::string peer() const override { return line_->peer(); }
  void preferThroughput() override { line_->preferThroughput(); }

 private:
  std::unique_ptr<Transport> line_;
  const Mutant mutant_;
  const Mirror& mirror_;
  Random& random_;
  std::shared_ptr<const Events> events_;  // kept while one runs, which may destroy the tap
  FrameDecoder fromServer_, fromClient_;
  std::optional<v1::Envelope> held_;  // a message that waits to be overtaken
  std::function<void()> flipped_;
  bool skipsDelta_ = false;  // of a resumed connection, the first
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);

  void received(std::span<const char> bytes);
  void changeFromClient(v1::Envelope& envelope);
  void changeFromServer(v1::Envelope& envelope);
  void flip(v1::Envelope& envelope);
  void believe(v1::Envelope& envelope);
  void makeIncrements(v1::Commit& commit);
  [[nodiscard]] bool drops(const v1::Envelope& envelope);
  /// Whether the message waits, or went out behind the one after it.
  [[nodiscard]] bool overtaken(const v1::Envelope& envelope, v1::Envelope::BodyCase kind);
};

}  // namespace haptics::sim
