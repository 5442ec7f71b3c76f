#include <cstdio>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/message_json.h"
#include "graphics_client/script/upload.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

/// The two answers to one edit. Shared with the link's thread.
struct Answers {
  std::promise<v1::EditReply> reply;
  std::promise<std::optional<v1::EditLive>> live;  // nothing: the server lost its state
};

std::string hexOf(const std::string& hash) {
  const auto whole = ContentHash::fromBytes(hash);
  return whole ? whole->hex() : "";
}

void print(const v1::Accepted& accepted, const v1::EditLive& live, bool json) {
  if (json) {
    auto object = toJson(accepted);
    object["live_since_tick"] = live.tick();
    std::cout << jsonText(object) << std::endl;
    return;
  }
  std::cout << "revision " << accepted.revision() << ", live since tick " << live.tick() << "\nroot "
            << hexOf(accepted.root()) << '\n';
  for (const auto& object : accepted.object()) {
    std::cout << "object " << object.id() << " \"" << printable(object.name()) << "\", mesh "
              << hexOf(object.mesh()).substr(0, 12) << ", " << object.stiffness_n_per_m() << " N/m, "
              << object.damping_ns_per_m() << " N s/m\n";
  }
  for (const auto& line : accepted.report()) std::cout << printable(line) << '\n';
}

int refuse(const v1::EditReply& reply) {
  if (reply.has_rejected()) return fail(kRefused, {reply.rejected().field(), reply.rejected().reason()});
  std::string now;
  for (const auto& object : reply.conflict().current()) {
    now += "; \"" + object.name() + "\" is at revision " + std::to_string(object.revision());
  }
  return fail(kRefused, {"preconditions", reply.conflict().reason() + now});
}

}  // namespace

int apply(const CommonOptions& common, const ApplyOptions& options) {
  auto transaction = readSceneFile(options.scene);
  if (!transaction) return fail(kRefused, transaction.error());

  Connection connection(common, {});
  if (const auto opened = connection.open(); !opened) return fail(kNoConnection, opened.error());
  if (const auto sent = uploadFiles(connection, options.uploads, *transaction); !sent) {
    return fail(Interrupt::interrupted() ? kInterrupted : kRefused, sent.error());
  }

  const auto answers = std::make_shared<Answers>();
  connection.link().submit(std::move(*transaction),
                           {[answers](const v1::EditReply& reply) { answers->reply.set_value(reply); },
                            [answers](const v1::EditLive& live) { answers->live.set_value(live); },
                            [answers] { answers->live.set_value(std::nullopt); }});
  const auto reply = connection.await(answers->reply.get_future());
  if (!reply) return fail(kNoConnection, reply.error());
  if (!reply->has_accepted()) return refuse(*reply);

  auto live = answers->live.get_future();
  if (live.wait_for(connection.timeout()) != std::future_status::ready) {
    return fail(kNoConnection, {"", "accepted as revision " + std::to_string(reply->accepted().revision()) +
                                        ", but the servo has not taken it up in time"});
  }
  const auto felt = live.get();
  if (!felt) return fail(kNoConnection, {"", "accepted, but the server has restarted without its state"});
  print(reply->accepted(), *felt, common.json);
  return kDone;
}

}  // namespace haptics
