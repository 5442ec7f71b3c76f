#include "haptic_server/engine/step/energy_account.h"

#include <bit>
#include <cstring>

namespace haptics {

void EnergyAccount::attribute(std::uint64_t object, EnergyFeature feature, double given_J) noexcept {
  ObjectEnergy& row = rowOf(object);
  const auto i = static_cast<std::size_t>(feature);
  row.given_J[i] += given_J;
  row.given_J[0] -= given_J;
  all_[i] += given_J;
  all_[0] -= given_J;
}

void EnergyAccount::give(std::uint64_t object, double given_J) noexcept {
  rowOf(object).given_J[0] += given_J;
  rows_.items[row_].given_J[0] -= given_J;
}

void EnergyAccount::copyTo(EnergyState& state) const noexcept {
  state.objectCount = rows_.count;
  std::ranges::copy(rows_.all(), state.object.begin());
}

bool EnergyAccount::isWhole() const noexcept {
  return row_ < std::max<std::uint64_t>(1, rows_.count) && heldParts_ >> parts_.size() == 0;
}

void EnergyAccount::turnTo(std::uint64_t object) noexcept {
  row_ = static_cast<std::uint64_t>(&rowOf(object) - rows_.items.data());
}

/// The object's row; where it has none and all are taken, that of the object which gave least is its from now on.
ObjectEnergy& EnergyAccount::rowOf(std::uint64_t object) noexcept {
  const auto known = std::ranges::find(rows_.all(), object, &ObjectEnergy::object);
  if (known != rows_.all().end()) return *known;
  if (rows_.count < rows_.capacity()) {
    ObjectEnergy& row = rows_[rows_.count++];
    row = {object, {}};
    return row;
  }
  auto& rows = rows_.items;
  const auto touchedNow = rows.begin() + row_;
  auto least = rows.begin() + (row_ == 0 ? 1 : 0);
  for (auto row = rows.begin(); row != rows.end(); ++row) {
    if (row != touchedNow && row->largest_J() < least->largest_J()) least = row;
  }
  *least = {object, {}};
  return *least;
}

void EnergyAccount::giveParts(Vec3 way) noexcept {
  ObjectEnergy& row = rows_[row_];
  for (std::uint64_t rest = heldParts_; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(rest));
    const double given_J = glm::dot(parts_[i], way);
    if (i != static_cast<std::size_t>(EnergyFeature::kWrench)) row.given_J[i] += given_J;
    row.given_J[0] -= given_J;
    all_[i] += given_J;
    all_[0] -= given_J;
  }
}

}  // namespace haptics
