#include "tests/graphics_client/editing/edit_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/framing.h"
#include "haptic_server/net/scene_messages.h"

namespace haptics::test {
namespace {

void put(MirrorView& view, const std::shared_ptr<const Asset>& asset) {
  const ContentHash& hash = asset->name.hash;
  if (const auto mesh = as<MeshAsset>(asset)) view.meshes[hash] = mesh->mesh;
  if (const auto field = as<FieldAsset>(asset)) view.fields[hash] = field->field;
  if (const auto values = as<VertexValuesAsset>(asset)) view.vertexValues[hash] = values->values;
  if (const auto moved = as<MovedVerticesAsset>(asset)) view.movedVertices[hash] = moved->moved;
  if (const auto points = as<PointFieldAsset>(asset)) view.pointFields[hash] = points->field;
}

std::optional<Result<v1::Accepted>> none() { return std::nullopt; }

}  // namespace

v1::EditReply EditServer::decide(SessionId session, const v1::EditRequest& request) {
  v1::EditReply reply;
  reply.set_client_seq(request.client_seq());
  auto transaction = fromWire(request.transaction());
  EditOutcome outcome =
      transaction ? sequencer_.submit(session, request.client_seq(), *transaction) : EditOutcome{transaction.error()};
  toWire(outcome, kMaxFrameBytes, reply);
  if (reply.has_accepted()) {
    ++accepted;
    uploaded_.clear();
  }
  return reply;
}

Result<void> EditServer::upload(const AssetContent& content) {
  ++uploads;
  auto asset = store_.internEncoded(kindOf(content), canonicalBytes(content).copy());
  if (!asset) return tl::unexpected(std::move(asset).error());
  uploaded_.push_back(*std::move(asset));
  return {};
}

void EditServer::bake(const std::string& name, MovedVertices residue) {
  ObjectRecord record = *scene().find(name);
  ObjectAssets assets = sequencer_.assetsOf(record.id);
  if (assets.residue) std::erase(assets.others, assets.residue);
  assets.residue = store_.intern(std::move(residue));
  assets.others.push_back(assets.residue);
  record.deformation.residue = assets.residue->name.hash;
  record.revision = scene().revision() + 1;
  const ObjectId id = record.id;
  ASSERT_TRUE(sequencer_.replaceObjects({std::move(record)}, {{id, std::move(assets)}}));
}

std::shared_ptr<const MirrorView> EditServer::mirrored() const {
  auto view = std::make_shared<MirrorView>();
  view->link = LinkState::kLive;
  view->epoch = sequencer_.history()->epoch;
  view->scene = std::make_shared<const SceneVersion>(scene());
  for (const auto& object : scene().objects()) {
    const ObjectAssets& assets = sequencer_.assetsOf(object->id);
    put(*view, assets.mesh);
    for (const auto& asset : assets.others) put(*view, asset);
  }
  return view;
}

EditPort EditClient::port() {
  return {.view = [this] { return held_ ? held_ : server_.mirrored(); },
          .submit =
              [this](v1::Transaction transaction, EditCallbacks callbacks) {
                ++submitted;
                mostInFlight = std::max(mostInFlight, ++inFlight);
                auto replied = std::move(callbacks.replied);
                callbacks.replied = [this, replied](const v1::EditReply& reply) {
                  --inFlight;
                  replied(reply);
                };
                outbox_.submit(std::move(transaction), std::move(callbacks), 0);
              },
          .upload =
              [this](const AssetContent& content, const UploadCallbacks& callbacks) {
                v1::AssetUploadReply reply;
                const auto held = server_.upload(content);
                reply.set_accepted(held.has_value());
                if (!held) reply.set_reason(held.error().text());
                callbacks.finished(reply);
              }};
}

bool EditClient::deliver() {
  if (!isConnected_) return false;
  const v1::EditRequest* request = outbox_.next();
  if (request == nullptr) return false;
  outbox_.replied(server_.decide(session_, *request), 0);
  return true;
}

void EditClient::loseConnection() {
  if (const v1::EditRequest* request = outbox_.next()) server_.decide(session_, *request);
  outbox_.connectionLost();
  isConnected_ = false;
}

Result<void> Editor::submit(const v1::Transaction& transaction, std::vector<AssetContent> uploads) {
  auto outcome = none();
  history.submit({transaction, "edit", std::move(uploads)}, [&](const auto& answer) { outcome = answer; });
  client.deliverAll();
  if (!*outcome) return tl::unexpected(outcome->error());
  return {};
}

Result<void> Editor::undo() {
  auto outcome = none();
  history.undo([&](const auto& answer) { outcome = answer; });
  client.deliverAll();
  if (!*outcome) return tl::unexpected(outcome->error());
  return {};
}

Result<void> Editor::redo() {
  auto outcome = none();
  history.redo([&](const auto& answer) { outcome = answer; });
  client.deliverAll();
  if (!*outcome) return tl::unexpected(outcome->error());
  return {};
}

v1::Transaction parsed(const std::string& text) {
  auto transaction = parseSceneText(text, "test");
  EXPECT_TRUE(transaction) << transaction.error().text();
  return transaction.value_or(v1::Transaction());
}

v1::Transaction addBox(const std::string& name) {
  return parsed("operations { add { name: '" + name + "' mesh { box { size_m { x: 0.1 y: 0.1 z: 0.1 } } } } }");
}

v1::Transaction setStiffness(const std::string& name, double stiffness_N_per_m) {
  return parsed("operations { set_material { object { name: '" + name +
                "' } material { stiffness_N_per_m: " + std::to_string(stiffness_N_per_m) + " } } }");
}

v1::Transaction moveTo(const std::string& name, double x_m) {
  return parsed("operations { set_pose { object { name: '" + name + "' } pose { position { x: " + std::to_string(x_m) +
                " } } } }");
}

v1::Transaction removal(const std::string& name) {
  return parsed("operations { remove { object { name: '" + name + "' } } }");
}

ContentHash contentHash(const SceneVersion& scene, bool withResidues) {
  std::map<std::string, ContentHash> hashes;
  for (const auto& object : scene.objects()) {
    ObjectRecord record = *object;
    record.id = 0;
    record.revision = 0;
    if (!withResidues) record.deformation.residue.reset();
    hashes[record.name] = record.hash();
  }
  Hasher hasher;
  for (const auto& [name, hash] : hashes) hasher.add(hash);
  return hasher.finish();
}

}  // namespace haptics::test
