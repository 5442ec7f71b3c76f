#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tests/eval/random.h"
#include "tests/eval/renderer.h"

/// The failure scenes: scripted motion that breaks methods of rendering, each with a number for it. SI in the code,
/// metres in the scene's frame; units as the keys say in the results.
namespace haptics {
struct ToolResult;
}

namespace haptics::eval {

struct SceneResult {
  nlohmann::ordered_json measures;  ///< Flat; each key names its unit.
  bool pass = false;                ///< The method is safe here.
};

/// `random` decides place, orientation, direction and speed.
using SceneRun = SceneResult (*)(Renderer& method, Random& random);

struct FailureScene {
  std::string_view name;
  std::string_view about;
  SceneRun run;
  Concern concern = Concern::kContact;
  std::string_view reported = "";  ///< Of P1 to P9: where users of other programs reported it.

  /// The same for every method.
  [[nodiscard]] Random random(std::uint64_t seed) const {
    constexpr std::uint64_t kPublic = 500;
    return Random(seed * 1000 + (name[0] == 'P' ? kPublic : 0) + std::stoul(std::string(name.substr(1))));
  }
};

[[nodiscard]] SceneResult slideOffCube(Renderer& method, Random& random);                ///< S1
[[nodiscard]] SceneResult slideIntoBox(Renderer& method, Random& random);                ///< S2
[[nodiscard]] SceneResult crossComb(Renderer& method, Random& random);                   ///< S3
[[nodiscard]] SceneResult moveThroughStillHip(Renderer& method, Random& random);         ///< S4
[[nodiscard]] SceneResult aimAtVerticesAndEdges(Renderer& method, Random& random);       ///< S5
[[nodiscard]] SceneResult strokeFans(Renderer& method, Random& random);                  ///< S6
[[nodiscard]] SceneResult runDeepAndFast(Renderer& method, Random& random);              ///< S7
[[nodiscard]] SceneResult approachMedialAxis(Renderer& method, Random& random);          ///< S8
[[nodiscard]] SceneResult pressThinPlates(Renderer& method, Random& random);             ///< S9
[[nodiscard]] SceneResult slideOverSphere(Renderer& method, Random& random);             ///< S10
[[nodiscard]] SceneResult strokeBadMeshes(Renderer& method, Random& random);             ///< S11
[[nodiscard]] SceneResult strokeSharpAndScaledShapes(Renderer& method, Random& random);  ///< S12
[[nodiscard]] SceneResult restOnGratings(Renderer& method, Random& random);              ///< S13
[[nodiscard]] SceneResult strokeShadedFacets(Renderer& method, Random& random);          ///< S14
[[nodiscard]] SceneResult slideWithTremor(Renderer& method, Random& random);             ///< S15
[[nodiscard]] SceneResult yieldToTheHand(Renderer& method, Random& random);              ///< S16
[[nodiscard]] SceneResult editUnderTheHand(Renderer& method, Random& random);            ///< S17
[[nodiscard]] SceneResult meetMovingBodies(Renderer& method, Random& random);            ///< S18
[[nodiscard]] SceneResult editMovingBodies(Renderer& method, Random& random);            ///< S19
[[nodiscard]] SceneResult wanderAmongMovingBodies(Renderer& method, Random& random);     ///< S20
[[nodiscard]] SceneResult exploreSoups(Renderer& method, Random& random);                ///< S21
[[nodiscard]] SceneResult exploreHeaps(Renderer& method, Random& random);                ///< S22
[[nodiscard]] SceneResult throwAgainstPlate(Renderer& method, Random& random);           ///< S23
[[nodiscard]] SceneResult putPegIntoHole(Renderer& method, Random& random);              ///< S24
[[nodiscard]] SceneResult dragAlongComb(Renderer& method, Random& random);               ///< S25
[[nodiscard]] SceneResult standOnOneAnother(Renderer& method, Random& random);           ///< S26
[[nodiscard]] SceneResult squeezeAgainstWall(Renderer& method, Random& random);          ///< S27
[[nodiscard]] SceneResult passMomentumOn(Renderer& method, Random& random);              ///< S28
[[nodiscard]] SceneResult pinchAndLift(Renderer& method, Random& random);                ///< S29
[[nodiscard]] SceneResult fillBowl(Renderer& method, Random& random);                    ///< S30
[[nodiscard]] SceneResult crushBetweenBoxes(Renderer& method, Random& random);           ///< S31
[[nodiscard]] SceneResult strokeFoldedMeshes(Renderer& method, Random& random);          ///< S32
[[nodiscard]] SceneResult strokeFlushBoxes(Renderer& method, Random& random);            ///< S33
[[nodiscard]] SceneResult strokeCrackedMeshes(Renderer& method, Random& random);         ///< S34
[[nodiscard]] SceneResult strokeMovingSeams(Renderer& method, Random& random);           ///< S35
[[nodiscard]] SceneResult drivePastStillHip(Renderer& method, Random& random);           ///< S36
[[nodiscard]] SceneResult streamUnderStillHip(Renderer& method, Random& random);         ///< S37
[[nodiscard]] SceneResult editInSmallSteps(Renderer& method, Random& random);            ///< S38
[[nodiscard]] SceneResult strokeMirroredBodies(Renderer& method, Random& random);        ///< S39
[[nodiscard]] SceneResult putBodies(Renderer& method, Random& random);                   ///< S40
// As reported in public, of which S33 to S40 draw what is alike.
[[nodiscard]] SceneResult strokeTilesAsReported(Renderer& method, Random& random);   ///< P1
[[nodiscard]] SceneResult strokeCracksAsReported(Renderer& method, Random& random);  ///< P2
[[nodiscard]] SceneResult feelRoomsAndHollows(Renderer& method, Random& random);     ///< P3
[[nodiscard]] SceneResult strokeMirroredBall(Renderer& method, Random& random);      ///< P4
[[nodiscard]] SceneResult meetThinWalls(Renderer& method, Random& random);           ///< P5
[[nodiscard]] SceneResult growUnderTheHand(Renderer& method, Random& random);        ///< P6
[[nodiscard]] SceneResult standAsReported(Renderer& method, Random& random);         ///< P7
[[nodiscard]] SceneResult putBoardsAsReported(Renderer& method, Random& random);     ///< P8
[[nodiscard]] SceneResult slideAsReported(Renderer& method, Random& random);         ///< P9

/// Of S23 to S25, as MovingWorld::spoils.
inline void (*spoilsTool)(ToolResult& result) = nullptr;

inline constexpr std::array kFailureScenes{
    FailureScene{"S1", "slide off a cube, 2 mm deep", slideOffCube},
    FailureScene{"S2", "slide along a floor into a box that stands on it", slideIntoBox},
    FailureScene{"S3", "cross a comb with gaps of 0.5 mm, 1 mm a tick", crossComb},
    FailureScene{"S4", "box, cube and plate move through a still point", moveThroughStillHip},
    FailureScene{"S5", "segments aimed at vertices, edges and diagonals", aimAtVerticesAndEdges},
    FailureScene{"S6", "fans of 8 to 4096 triangles", strokeFans},
    FailureScene{"S7", "fine sphere, 40 mm deep, 5 m/s", runDeepAndFast},
    FailureScene{"S8", "cube, to within 1 mm of its side", approachMedialAxis},
    FailureScene{"S9", "plates of 0.5 and 1 mm pressed 5 mm and slid", pressThinPlates},
    FailureScene{"S10", "sphere, 2 mm deep at 0.1 m/s: steps of the force", slideOverSphere},
    FailureScene{"S11", "holes, T-junctions, fins, duplicate, flipped, empty and unwelded faces", strokeBadMeshes},
    FailureScene{"S12", "blades, gashes, slivers, and all of it scaled", strokeSharpAndScaledShapes},
    FailureScene{"S13", "gratings under every device and the light hand: limit cycles", restOnGratings,
                 Concern::kSurfaces},
    FailureScene{"S14", "force shading of coarse facets, and deeper than it reaches", strokeShadedFacets,
                 Concern::kSurfaces},
    FailureScene{"S15", "a slide with friction under a tremor", slideWithTremor, Concern::kSurfaces},
    FailureScene{"S16", "soft bodies that move more in a tick than the hand is below them", yieldToTheHand,
                 Concern::kSoftness},
    FailureScene{"S17", "edits under the hand: steps of the force", editUnderTheHand, Concern::kEdits},
    FailureScene{"S18", "S4 and the dropped body of S17 with bodies that the step moves", meetMovingBodies,
                 Concern::kMotion},
    FailureScene{"S19", "S17 on a body that the hand moves", editMovingBodies, Concern::kMotion},
    FailureScene{"S20", "a hand wanders among bodies that move and are edited", wanderAmongMovingBodies,
                 Concern::kMotion},
    FailureScene{"S21", "1,000 long triangles and walls, pressed, stroked and crossed at 0.1 to 5 m/s", exploreSoups},
    FailureScene{"S22", "256 boxes with every feature in one place", exploreHeaps},
    FailureScene{"S23", "a tool of 1,000 points against a thin plate at 2 m/s and 20 rad/s", throwAgainstPlate,
                 Concern::kMotion},
    FailureScene{"S24", "a peg into a hole, turned, pushed aside and pulled out", putPegIntoHole, Concern::kMotion},
    FailureScene{"S25", "a bar along a comb finer than its points", dragAlongComb, Concern::kMotion},
    FailureScene{"S26", "five bricks on one another for 60 s, and a poke", standOnOneAnother, Concern::kBodies},
    FailureScene{"S27", "a brick squeezed between the hand and a wall", squeezeAgainstWall, Concern::kBodies},
    FailureScene{"S28", "a pushed brick pushes others: their momentum", passMomentumOn, Concern::kBodies},
    FailureScene{"S29", "two hands pinch a brick and lift it for 60 s", pinchAndLift, Concern::kMotion},
    FailureScene{"S30", "32 marbles and blocks let into a bowl", fillBowl, Concern::kBodies},
    FailureScene{"S31", "boxes close on the IHIP from all sides", crushBetweenBoxes},
    FailureScene{"S32", "closed meshes that pass through themselves, fixed, moving and dented", strokeFoldedMeshes},
    FailureScene{"S33", "boxes side by side, flush by their decimal sizes, stroked across and along the seams",
                 strokeFlushBoxes},
    FailureScene{"S34", "one mesh with a crack thinner than the skin", strokeCrackedMeshes},
    FailureScene{"S35", "S33 and S34 on floors that move and turn", strokeMovingSeams},
    FailureScene{"S36", "thin plates and sheets driven past a hand at rest at up to 1 m/s", drivePastStillHip,
                 Concern::kStreams},
    FailureScene{"S37", "a block driven under the hand by some 60 samples a second", streamUnderStillHip,
                 Concern::kStreams},
    FailureScene{"S38", "a block that grows, rises or stiffens under the hand by small edits", editInSmallSteps,
                 Concern::kEdits},
    FailureScene{"S39", "bodies that a lattice mirrors", strokeMirroredBodies, Concern::kEdits},
    FailureScene{"S40", "bodies put beside, upon and into one another", putBodies, Concern::kBodies},
    FailureScene{"P1", "five boxes, flush, or 1 nm to 0.1 um apart or into one another", strokeTilesAsReported,
                 Concern::kContact, "bullet3 #92, box2d #341, godot #102544, avian #612"},
    FailureScene{"P2", "a block whose top comes in two patches, and a sphere whose last meridian is rounded otherwise",
                 strokeCracksAsReported, Concern::kContact,
                 "tracefinity PR #164, VMF2OBJ #3, three.js #24621, trimesh #1802"},
    FailureScene{"P3", "a room, which is a box inside out, and a hollow in a box", feelRoomsAndHollows,
                 Concern::kContact, "tidy3d PR #1976, xtk #89, admesh #12, trimesh #2082"},
    FailureScene{"P4", "a ball that a lattice mirrors, or turns by half", strokeMirroredBall, Concern::kEdits,
                 "gz-sim #2656, mujoco #3604, bullet3 #4530"},
    FailureScene{"P5", "plates set through a resting hand in steps, and hands of 0.5 to 20 m/s against one",
                 meetThinWalls, Concern::kStreams, "falconunity #1, habitat-sim #274, use-cannon #71"},
    FailureScene{"P6", "a ball that grows and shrinks under the hand, 50 edits a second", growUnderTheHand,
                 Concern::kEdits, "drake #21317, raisim #322, dimple #26, O3DE #2541"},
    FailureScene{"P7", "stacks of bricks, tall ones, thin ones, heavy on light", standAsReported, Concern::kBodies,
                 "cannon-es #177, bullet3 #4202, drake PR #5441, jitterphysics #10, FlaxEngine #15, matter-js #1068"},
    FailureScene{"P8", "boards on blocks narrower than themselves, and weightless ones near others",
                 putBoardsAsReported, Concern::kBodies,
                 "matter-js #1068, IMP-Engine PR #37, tsoding/nothing #195, FlaxEngine #15"},
    FailureScene{"P9", "a slab slides over flush tiles and over fine triangles", slideAsReported, Concern::kBodies,
                 "avian #612, godot #102544, bounce #13, bullet3 #92"},
};

}  // namespace haptics::eval
