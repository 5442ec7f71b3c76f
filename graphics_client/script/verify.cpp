#include <algorithm>
#include <iostream>

#include "graphics_client/script/message_json.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

bool isWhole(const MirrorView& view) {
  const auto& objects = view.scene->objects();
  return view.link == LinkState::kLive && view.serverRevision == view.scene->revision() &&
         std::all_of(objects.begin(), objects.end(), [&view](const auto& object) { return view.isComplete(*object); });
}

std::size_t held(const MirrorView& view) { return view.meshes.size() + view.fields.size() + view.vertexValues.size(); }

/// Goes on as long as assets keep arriving.
std::shared_ptr<const MirrorView> fetchWhole(Connection& connection) {
  while (true) {
    const std::size_t before = held(*connection.link().latest());
    auto view = connection.link().waitUntil([before](const MirrorView& v) { return isWhole(v) || held(v) > before; },
                                            connection.timeout());
    if (!view || isWhole(*view)) return view;
  }
}

}  // namespace

int verify(const CommonOptions& common) {
  Connection connection(common, {.telemetryRate_Hz = 0, .meshes = true});
  if (const auto opened = connection.open(); !opened) return fail(kNoConnection, opened.error());
  const auto whole = fetchWhole(connection);
  const auto view = whole ? whole : connection.link().latest();
  if (view->link != LinkState::kLive) return fail(kNoConnection, connection.noConnection(*view).value());
  const auto own = recomputedRoot(*view);
  if (!own) return fail(kRefused, own.error());

  const bool equal = *own == view->serverRoot && view->serverRevision == view->scene->revision();
  if (common.json) {
    const nlohmann::ordered_json result{{"equal", equal},
                                        {"revision", view->scene->revision()},
                                        {"own_root", own->hex()},
                                        {"server_revision", view->serverRevision},
                                        {"server_root", view->serverRoot.hex()},
                                        {"meshes", view->meshes.size()},
                                        {"assets", held(*view)}};
    std::cout << result.dump() << '\n';
  } else {
    std::cout << (equal ? "equal" : "NOT EQUAL") << ": " << view->scene->objects().size() << " objects, " << held(*view)
              << " assets\n  own    revision " << view->scene->revision() << "  " << own->hex()
              << "\n  server revision " << view->serverRevision << "  " << view->serverRoot.hex() << '\n';
  }
  return equal ? kDone : kRefused;
}

}  // namespace haptics
