#pragma once

#include <memory>
#include <string>

#include "common/error/error.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/server_options.h"
#include "haptic_server/state/state_folder.h"
#include "haptic_server/state/state_scrubber.h"

namespace haptics {

/// Loads a scene file; nothing where it is empty. Refused: a file that is no scene, naming the field.
[[nodiscard]] Result<void> loadScene(SceneService& sceneService, const std::string& file);

/// Goes on from the state in the folder of --state where there is one, and keeps all edits there. The folder outlives the
/// scene service. Refused: a folder that cannot be used.
[[nodiscard]] Result<std::unique_ptr<StateFolder>> resumeState(SceneService& sceneService,
                                                               const ServerOptions& options);

/// Re-reads the files of that folder now and then, and has them written anew from memory where they are damaged. Both
/// outlive what is returned.
[[nodiscard]] std::unique_ptr<StateScrubber> scrubState(SceneService& sceneService, StateFolder& state,
                                                        const std::string& folder);

}  // namespace haptics
