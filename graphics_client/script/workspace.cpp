#include <cstdio>
#include <future>
#include <memory>

#include "common/wire/convert.h"
#include "graphics_client/script/verbs.h"

namespace haptics {

/// The server answers no SetWorkspace: it ends the connection, or has taken it before it answers what is asked next. What it
/// would refuse is refused here, by the same check.
int workspace(const CommonOptions& common, const v1::SetWorkspace& asked) {
  Connection connection(common, {});
  const auto opened = connection.open();
  if (!opened) return fail(kNoConnection, opened.error());
  if (asked.hand() > 0 && (*opened)->secondDevice.empty())
    return fail(kRefused, {"--hand", "2: there is no second hand, this server has one"});
  if (const auto checked = fromWire(asked); !checked) return fail(kRefused, checked.error());
  connection.link().setWorkspace(asked);
  const auto promise = std::make_shared<std::promise<v1::Status>>();
  connection.link().requestStatus([promise](const v1::Status& status) { promise->set_value(status); });
  const auto isRefused = [&] {
    const auto now = connection.link().latest();
    return now->link != LinkState::kLive || now->connections != (*opened)->connections;
  };
  const auto answer = connection.await(
      promise->get_future(), [] { return false; }, isRefused);
  if (!answer) return fail(kNoConnection, answer.error());
  if (!*answer) return fail(kRefused, {"", connection.link().latest()->linkText});
  if (!common.json) std::printf("taken\n");
  return kDone;
}

}  // namespace haptics
