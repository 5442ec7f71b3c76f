#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "haptics/v1/scene.pb.h"

namespace haptics::fuzz {

/// An input is a row of pieces: a little-endian u16 length, then so many bytes (as many as there are, for the last).
/// Message fuzzers take one message a piece, without the frame around it, which would break at every mutation.
template <class Take>
void forEachPiece(std::span<const std::uint8_t> input, Take take) {
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(input[0] | input[1] << 8, input.size() - 2);
    take(input.subspan(2, length));
    input = input.subspan(2 + length);
  }
}

/// Ends the process, which is how a fuzzer reports.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

/// Generated meshes of sizes that do not stop the fuzzer: what is sought are wrong bytes, not long work.
inline void keepSmall(v1::Transaction& transaction) {
  constexpr std::uint32_t kMaxSegments = 4;
  for (v1::Operation& operation : *transaction.mutable_operations()) {
    v1::MeshSource* mesh = operation.has_add()      ? operation.mutable_add()->mutable_mesh()
                           : operation.has_remesh() ? operation.mutable_remesh()->mutable_mesh()
                                                    : nullptr;
    if (mesh != nullptr && mesh->has_box() && mesh->box().segments() > kMaxSegments) {
      mesh->mutable_box()->set_segments(kMaxSegments);
    }
  }
}

}  // namespace haptics::fuzz
