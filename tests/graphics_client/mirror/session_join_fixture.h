#pragma once

#include <gtest/gtest.h>

#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {

/// A session and a fake server with two objects, not yet connected.
class SessionJoin : public testing::Test {
 protected:
  void SetUp() override {
    rig_.server.addObject("a");
    rig_.server.addObject("b");
  }

  v1::Hello hello() const { return rig_.server.heard(v1::Envelope::kHello).at(0).hello(); }

  void expectInStep() {
    const MirrorView view = rig_.view();
    EXPECT_EQ(view.link, LinkState::kLive);
    EXPECT_TRUE(view.hashesEqual);
    EXPECT_EQ(view.scene->root(), rig_.server.scene.root());
    EXPECT_EQ(*recomputedRoot(view), rig_.server.scene.root());
  }

  SessionRig rig_;
};

}  // namespace haptics
