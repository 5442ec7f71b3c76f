#include <cstdio>
#include <future>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/json/message_json.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/mirror/edit_reply.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/progress_bar.h"
#include "graphics_client/script/upload.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

/// What is heard of one edit. Shared with the link's thread.
struct Answers {
  std::mutex mutex;
  std::optional<v1::EditProgress> progress;  // the newest; guarded by the mutex, as is the next
  int reports = 0;                           // of progress
  std::promise<v1::EditReply> reply;
  std::promise<std::optional<v1::EditLive>> live;  // nothing: the server lost its state
};

std::string hashText(const std::string& hash) {
  const auto whole = ContentHash::fromBytes(hash);
  return whole ? whole->hex() : "";
}

void print(const v1::Accepted& accepted, const v1::EditLive& live, bool json) {
  if (json) {
    auto object = toJson(accepted);
    object.set("live_since_tick", live.tick());
    std::cout << object.line() << std::endl;
    return;
  }
  std::cout << "revision " << accepted.revision() << ", live since tick " << live.tick() << "\nroot "
            << hashText(accepted.root()) << '\n';
  for (const auto& object : accepted.object()) {
    std::cout << "object " << object.id() << " \"" << printable(object.name()) << "\", mesh "
              << hashText(object.mesh()).substr(0, 12) << ", " << object.stiffness_n_per_m() << " N/m, "
              << object.damping_ns_per_m() << " N s/m\n";
  }
  for (const auto& line : accepted.report()) std::cout << printable(line) << '\n';
}

/// Shows on a terminal how far an edit is that takes long.
class ProgressLine {
 public:
  explicit ProgressLine(std::shared_ptr<Answers> answers) : answers_(std::move(answers)) {}
  ~ProgressLine() {
    if (shown_) endProgress();
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Whether more is known than before.
  [[nodiscard]] bool look() {
    const std::lock_guard lock(answers_->mutex);
    if (!answers_->progress) return false;
    const bool builds = answers_->progress->stage() == v1::EditProgress::STAGE_BUILDING;
    const double seconds = 1e-9 * static_cast<double>(monotonicNow_ns() - began_ns_);
    char since[32];
    std::snprintf(since, sizeof since, "after %.0f s", seconds);
    const std::uint64_t place = answers_->progress->place();
    const std::string making = place > 0 ? "waiting, place " + std::to_string(place) : "making";
    showProgress(builds ? "building" : making, builds ? std::optional(answers_->progress->share()) : std::nullopt,
                 since);
    shown_ = true;
    return std::exchange(seen_, answers_->reports) != answers_->reports;
  }

 private:
  const std::shared_ptr<Answers> answers_;
  const std::uint64_t began_ns_ = monotonicNow_ns();
  bool shown_ = false;
  int seen_ = 0;
};

/// The server's answer. Nothing: Ctrl-C was pressed before.
Result<std::optional<v1::EditReply>> awaitReply(Connection& connection, const std::shared_ptr<Answers>& answers) {
  const Interrupt interrupt;
  ProgressLine line(answers);
  return connection.await(
      answers->reply.get_future(), [&] { return line.look(); }, Interrupt::interrupted);
}

}  // namespace

int apply(const CommonOptions& common, const ApplyOptions& options) {
  auto transaction = readSceneFile(options.scene);
  if (!transaction) return fail(kRefused, transaction.error());

  Connection connection(common, {});
  const auto opened = connection.open();
  if (!opened) return fail(kNoConnection, opened.error());
  auto sent = uploadFiles(connection, options.uploads, *transaction);
  if (sent && options.scene != "-") sent = uploadBeside(connection, options.scene, *transaction, *(*opened)->scene);
  if (!sent) return fail(Interrupt::interrupted() ? kInterrupted : codeOf(sent.error()), sent.error());

  const auto answers = std::make_shared<Answers>();
  connection.link().submit(std::move(*transaction),
                           {[answers](const v1::EditReply& reply) { answers->reply.set_value(reply); },
                            [answers](const v1::EditLive& live) { answers->live.set_value(live); },
                            [answers] { answers->live.set_value(std::nullopt); },
                            [answers](const v1::EditProgress& progress) {
                              const std::lock_guard lock(answers->mutex);
                              answers->progress = progress;
                              ++answers->reports;
                            }});
  const auto heard = awaitReply(connection, answers);
  if (!heard) return fail(kNoConnection, heard.error());
  if (!*heard) {
    return fail(kInterrupted, {"", "interrupted: the server gives the edit up, unless it has just accepted it"});
  }
  const auto accepted = outcomeOf(**heard);
  if (!accepted) return fail(kRefused, accepted.error());

  auto live = answers->live.get_future();
  if (live.wait_for(connection.timeout()) != std::future_status::ready) {
    return fail(kNoConnection, {"", "accepted as revision " + std::to_string(accepted->revision()) +
                                        ", but the servo has not taken it up in time"});
  }
  const auto felt = live.get();
  if (!felt) return fail(kNoConnection, {"", "accepted, but the server has restarted without its state"});
  print(*accepted, *felt, common.json);
  return kDone;
}

}  // namespace haptics
