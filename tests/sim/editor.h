#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "tests/sim/sim_client.h"
#include "tests/sim/stage.h"

namespace haptics::sim {

struct Habits {
  double pause_ms = 150;      ///< Between edits, on average.
  bool checksHashes = false;  ///< In preconditions, beside revisions: whoever's memory may fail needs to.
  std::size_t flood = 0;      ///< Edits at once, one time.
};

/// The program behind a client: reads what the client shows and asks for changes, some that rest on what it read and
/// some that do not, until it is told to stop.
class Editor {
 public:
  /// Stage and client outlive it.
  Editor(Stage& stage, SimClient& client, const Habits& habits);
  void stop() { alive_.reset(); }

 private:
  Stage& stage_;
  SimClient& client_;
  const Habits habits_;
  std::uint64_t made_ = 0;
  std::deque<std::string> own_;  // objects that it added
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);

  void editLater();
  void edit();
  void increment();
  struct MaterialEdit;
  [[nodiscard]] std::optional<MaterialEdit> someMaterial();
  void paint(bool doomed);
  void addBox();
  void addUpload();
  void changeSurface();
  void changeMotion();
  struct DeformationEdit;
  [[nodiscard]] std::optional<DeformationEdit> someDeformation();
  void changeDeformation();
  void uploadResidue();
  void uploadTexture();
  void removeOwn();
  void moveMany(bool doomed);
  void flood();
  [[nodiscard]] std::string freshName();
};

}  // namespace haptics::sim
