// The verbs below fuzz.

#include <algorithm>
#include <functional>
#include <string>

#include "tests/eval/methods.h"
#include "tests/eval/verb_options.h"
#include "tests/eval/verbs.h"

namespace haptics::eval {
namespace {

/// A verb that draws scenes, each from its own seed.
Command addFuzzVerb(Command& fuzz, Arguments& arguments, Verb of,
                    const std::function<bool(const FuzzOptions& options, const std::filesystem::path& out)>& run) {
  const std::string notes = std::string(of.notes) + "Ctrl-C ends it early: what was found is written.";
  of.notes = notes.c_str();
  Command verb = addVerb(fuzz, of, arguments.out, std::string("fuzz ") + of.name);
  addSeed(verb, arguments.fuzz.seed);
  addCount(verb, "--scenes", arguments.fuzz.scenes, "How many, each drawn from its own seed, from --seed on");
  setRun(verb, [&arguments, run] { arguments.good = run(arguments.fuzz, arguments.out); });
  return verb;
}

void addSpeed(Command& verb, Arguments& arguments, const char* about) {
  verb.option("--speed", arguments.fuzz.speed_m_per_s, about).typeName("V").check(moreThanZero());
}

void addMoving(Command& verb, Arguments& arguments) {
  verb.option(
          "--moving",
          [&arguments](const std::string& which) -> Result<void> {
            if (which != "both") arguments.fuzz.moving = which == "yes";
            return {};
          },
          "Bodies that move through each other, bodies at rest, or both by turns")
      .oneOf({"yes", "no", "both"})
      .typeName("WHICH");
}

void addFuzzContact(Command& fuzz, Arguments& arguments) {
  Command verb = addFuzzVerb(
      fuzz, arguments,
      {"contact", "The contact core among random bodies: is the IHIP ever inside one, or through a sheet?",
       "--scenes 40000 --out results",
       "A scene has 2,000 ticks. Bodies at rest and moving, at up to 1 and 4 m/s, in five kinds of worlds, come by\n"
       "turns: 40,000 scenes are 2,000 of each of the twenty, 80 million ticks. "},
      [&method = arguments.fuzzMethod](const FuzzOptions& options, const std::filesystem::path& out) {
        return method.empty() ? runFuzzContact(options, out)
                              : runFuzzContactOf(findMethod(method, methods()), options, out);
      });
  addMoving(verb, arguments);
  addSpeed(verb, arguments, "Top speed of the HIP in m/s; 1 and 4 by turns when left out");
  verb.option(
          "--world",
          [&arguments](const std::string& name) -> Result<void> {
            const auto* const world = std::ranges::find(kContactWorlds, name);
            arguments.fuzz.world = static_cast<ContactWorld>(world - kContactWorlds.begin());
            return {};
          },
          "Bodies of any kind, floors of flush boxes or cracked meshes, mirrored bodies, or thin plates; all by turns "
          "when left out")
      .oneOf({kContactWorlds.begin(), kContactWorlds.end()})
      .typeName("WORLD");
  addMethod(verb, arguments.fuzzMethod, "In place of the contact core: a baseline, ./FILE.so or 'python3 FILE.py'");
}

/// Of those that have no options but seed and number.
void addPlainVerbs(Command& fuzz, Arguments& arguments) {
  addFuzzVerb(
      fuzz, arguments,
      {"edits", "Edits under a hand at rest: does the force step, is the IHIP inside of something, is the edit felt?",
       "--scenes 5000 --out results",
       "A scene has 12 edits. Rates, devices, the stabiliser, softness, textures, friction, shading and bodies\n"
       "that the step moves come at random. "},
      runFuzzEdits);
  addFuzzVerb(
      fuzz, arguments,
      {"replay-live",
       "Recordings of a servo under random edits: does each replay bit for bit, and from every state in it?",
       "--scenes 2000 --out results",
       "A world has 20 s of virtual time at a random rate, with one hand or two, devices that fail, ticks that\n"
       "are missed, and edits of every property. "},
      runFuzzReplayLive);
  addFuzzVerb(
      fuzz, arguments,
      {"bodies", "Bodies that meet: does what stands stand, and is any deep in another?", "--scenes 2000 --out results",
       "A world has 3 s: a stack that stands by statics, one put into or above itself, a heap, or bodies that\n"
       "float. "},
      runFuzzBodies);
  addFuzzVerb(fuzz, arguments,
              {"deformed-edits", "Edits with degenerate numbers, and what deforms after them: is every force finite?",
               "--scenes 20000 --out results",
               "A world has ten edits, each felt for 30 ms. Made for builds with sanitizers.\n"},
              runFuzzDeformedEdits);
  addFuzzVerb(fuzz, arguments,
              {"prices", "Edits of any size: does each keep to the price that it has before it begins?",
               "--scenes 500 --out results",
               "A world has ten edits. Times are of the processor; a world that fails is run twice more.\n"},
              runFuzzPrices);
}

void addFuzzStream(Command& fuzz, Arguments& arguments) {
  Command verb = addFuzzVerb(
      fuzz, arguments,
      {"stream", "Bodies that are driven under a hand: does any pass it, and is the force what it should be?",
       "--scenes 500 --out results",
       "A world has 4,000 ticks; a third are of thin plates. Poses come in every tick, or every 8, 16 or 33 ticks,\n"
       "a little early or late. "},
      runFuzzStream);
  addSpeed(verb, arguments, "Top speed of the HIP in m/s; 1 when left out");
}

void addFuzzTools(Command& fuzz, Arguments& arguments) {
  Command verb = addFuzzVerb(fuzz, arguments,
                             {"tools", "Random tools in the hand: is a vertex of one deeper than 10 um in a body?",
                              "--scenes 1000 --out results", "A scene has 1,500 ticks after the way there. "},
                             runFuzzTools);
  addMoving(verb, arguments);
  addSpeed(verb, arguments, "Top speed of the tool in m/s; 1 when left out");
}

void addFuzzReplay(Command& fuzz, Arguments& arguments) {
  Command verb = addVerb(fuzz,
                         {"replay", "A finding again: does it still fail?", "results/fuzz-inside-1095",
                          "fuzz contact and fuzz edits write such folders for what they find."},
                         arguments.out, "fuzz replay");
  verb.option("FOLDER", arguments.fuzzRecording, "A finding's folder").required().existingFolder();
  setRun(verb, [&arguments] { arguments.good = runFuzzReplay(arguments.fuzzRecording, arguments.out); });
}

}  // namespace

void addFuzz(Command& app, Arguments& arguments) {
  Command verb = app.verb("fuzz", "Random scenes and motions against an independent judge");
  verb.needVerb();
  verb.footer(
      "Examples:\n  haptic_eval fuzz contact --scenes 40000 --out results\n"
      "  haptic_eval fuzz edits --scenes 5000 --out results\n"
      "  haptic_eval fuzz replay-live --scenes 2000 --out results\n"
      "  haptic_eval fuzz stream --scenes 500 --out results\n"
      "  haptic_eval fuzz bodies --scenes 2000 --out results\n"
      "  haptic_eval fuzz tools --scenes 1000 --out results\n"
      "  haptic_eval fuzz replay results/fuzz-inside-1095\n"
      "Exit status 1: something was found.");
  for (const auto add : {addFuzzContact, addPlainVerbs, addFuzzStream, addFuzzTools, addFuzzReplay})
    add(verb, arguments);
}

}  // namespace haptics::eval
