#include "tests/eval/methods.h"

#include <array>

#include "tests/eval/ours.h"

namespace haptics::eval {
namespace {

template <class Type>
std::unique_ptr<Renderer> make() {
  return std::make_unique<Type>();
}

constexpr std::array kMethods{
    Method{kOurs, "the production step", make<Ours>},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

}  // namespace haptics::eval
