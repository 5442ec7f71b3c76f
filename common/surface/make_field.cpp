#include "common/surface/make_field.h"

#include "common/surface/cellular_field.h"
#include "common/surface/fourier_field.h"
#include "common/surface/grain_field.h"
#include "common/surface/grown_field.h"
#include "common/surface/layered_field.h"
#include "common/surface/mapped_field.h"
#include "common/surface/noise_field.h"

namespace haptics {
namespace {

using Made = Result<std::shared_ptr<const ScalarField>>;

struct Maker {
  const FieldLookup& lookup;
  const PointFieldLookup& pointLookup;

  Made operator()(const FourierFamily& family) const { return std::make_shared<const FourierField>(family); }
  Made operator()(const NoiseFamily& family) const { return std::make_shared<const NoiseField>(family); }
  Made operator()(const CellularFamily& family) const { return std::make_shared<const CellularField>(family); }
  Made operator()(const GrainFamily& family) const { return std::make_shared<const GrainField>(family); }
  Made operator()(const MappedFamily& family) const {
    auto field = lookup(family.field);
    if (!field) return refused("field", "no scalar field " + family.field.hex() + " is held here");
    return makeMappedField(std::move(field), family.mapping);
  }
  Made operator()(const GrownFamily& family) const {
    auto points = pointLookup ? pointLookup(family.points) : nullptr;
    if (!points) return refused("grown", "no point field " + family.points.hex() + " is held here");
    return std::make_shared<const GrownField>(std::move(points));
  }
  Made operator()(const LayeredFamily& family) const {
    std::vector<LayeredField::Layer> layers;
    for (const FieldLayer& layer : family.layers) {
      auto field = makeField(layer.family, lookup, pointLookup);
      if (!field) return tl::unexpected<Error>(std::move(field.error()).within(layerField(layers.size())));
      layers.push_back({layer.weight, *std::move(field)});
    }
    return std::make_shared<const LayeredField>(family.combination, std::move(layers));
  }
};

}  // namespace

Result<std::shared_ptr<const ScalarField>> makeField(const FieldFamily& family, const FieldLookup& lookup,
                                                     const PointFieldLookup& pointLookup) {
  return std::visit(Maker{lookup, pointLookup}, family);
}

}  // namespace haptics
