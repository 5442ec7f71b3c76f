#include <future>
#include <iostream>
#include <memory>

#include "common/json/message_json.h"
#include "common/text/printable.h"
#include "graphics_client/script/verbs.h"

namespace haptics {

int dump(const CommonOptions& common) {
  Connection connection(common, {});
  if (const auto opened = connection.open(); !opened) return fail(kNoConnection, opened.error());
  const auto promise = std::make_shared<std::promise<v1::DumpReply>>();
  connection.link().requestDump([promise](const v1::DumpReply& reply) { promise->set_value(reply); });
  const auto answer = connection.await(promise->get_future());
  if (!answer) return fail(kNoConnection, answer.error());
  if (answer->file().empty()) return fail(kRefused, {"", answer->reason()});
  if (common.json) {
    std::cout << toJson(*answer).line() << '\n';
  } else {
    std::cout << printable(answer->file()) << " on the server's machine; haptic_eval replay FILE runs it again\n";
  }
  return kDone;
}

}  // namespace haptics
