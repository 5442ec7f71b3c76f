// A server that tells a client's session one thing after another, mostly true and whole, some of it lost, late, twice or
// damaged. Whatever it says: the client holds no more than its limits, calls no scene equal that is not, tells of each
// edit once, and is in step with an honest server afterwards.

#include <gtest/gtest.h>

#include <deque>

#include "common/wire/convert.h"
#include "graphics_client/mirror/playback.h"
#include "tests/fuzz/pieces.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {
namespace {

constexpr std::size_t kMaxActions = 300;
constexpr std::size_t kMaxObjects = 6;
constexpr std::uint64_t kMillisecond_ns = 1'000'000;

class Story {
 public:
  explicit Story(std::span<const std::uint8_t> input) : input_(input) {
    rig_.server.distort = [this](std::string frame) { return distorted(std::move(frame)); };
  }

  void run() {
    rig_.connect();
    for (std::size_t i = 0; i < kMaxActions && !input_.empty(); ++i) {
      if (!rig_.server.connected() || !rig_.clientEnd) rig_.connect();
      act();
      rig_.settle();
      rig_.advance(ClientSession::kPoll_ns);
      check();
    }
    endWell();
  }

 private:
  struct EditOutcome {
    int replied = 0, over = 0;
    bool accepted = false;
  };

  std::uint8_t byte() {
    if (input_.empty()) return 0;
    const std::uint8_t first = input_[0];
    input_ = input_.subspan(1);
    return first;
  }

  void act() {
    FakeServer& server = rig_.server;
    enum Action {
      kWelcome,
      kResume,
      kSnapshot,
      kAdd,
      kChange,
      kCommitAgain,
      kAssets,
      kChunk,
      kUnavailable,
      kHeartbeat,
      kTelemetry,
      kBodies,
      kAccept,
      kLive,
      kPutOff,
      kReject,
      kClock,
      kStatus,
      kUploadReply,
      kRestart,
      kCut,
      kWait,
      kSubmit,
      kUpload,
      kDrop,
      kTwice,
      kLater,
      kDamage,
      kAny,
      kActions
    };
    switch (byte() % kActions) {
      case kWelcome:
        return server.welcome(false);
      case kResume:
        return server.welcome(true);
      case kSnapshot:
        return server.snapshot();
      case kAdd:
        return add();
      case kChange:
        return change();
      case kCommitAgain:
        return server.sendCommit(lastCommit_);
      case kAssets:
        return sendAssets();
      case kChunk:
        return sendChunk();
      case kUnavailable:
        return sayUnavailable();
      case kHeartbeat:
        return server.heartbeat();
      case kTelemetry:
        return server.telemetry(byte(), rig_.now_ns + byte() * kMillisecond_ns);
      case kBodies:
        return sendBodies();
      case kAccept:
        return server.accepted(byte() % 8, byte());
      case kLive:
        return server.live(byte() % 8, byte(), byte());
      case kPutOff:
        return sendReply([&](v1::EditReply& reply) { reply.mutable_rejected()->set_retry_after_ms(1 + byte()); });
      case kReject:
        return sendReply([&](v1::EditReply& reply) {
          (byte() & 1) != 0 ? reply.mutable_conflict()->set_reason("other")
                            : reply.mutable_rejected()->set_reason("no");
        });
      case kClock:
        return sendClock();
      case kStatus:
        return send([](v1::Envelope& envelope) { envelope.mutable_status(); });
      case kUploadReply:
        return sendUploadReply();
      case kRestart:
        return server.restart();
      case kCut:
        return rig_.cut();
      case kWait:
        return rig_.advance(byte() * 20 * kMillisecond_ns);
      case kSubmit:
        return submit();
      case kUpload:
        return rig_.client.upload(AssetKind::kMesh, std::string(1 + 300 * byte(), 'x'), {});
      case kDrop:
        next_ = Distortion::kDrop;
        return;
      case kTwice:
        next_ = Distortion::kTwice;
        return;
      case kLater:
        next_ = Distortion::kLater;
        return;
      case kDamage:
        next_ = Distortion::kDamage;
        return;
      default:
        return sendAny();
    }
  }

  /// Distorts one frame: the first after the action that asks for it.
  std::vector<std::string> distorted(std::string frame) {
    std::vector<std::string> frames;
    switch (std::exchange(next_, Distortion::kNone)) {
      case Distortion::kDrop:
        return frames;
      case Distortion::kTwice:
        frames.push_back(frame);
        break;
      case Distortion::kLater:
        later_.push_back(std::move(frame));
        return frames;
      case Distortion::kDamage:
        frame[(byte() << 8 | byte()) % frame.size()] ^= static_cast<char>(1U << byte() % 8);
        break;
      case Distortion::kNone:
        break;
    }
    frames.push_back(std::move(frame));
    if (later_.size() > 1) {
      frames.push_back(std::move(later_.front()));
      later_.pop_front();
    }
    return frames;
  }

  template <class Fill>
  void send(Fill fill) {
    v1::Envelope envelope;
    fill(envelope);
    rig_.server.send(envelope);
  }

  template <class Fill>
  void sendReply(Fill fill) {
    send([&](v1::Envelope& envelope) {
      envelope.mutable_edit_reply()->set_client_seq(byte() % 8);
      fill(*envelope.mutable_edit_reply());
    });
  }

  void add() {
    if (rig_.server.scene.objects().size() >= kMaxObjects) return;
    lastCommit_ = rig_.server.addObject("object_" + std::to_string(++added_));
    rig_.server.sendCommit(lastCommit_);
  }

  void change() {
    const auto objects = rig_.server.scene.objects();
    if (objects.empty()) return;
    ObjectRecord record = *objects[byte() % objects.size()];
    const std::uint8_t what = byte();
    record.pose.position.x = 1e-3 * what;
    if ((what & 1) != 0) record.deformation.softness = Softness{100, 0.01, 2, 0, (what & 2) != 0 ? 0.5 : 0};
    if ((what & 4) != 0) record.motion = MotionProperties{.mass_kg = 0.1};
    if ((what & 8) != 0) record.mesh = rig_.server.addMesh(tetrahedron(1.F + what));
    lastCommit_ = rig_.server.change(record);
    rig_.server.sendCommit(lastCommit_);
  }

  std::vector<v1::Envelope> requests() const { return rig_.server.heard(v1::Envelope::kAssetRequest); }

  void sendAssets() {
    for (const v1::Envelope& request : requests()) {
      const auto hash = ContentHash::fromBytes(request.asset_request().hash());
      if (!rig_.server.assets.contains(*hash)) continue;
      if (request.asset_request().offset() >= rig_.server.assets[*hash].size()) {
        return send([](v1::Envelope& envelope) { envelope.mutable_refusal()->set_field("asset_request.offset"); });
      }
      rig_.server.asset(*hash, request.asset_request().offset());
    }
  }

  void sendChunk() {
    const auto asked = requests();
    if (asked.empty()) return;
    send([&](v1::Envelope& envelope) {
      v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
      chunk.set_hash(asked[byte() % asked.size()].asset_request().hash());
      chunk.set_kind(static_cast<v1::AssetKind>(1 + byte() % 5));
      chunk.set_total_size(std::uint64_t{byte()} << byte() % 40);
      chunk.set_offset(byte());
      chunk.set_data(std::string(byte(), 'x'));
    });
  }

  void sayUnavailable() {
    const auto asked = requests();
    if (asked.empty()) return;
    send([&](v1::Envelope& envelope) {
      envelope.mutable_asset_unavailable()->set_hash(asked[byte() % asked.size()].asset_request().hash());
    });
  }

  void sendBodies() {
    send([&](v1::Envelope& envelope) {
      v1::Telemetry& sample = *envelope.mutable_telemetry();
      sample.set_tick(1000 + byte());
      sample.set_time_ns(rig_.now_ns - byte() * kMillisecond_ns);
      sample.set_scene_revision(byte());
      sample.set_object(byte() % 8);
      v1::BodyPose& body = *sample.add_body();
      body.set_object(byte() % 8);
      body.mutable_pose()->mutable_position()->set_x(0.01 * byte());
      body.mutable_pose()->mutable_rotation()->set_w(1);
      v1::Dent& dent = *sample.add_dent();
      dent.set_object(byte() % 8);
      for (int d = 0; d < 3; ++d) {
        dent.add_centre(0.1F * byte());
        dent.add_displacement(0.01F * byte());
      }
    });
  }

  void sendClock() {
    send([&](v1::Envelope& envelope) {
      v1::ClockReply& reply = *envelope.mutable_clock_reply();
      reply.set_client_send_ns(rig_.now_ns - byte() * kMillisecond_ns);
      reply.set_server_receive_ns(std::uint64_t{byte()} << byte() % 64);
      reply.set_server_send_ns(std::uint64_t{byte()} << byte() % 64);
    });
  }

  void sendUploadReply() {
    const auto heard = rig_.server.heard(v1::Envelope::kAssetUpload);
    if (heard.empty()) return;
    send([&](v1::Envelope& envelope) {
      v1::AssetUploadReply& reply = *envelope.mutable_asset_upload_reply();
      reply.set_hash(heard.back().asset_upload().chunk().hash());
      reply.set_accepted((byte() & 1) != 0);
      reply.set_retry_after_ms(byte() % 4);
    });
  }

  void submit() {
    EditOutcome& outcome = edits_.emplace_back();
    rig_.client.submit(removal(byte()), {[&](const v1::EditReply& reply) {
                                           ++outcome.replied;
                                           outcome.accepted = reply.has_accepted();
                                         },
                                         [&](const v1::EditLive&) { ++outcome.over; }, [&] { ++outcome.over; }});
    rig_.client.requestStatus([](const v1::Status&) {});
  }

  /// A message of the fuzzer's own.
  void sendAny() {
    const std::size_t wanted = byte();
    const std::size_t size = std::min(wanted, input_.size());
    v1::Envelope envelope;
    if (!envelope.ParseFromArray(input_.data(), static_cast<int>(size))) return;
    input_ = input_.subspan(size);
    rig_.server.send(envelope);
  }

  void check() {
    const auto view = std::make_shared<const MirrorView>(rig_.view());
    fuzz::require(view->scene->objects().size() <= kMaxHeldObjects, "objects stay within their limit");
    fuzz::require(view->assetBytes <= kMaxHeldAssets_bytes, "assets stay within their limit");
    fuzz::require(view->serverName.size() + view->device.size() <= 2 * kMaxServerText_bytes, "texts do");
    if (view->hashesEqual) {
      const auto own = recomputedRoot(*view);
      fuzz::require(own && *own == view->serverRoot, "hashes that are called equal are equal");
    }
    for (const EditOutcome& edit : edits_) {
      fuzz::require(edit.replied <= 1, "an edit is answered once");
      fuzz::require(edit.over <= (edit.accepted ? 1 : 0), "it is live or lost once, after it was accepted");
    }
    const auto shown = playback_.at(view, rig_.now_ns);
    for (const auto& object : shown->scene->objects()) (void)shown->cornersOf(*object, 0);
  }

  void greet() {
    rig_.connect();
    rig_.server.welcome(false);
    rig_.server.snapshot();
    rig_.settle();
  }

  /// An honest server, in place of this one: the client is in step, and its edits are answered. It may have to come twice,
  /// when the asset that the first server had begun with is another.
  void endWell() {
    constexpr int kRounds = 40;
    rig_.server.distort = nullptr;
    if (rig_.clientEnd) rig_.cut();
    rig_.server.restart();
    (void)rig_.server.addObject("last");
    greet();
    bool again = false;
    for (int i = 0; i < kRounds; ++i) {
      if (!rig_.server.connected()) {
        fuzz::require(!std::exchange(again, true), "a client stays with an honest server");
        greet();
      }
      sendAssets();
      for (const v1::Envelope& request : rig_.server.heard(v1::Envelope::kEditRequest)) {
        rig_.server.accepted(request.edit_request().client_seq(), 1);
      }
      rig_.server.heartbeat();
      rig_.settle();
      rig_.advance(ClientSession::kHeartbeat_ns / 4);
    }
    const MirrorView view = rig_.view();
    fuzz::require(view.link == LinkState::kLive && view.hashesEqual, "a client is in step with an honest server");
    fuzz::require(view.scene->root() == rig_.server.scene.root(), "and holds its scene");
    for (const EditOutcome& edit : edits_) fuzz::require(edit.replied == 1, "every edit is answered");
  }

  enum class Distortion { kNone, kDrop, kTwice, kLater, kDamage };

  std::span<const std::uint8_t> input_;
  std::deque<EditOutcome> edits_;
  std::deque<std::string> later_;
  Distortion next_ = Distortion::kNone;
  v1::Commit lastCommit_;
  int added_ = 0;
  Playback playback_;
  SessionRig rig_;
};

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  GTEST_FLAG_SET(throw_on_failure, true);
  haptics::Story({data, size}).run();
  return 0;
}
