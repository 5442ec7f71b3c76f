#pragma once

#include <string>

#include "common/error/error.h"

namespace haptics {

/// The same scene in XML, as plainXml() makes it, of an X3D file in either encoding: XML (ISO/IEC 19776-1) or classic
/// (ISO/IEC 19776-2), of which VRML 97 is one. Of a PROTO its instances stay, as ProtoInstance without fields.
/// Refused, naming the line: what is not as the grammar of the classic encoding has it, a USE before its DEF, nodes that nest
/// deeper than kDeepestNesting.
[[nodiscard]] Result<std::string> x3dInXml(std::string file);

}  // namespace haptics
