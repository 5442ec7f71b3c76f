#include "haptic_server/step/energy_account.h"

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

void EnergyAccount::describe(EnergyState& state) const noexcept {
  state.objectCount = count_;
  std::copy_n(rows_.begin(), count_, state.object.begin());
}

void EnergyAccount::copyInUse(const EnergyAccount& other) noexcept {
  const std::size_t rows = std::max<std::size_t>(1, other.count_) * sizeof(ObjectEnergy);
  std::memcpy(static_cast<void*>(this), &other, offsetof(EnergyAccount, rows_) + rows);
}

bool EnergyAccount::isWhole() const noexcept {
  return count_ <= rows_.size() && row_ < std::max<std::uint32_t>(1, count_) && heldParts_ >> parts_.size() == 0;
}

void EnergyAccount::turnTo(std::uint64_t object) noexcept {
  row_ = static_cast<std::uint32_t>(&rowOf(object) - rows_.data());
}

/// The object's row; where it has none and all are taken, that of the object which gave least is its from now on.
ObjectEnergy& EnergyAccount::rowOf(std::uint64_t object) noexcept {
  const auto end = rows_.begin() + count_;
  const auto known = std::find_if(rows_.begin(), end, [&](const ObjectEnergy& row) { return row.object == object; });
  if (known != end) return *known;
  if (count_ < rows_.size()) {
    ObjectEnergy& row = rows_[count_++];
    row = {object, {}};
    return row;
  }
  const auto touchedNow = rows_.begin() + row_;
  auto least = rows_.begin() + (row_ == 0 ? 1 : 0);
  for (auto row = rows_.begin(); row != rows_.end(); ++row) {
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
    row.given_J[i] += given_J;
    row.given_J[0] -= given_J;
    all_[i] += given_J;
    all_[0] -= given_J;
  }
}

}  // namespace haptics
