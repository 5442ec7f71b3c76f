#include <algorithm>
#include <chrono>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "common/json/message_json.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

/// Telemetry rate; the dents come with it.
constexpr double kSamples_Hz = 20;
/// Shapes are compared until they are equal: what is being dented differs by the time that a sample takes.
constexpr std::chrono::milliseconds kBetweenShapes{150};
constexpr int kMaxShapes = 40;

bool isWhole(const MirrorView& view) {
  return view.link == LinkState::kLive && view.serverRevision == view.scene->revision() &&
         std::ranges::all_of(view.scene->objects(), [&](const auto& object) { return view.isComplete(*object); });
}

std::size_t held(const MirrorView& view) {
  return view.meshes.size() + view.fields.size() + view.vertexValues.size() + view.movedVertices.size() +
         view.pointFields.size();
}

/// Goes on as long as assets keep arriving.
std::shared_ptr<const MirrorView> fetchWhole(Connection& connection) {
  while (true) {
    const std::size_t before = held(*connection.link().latest());
    auto view = connection.link().waitUntil([before](const MirrorView& v) { return isWhole(v) || held(v) > before; },
                                            connection.timeout());
    if (!view || isWhole(*view)) return view;
  }
}

bool anyGives(const MirrorView& view) {
  return std::ranges::any_of(view.scene->objects(), [](const auto& object) { return !object->deformation.empty(); });
}

/// The hash of what gives, on both sides.
struct Shapes {
  std::optional<ContentHash> own, server;
  [[nodiscard]] bool equal() const { return own && own == server; }
};

Result<Shapes> shapesNow(Connection& connection) {
  const auto promise = std::make_shared<std::promise<v1::Status>>();
  connection.link().requestStatus([promise](const v1::Status& status) { promise->set_value(status); }, true);
  const auto status = connection.await(promise->get_future());
  if (!status) return tl::unexpected<Error>(status.error());
  const auto view = connection.link().latest();
  Shapes shapes{.own = {}, .server = ContentHash::fromBytes(status->deformed_hash())};
  if (view->sample && view->scene->revision() == status->revision()) shapes.own = deformedHash(*view);
  return shapes;
}

/// As this client's newest sample has the dents.
Result<Shapes> compareShapes(Connection& connection) {
  Result<Shapes> shapes = shapesNow(connection);
  for (int i = 1; i < kMaxShapes && shapes && !shapes->equal(); ++i) {
    std::this_thread::sleep_for(kBetweenShapes);
    shapes = shapesNow(connection);
  }
  return shapes;
}

std::string textOf(const std::optional<ContentHash>& hash) { return hash ? hash->hex() : "not known"; }

}  // namespace

int verify(const CommonOptions& common) {
  Connection connection(common, {.telemetryRate_Hz = kSamples_Hz, .meshes = true});
  if (const auto opened = connection.open(); !opened) return fail(kNoConnection, opened.error());
  const auto whole = fetchWhole(connection);
  const auto view = whole ? whole : connection.link().latest();
  if (view->link != LinkState::kLive) return fail(kNoConnection, connection.noConnection(*view).value());
  const auto own = recomputedRoot(*view);
  if (!own) return fail(kRefused, own.error());
  std::optional<Shapes> shapes;
  if (anyGives(*view)) {
    const auto compared = compareShapes(connection);
    if (!compared) return fail(kNoConnection, compared.error());
    shapes = *compared;
  }

  const bool equalRoots = *own == view->serverRoot && view->serverRevision == view->scene->revision();
  const bool equal = equalRoots && (!shapes || shapes->equal());
  if (common.json) {
    Json result{{"equal", equal},
                {"revision", view->scene->revision()},
                {"own_root", own->hex()},
                {"server_revision", view->serverRevision},
                {"server_root", view->serverRoot.hex()},
                {"meshes", view->meshes.size()},
                {"assets", held(*view)}};
    if (shapes) {
      result.set("own_deformed_hash", textOf(shapes->own));
      result.set("server_deformed_hash", textOf(shapes->server));
    }
    std::cout << result.line() << '\n';
  } else {
    std::cout << (equal ? "equal" : "NOT EQUAL") << ": " << view->scene->objects().size() << " objects, " << held(*view)
              << " assets\n  own    revision " << view->scene->revision() << "  " << own->hex()
              << "\n  server revision " << view->serverRevision << "  " << view->serverRoot.hex() << '\n';
    if (shapes) {
      std::cout << "  own    shapes " << textOf(shapes->own) << "\n  server shapes " << textOf(shapes->server) << '\n';
      if (!shapes->equal()) std::cout << "  shapes that a hand dents meanwhile differ: try again once it has let go\n";
    }
  }
  return equal ? kDone : kRefused;
}

}  // namespace haptics
