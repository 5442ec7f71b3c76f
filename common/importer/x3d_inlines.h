#pragma once

#include <cstddef>
#include <string>

#include "common/error/error.h"
#include "common/importer/include_reader.h"

namespace haptics {

struct InlinedX3d {
  std::string text;
  std::size_t bytes = 0;  ///< Of the files that it includes.
};

/// Puts in the place of an Inline the scene of the first X3D file of its url that the reader gives, with names (DEF) and unit of
/// its own; nothing is taken from a network. An Inline of none stays. Refused: Inlines that make many times the file's bytes.
/// @param file  As plainXml() makes it.
[[nodiscard]] Result<InlinedX3d> withInlines(const std::string& file, const IncludeReader& readIncluded);

}  // namespace haptics
