#include "common/surface/make_field.h"

#include "common/surface/cellular_field.h"
#include "common/surface/fourier_field.h"
#include "common/surface/grain_field.h"
#include "common/surface/mapped_field.h"
#include "common/surface/noise_field.h"

namespace haptics {
namespace {

using Made = Result<std::shared_ptr<const ScalarField>>;

struct Maker {
  const FieldLookup& lookup;

  Made operator()(const FourierFamily& family) const { return std::make_shared<const FourierField>(family); }
  Made operator()(const NoiseFamily& family) const { return std::make_shared<const NoiseField>(family); }
  Made operator()(const CellularFamily& family) const { return std::make_shared<const CellularField>(family); }
  Made operator()(const GrainFamily& family) const { return std::make_shared<const GrainField>(family); }
  Made operator()(const MappedFamily& family) const {
    auto field = lookup(family.field);
    if (!field) return refused("field", "no scalar field " + family.field.hex() + " is held here");
    return makeMappedField(std::move(field), family.mapping);
  }
};

}  // namespace

Result<std::shared_ptr<const ScalarField>> makeField(const FieldFamily& family, const FieldLookup& lookup) {
  return std::visit(Maker{lookup}, family);
}

}  // namespace haptics
