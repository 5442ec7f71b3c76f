#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace haptics {

/// A text of VRML 97 without prototypes of files that are not there.
struct VrmlProtos {
  std::string text;
  std::vector<std::string> missing = {};  ///< The last of the names of each of those.
};

/// Leaves of the names in each EXTERNPROTO the first for which `isThere`: Coin looks for the first of all, and ends where that is
/// not there. Where none is, the prototype becomes one of nothing, with the fields that its interface has.
/// @param isThere  Of a name of a file, without what follows "#".
[[nodiscard]] VrmlProtos withProtosThatAreThere(std::string_view text,
                                                const std::function<bool(const std::string&)>& isThere);

}  // namespace haptics
