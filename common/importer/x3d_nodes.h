#pragma once

#include <map>
#include <string_view>

namespace haptics {

// Of the nodes of ISO/IEC 19775-1.

/// Those that have the fields of the one beside them, by which Assimp knows it, and are felt like it.
[[nodiscard]] const std::map<std::string_view, std::string_view>& x3dNodesReadAs();

/// Cannot be felt; some of it is not known to Assimp, or has to be right for it.
[[nodiscard]] bool isUnfeltX3dNode(std::string_view name);

/// Assimp is left it.
[[nodiscard]] bool isFeltX3dNode(std::string_view name);

}  // namespace haptics
