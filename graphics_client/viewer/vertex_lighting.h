#pragma once

#include <vtkActor.h>

namespace haptics {

/// Lights a surface at its vertices, not at each pixel, by the same formula: where triangles are a few pixels large the
/// picture is the same, and in software it is drawn in half the time. For closed surfaces with normals whose edges are not
/// drawn, under the three lights of a pane (stage.h).
void lightVertices(vtkActor* actor, bool on);

}  // namespace haptics
